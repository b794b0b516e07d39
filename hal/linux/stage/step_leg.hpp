#pragma once
/// One way of the stage in one direction: steps on absolute deadlines.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>

#include "hal/linux/stage/stage_lines.hpp"
#include "hal/ramp.hpp"
#include "hal/units.hpp"

namespace plumbline {

/// What ends a leg before its last step.
enum class LegUntil : std::uint8_t {
  kDone,      ///< nothing. On the way up the end stop must not be met
  kPressed,   ///< the end stop closes
  kReleased,  ///< it opens
};

enum class StepLegEnd : std::uint8_t {
  kDone,      ///< all steps were taken
  kSwitched,  ///< what it waited for
  kMetStop,   ///< the end stop closed in a leg that was not to meet it
  kStopped,   ///< asked to
  kFailed,    ///< a line could not be set; errno has the reason
};

struct StepLegResult {
  StepLegEnd end = StepLegEnd::kDone;
  std::int64_t switched = 0;  ///< kSwitched, kMetStop: the count of steps at the first contact
};

/// How well the deadlines were kept, since it was last taken.
struct StepRecord {
  std::uint64_t steps = 0;
  std::uint64_t late = 0;            ///< later than half of the time to the next step, and than 100 us
  std::uint64_t restarts = 0;        ///< so late that the motor stood: the rest of the leg got a ramp of its own
  std::chrono::nanoseconds worst{};  ///< lateness
};

/// Takes the steps of a leg, in the calling thread.
///
/// Step k is due when the ramp has covered k steps: absolute times, so that lateness does not add up. After a late step the next
/// ones follow by at most a quarter faster than the ramp until they are on time again: a burst would lose steps. After a pause
/// in which the motor came to stand, the rest of the leg is a new ramp.
class StepLegs {
 public:
  using Time = std::chrono::nanoseconds;
  static constexpr Time kConfirm = std::chrono::milliseconds(1);       ///< the end stop is believed after it
  static constexpr Time kMotorStands = std::chrono::milliseconds(10);  ///< a motor has stopped in such a pause

  /// @param step_mm  of travel, above 0
  StepLegs(StageLines& lines, double step_mm, Acceleration acceleration)
      : lines_(lines), step_mm_(step_mm), acceleration_(acceleration) {}

  /// @param steps  above 0: up
  /// @param start  when the ramp begins, CLOCK_MONOTONIC: now or a little before
  StepLegResult run(std::int64_t steps, Speed speed, LegUntil until, Time start);

  /// From any thread: the leg that runs slows down and ends. Holds until forget_stop().
  void stop() { stop_.store(true, std::memory_order_relaxed); }
  void forget_stop() { stop_.store(false, std::memory_order_relaxed); }
  bool stopping() const { return stop_.load(std::memory_order_relaxed); }

  /// Steps taken up less those taken down, since the program began; from any thread.
  std::int64_t count() const { return count_.load(std::memory_order_relaxed); }
  /// The latest end of the leg that runs, where it was put off by lateness; from any thread.
  Time put_off() const { return Time(put_off_.load(std::memory_order_relaxed)); }
  void forget_put_off() { put_off_.store(0, std::memory_order_relaxed); }
  /// Of legs that have ended; the next one begins from nothing. Not while a leg runs.
  StepRecord take_record() { return std::exchange(record_, StepRecord()); }

 private:
  class Watch;

  StageLines& lines_;
  double step_mm_;
  Acceleration acceleration_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> count_{0};
  std::atomic<std::int64_t> put_off_{0};
  StepRecord record_;
};

}  // namespace plumbline
