#include "hal/linux/stage/step_leg.hpp"

#include <algorithm>
#include <cmath>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/gpio/edges.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

/// A step counts as late only above this, so that the scheduler's jitter isn't counted at high speeds. Affects the record only.
constexpr std::chrono::nanoseconds kMinLateness = std::chrono::microseconds(100);

std::chrono::nanoseconds whole(Ramp::Seconds time) { return std::chrono::round<std::chrono::nanoseconds>(time); }

}  // namespace

/// Watches the end stop during a leg. It counts as switched once it has kept the wanted state for kConfirm; the position is that of
/// the first contact. A line that changes as fast as it is read never counts and delays no step.
class StepLegs::Watch {
 public:
  Watch(StageLines& lines, bool wanted) : lines_(lines), wanted_(wanted) {
    for_each_edge(lines_, [](const StageLines::Edge&) {});  // left from earlier legs
  }

  /// @param count    steps counted now
  /// @param before   steps counted before the last step
  /// @param stepped  when the last step was taken
  /// @returns whether the end stop has switched
  bool confirm(Time now, std::int64_t count, std::int64_t before, Time stepped) {
    const bool rests = for_each_edge(lines_, [&](const StageLines::Edge& edge) {
      if (edge.pressed != wanted_) {
        seen_ = false;
      } else if (!seen_) {
        begin(edge.at, edge.at < stepped ? before : count);
      }
    });
    if (!rests || lines_.pressed() != wanted_) {
      seen_ = false;
      return false;
    }
    if (!seen_) begin(now, count);
    return now - began_ >= kConfirm;
  }
  std::int64_t switched_at() const { return switched_at_; }

 private:
  void begin(Time at, std::int64_t place) {
    seen_ = true;
    began_ = at;
    switched_at_ = place;
  }

  StageLines& lines_;
  bool wanted_;
  bool seen_ = false;
  Time began_{};
  std::int64_t switched_at_ = 0;
};

StepLegResult StepLegs::run(std::int64_t steps, Speed speed, LegUntil until, Time start) {
  const bool up = steps > 0;
  const std::int64_t direction = up ? 1 : -1;
  std::int64_t total = std::abs(steps);
  StepLegResult result;
  if (total == 0) return result;
  if (!lines_.set_direction(up)) return {.end = StepLegEnd::kFailed};

  const bool watching = up || until != LegUntil::kDone;
  Watch watch(lines_, until != LegUntil::kReleased);
  const auto ramp_for = [&](std::int64_t count) {
    return Ramp(Distance::nanometres(std::llround(static_cast<double>(count) * step_mm_ * 1e6)), speed, acceleration_);
  };
  Ramp ramp = ramp_for(total);
  std::int64_t base = 0;  // steps before the ramp
  bool slowing = false;
  Time last = start;  // step taken
  Time last_due = start;
  for (std::int64_t done = 0; done < total;) {
    if (!slowing && (stopping() || result.end != StepLegEnd::kDone)) {
      slowing = true;
      if (result.end == StepLegEnd::kDone) result.end = StepLegEnd::kStopped;
      ramp = ramp.stopped_at(monotonic_now() - start);
      total = std::clamp(base + static_cast<std::int64_t>(ramp.length_mm() / step_mm_), done, total);
      continue;
    }
    const auto due = start + whole(ramp.time_at_mm(static_cast<double>(done - base + 1) * step_mm_));
    // 4/5 of the ramp's interval is a quarter faster. Less would catch up sooner, but risks lost steps.
    sleep_until_monotonic(std::max(due, last + (due - last_due) * 4 / 5));
    const Time now = monotonic_now();
    const Time late = now - due;
    if (late > kMotorStands && done > base && !slowing) {
      ++record_.standstills;
      record_.worst = std::max(record_.worst, late);
      base = done;
      start = now;
      last = now;
      last_due = now;
      ramp = ramp_for(total - done);
      delayed_end_.store((start + whole(ramp.duration())).count(), std::memory_order_relaxed);
      continue;
    }
    if (!lines_.step()) return {.end = StepLegEnd::kFailed};
    ++done;
    const auto count = count_.load(std::memory_order_relaxed) + direction;
    count_.store(count, std::memory_order_relaxed);
    ++record_.steps;
    if (late > std::max(kMinLateness, (due - last_due) / 2)) ++record_.late;
    record_.worst = std::max(record_.worst, late);
    last = now;
    last_due = due;
    if (watching && result.end == StepLegEnd::kDone && watch.confirm(now, count, count - direction, now)) {
      result.end = until == LegUntil::kDone ? StepLegEnd::kMetStop : StepLegEnd::kSwitched;
      result.switched = watch.switched_at();
    }
  }
  return result;
}

}  // namespace plumbline::inline hal::inline linux_board
