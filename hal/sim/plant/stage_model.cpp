#include "hal/sim/plant/stage_model.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace plumbline::inline hal::inline sim {
namespace {

TimePoint after(TimePoint start, Ramp::Seconds time) {
  return start + nanoseconds(static_cast<nanoseconds::rep>(std::ceil(time.count() * 1e9)));
}

Distance magnitude(Distance distance) { return distance < Distance() ? -distance : distance; }

}  // namespace

TimePoint StageModel::Leg::passes(Distance height) const {
  return after(began, ramp.time_at_mm(magnitude(height - from).millimetres()));
}

Distance StageModel::rounded(Distance distance) const {
  const auto step = build_.step.nanometres();
  const auto half = distance < Distance() ? -step / 2 : step / 2;
  return Distance::nanometres((distance.nanometres() + half) / step * step);
}

Distance StageModel::stepped(double distance_mm) const {
  const Distance distance = rounded(Distance::millimetres(distance_mm));
  return up_ ? distance : -distance;
}

Distance StageModel::moved() const {
  return moving_ ? stepped(ramp_.travelled_mm(timeline_.now() - began_)) : Distance();
}

Distance StageModel::height() const { return height_ + moved(); }

TimePoint StageModel::ends_at() const { return moving_ ? after(began_, ramp_.duration()) : timeline_.now(); }

bool StageModel::end_stop_pressed() const {
  if (end_stop_stuck) return true;
  return !end_stop_dead && height() >= build_.end_stop;
}

void StageModel::start(Distance distance, Speed speed, Acceleration acceleration, StageSwitch until,
                       std::function<void(const LegResult&)> on_rest) {
  assert(!moving_);
  distance_ = rounded(distance);
  up_ = distance_ > Distance();
  ramp_ = Ramp(magnitude(distance_), speed, acceleration);
  until_ = until;
  on_rest_ = std::move(on_rest);
  began_ = timeline_.now();
  stopped_ = false;
  edge_ = false;
  moving_ = true;
  schedule();
}

// Schedules the leg's next event: a stall, an edge of the end stop, or its end.
void StageModel::schedule() {
  timeline_.cancel(due_);
  TimePoint when = after(began_, ramp_.duration());
  auto what = [this] { end(edge_ ? LegEnd::kSwitched : stopped_ ? LegEnd::kStopped : LegEnd::kComplete); };
  due_ = timeline_.at(when, what);
  const auto sooner = [&](double distance_mm, auto&& happens) {
    if (distance_mm > ramp_.length_mm()) return;
    const TimePoint then = after(began_, ramp_.time_at_mm(std::max(0.0, distance_mm)));
    if (then >= when) return;
    timeline_.cancel(due_);
    due_ = timeline_.at(then, happens);
    when = then;
  };
  if (stalls_at <= 1) {
    sooner(stalls_at * magnitude(distance_).millimetres(), [this] {
      stalls_at = 2;
      end(LegEnd::kStalled);
    });
  }
  if (up_) sooner((build_.upper_end - height_).millimetres(), [this] { end(LegEnd::kStalled); });
  if (until_ == StageSwitch::kNone || edge_) return;
  const auto on_edge = [this] {
    edge_ = true;
    switched_ = moved();
    ramp_ = ramp_.stopped_at(timeline_.now() - began_);
    schedule();
  };
  const bool wanted = until_ == StageSwitch::kPressed;
  const double to_switch = (build_.end_stop - height_).millimetres();
  if (end_stop_pressed() == wanted) {
    sooner(0, on_edge);
  } else if (!end_stop_stuck && !end_stop_dead && up_ == wanted) {
    sooner(up_ ? to_switch : -to_switch, on_edge);
  }
}

void StageModel::stop() {
  if (!moving_ || stopped_) return;
  stopped_ = true;
  ramp_ = ramp_.stopped_at(timeline_.now() - began_);
  schedule();
}

void StageModel::cut() {
  if (!moving_) return;
  on_rest_ = nullptr;
  end(LegEnd::kStalled);
}

void StageModel::end(LegEnd how) {
  timeline_.cancel(due_);
  const Distance distance = how == LegEnd::kComplete ? distance_ : moved();
  const LegResult result{
      .end = how, .moved = distance, .switched = edge_ ? switched_ : distance, .at = timeline_.now()};
  const Distance from = height_;
  moving_ = false;
  height_ = height_ + distance;
  if (how == LegEnd::kComplete && skips != Distance()) height_ = height_ - std::exchange(skips, Distance());
  if (on_leg) on_leg(Leg{.began = began_, .from = from, .to = height_, .ramp = ramp_, .until = until_, .end = how});
  if (on_rest_) {
    const auto on_rest = std::exchange(on_rest_, nullptr);
    on_rest(result);
  }
}

}  // namespace plumbline::inline hal::inline sim
