#pragma once
/// One leg of a motion: steps in one direction on absolute deadlines.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>

#include "hal/linux/stage/stage_lines.hpp"
#include "hal/ramp.hpp"
#include "hal/units.hpp"

namespace plumbline::inline hal::inline linux_board {

/// What ends a leg early.
enum class LegUntil : std::uint8_t {
  kDone,      ///< nothing. On the way up, meeting the end stop is an error
  kPressed,   ///< the end stop closes
  kReleased,  ///< it opens
};

enum class StepLegEnd : std::uint8_t {
  kDone,      ///< all steps were taken
  kSwitched,  ///< the end stop switched as wanted
  kMetStop,   ///< the end stop closed unexpectedly
  kStopped,   ///< by stop()
  kFailed,    ///< a line could not be set; errno is set
};

struct StepLegResult {
  StepLegEnd end = StepLegEnd::kDone;
  std::int64_t switched = 0;  ///< kSwitched, kMetStop: counted steps at the first contact
};

/// How well the deadlines were met since the last StepLegs::take_record().
struct StepRecord {
  std::uint64_t steps = 0;
  std::uint64_t late = 0;            ///< later than half of the time to the next step, and than 100 us
  std::uint64_t standstills = 0;     ///< pauses in which the motor stopped, each followed by a new ramp
  std::chrono::nanoseconds worst{};  ///< lateness
};

/// Takes the steps of a leg in the calling thread.
///
/// Step k is due when the ramp has covered k steps. These times are absolute, so lateness doesn't add up. After a late step the
/// next ones catch up at most a quarter faster than the ramp, because a burst would lose steps. After a pause in which the motor
/// came to a stop, the rest of the leg is a new ramp.
class StepLegs {
 public:
  using Time = std::chrono::nanoseconds;
  /// How long the end stop must keep its state. Longer rejects more interference, but costs as much travel past the switch.
  static constexpr Time kConfirm = std::chrono::milliseconds(1);
  /// A motor counts as stopped after a pause this long. Shorter wastes time on new ramps, longer risks lost steps.
  static constexpr Time kMotorStands = std::chrono::milliseconds(10);

  /// @param step_mm  mm of travel for a step, above 0
  StepLegs(StageLines& lines, double step_mm, Acceleration acceleration)
      : lines_(lines), step_mm_(step_mm), acceleration_(acceleration) {}

  /// @param steps  positive is up
  /// @param start  start of the ramp, CLOCK_MONOTONIC: now or slightly earlier
  StepLegResult run(std::int64_t steps, Speed speed, LegUntil until, Time start);

  /// Brakes and ends the running leg, and each later one until clear_stop(). From any thread.
  void stop() { stop_.store(true, std::memory_order_relaxed); }
  void clear_stop() { stop_.store(false, std::memory_order_relaxed); }
  bool stopping() const { return stop_.load(std::memory_order_relaxed); }

  /// Steps up less steps down since the program started. From any thread.
  std::int64_t count() const { return count_.load(std::memory_order_relaxed); }
  /// The expected end of the running leg if a pause has delayed it, else 0. From any thread.
  Time delayed_end() const { return Time(delayed_end_.load(std::memory_order_relaxed)); }
  void clear_delayed_end() { delayed_end_.store(0, std::memory_order_relaxed); }
  /// Returns the record of all finished legs and resets it. @pre no leg runs
  StepRecord take_record() { return std::exchange(record_, StepRecord()); }

 private:
  class Watch;

  StageLines& lines_;
  double step_mm_;
  Acceleration acceleration_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> count_{0};
  std::atomic<std::int64_t> delayed_end_{0};
  StepRecord record_;
};

}  // namespace plumbline::inline hal::inline linux_board
