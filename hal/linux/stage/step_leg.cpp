#include "hal/linux/stage/step_leg.hpp"

#include <algorithm>
#include <cmath>

#include "hal/linux/events/linux_clock.hpp"
#include "hal/linux/gpio/edges.hpp"

namespace plumbline {
namespace {

constexpr std::chrono::nanoseconds kAlwaysOnTime = std::chrono::microseconds(100);

std::chrono::nanoseconds whole(Ramp::Seconds time) { return std::chrono::round<std::chrono::nanoseconds>(time); }

}  // namespace

/// The end stop in a leg, believed when it has been as waited for without a break for kConfirm. What counts is where it began.
/// A line that changes as fast as it is read is not believed, and holds no step.
class StepLegs::Watch {
 public:
  Watch(StageLines& lines, bool wanted) : lines_(lines), wanted_(wanted) {
    see_edges(lines_, [](const StageLines::Edge&) {});  // of former legs
  }

  /// @param count    steps now
  /// @param before   steps before the last one
  /// @param stepped  when the last one was taken
  /// @returns it is believed
  bool look(Time now, std::int64_t count, std::int64_t before, Time stepped) {
    const bool rests = see_edges(lines_, [&](const StageLines::Edge& edge) {
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
  std::int64_t place() const { return place_; }

 private:
  void begin(Time at, std::int64_t place) {
    seen_ = true;
    began_ = at;
    place_ = place;
  }

  StageLines& lines_;
  bool wanted_;
  bool seen_ = false;
  Time began_{};
  std::int64_t place_ = 0;
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
    sleep_until_monotonic(std::max(due, last + (due - last_due) * 4 / 5));
    const Time now = monotonic_now();
    const Time late = now - due;
    if (late > kMotorStands && done > base && !slowing) {
      ++record_.restarts;
      record_.worst = std::max(record_.worst, late);
      base = done;
      start = now;
      last = now;
      last_due = now;
      ramp = ramp_for(total - done);
      put_off_.store((start + whole(ramp.duration())).count(), std::memory_order_relaxed);
      continue;
    }
    if (!lines_.step()) return {.end = StepLegEnd::kFailed};
    ++done;
    const auto count = count_.load(std::memory_order_relaxed) + direction;
    count_.store(count, std::memory_order_relaxed);
    ++record_.steps;
    if (late > std::max(kAlwaysOnTime, (due - last_due) / 2)) ++record_.late;
    record_.worst = std::max(record_.worst, late);
    last = now;
    last_due = due;
    if (watching && result.end == StepLegEnd::kDone && watch.look(now, count, count - direction, now)) {
      result.end = until == LegUntil::kDone ? StepLegEnd::kMetStop : StepLegEnd::kSwitched;
      result.switched = watch.place();
    }
  }
  return result;
}

}  // namespace plumbline
