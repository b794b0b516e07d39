#include "hal/sim/stage_model.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace plumbline {
namespace {

TimePoint after(TimePoint start, Ramp::Seconds time) {
  return start + nanoseconds(static_cast<nanoseconds::rep>(std::ceil(time.count() * 1e9)));
}

Distance magnitude(Distance way) { return way < Distance() ? -way : way; }

}  // namespace

TimePoint StageModel::Leg::passes(Distance height) const {
  return after(began, ramp.time_at_mm(magnitude(height - from).millimetres()));
}

Distance StageModel::rounded(Distance way) const {
  const auto step = build_.step.nanometres();
  const auto half = way < Distance() ? -step / 2 : step / 2;
  return Distance::nanometres((way.nanometres() + half) / step * step);
}

Distance StageModel::stepped(double way_mm) const {
  const Distance way = rounded(Distance::millimetres(way_mm));
  return up_ ? way : -way;
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

void StageModel::start(Distance way, Speed speed, Acceleration acceleration, StageSwitch until,
                       std::function<void(const LegResult&)> on_rest) {
  assert(!moving_);
  way_ = rounded(way);
  up_ = way_ > Distance();
  ramp_ = Ramp(magnitude(way_), speed, acceleration);
  until_ = until;
  on_rest_ = std::move(on_rest);
  began_ = timeline_.now();
  stopped_ = false;
  edge_ = false;
  moving_ = true;
  schedule();
}

// The next thing that happens to the leg: it is blocked, its switch comes, or it is over.
void StageModel::schedule() {
  timeline_.cancel(due_);
  TimePoint when = after(began_, ramp_.duration());
  auto what = [this] { end(edge_ ? LegEnd::kSwitched : stopped_ ? LegEnd::kStopped : LegEnd::kWholeWay); };
  due_ = timeline_.at(when, what);
  const auto sooner = [&](double way_mm, auto&& happens) {
    if (way_mm > ramp_.length_mm()) return;
    const TimePoint then = after(began_, ramp_.time_at_mm(std::max(0.0, way_mm)));
    if (then >= when) return;
    timeline_.cancel(due_);
    due_ = timeline_.at(then, happens);
    when = then;
  };
  if (stalls_at <= 1) {
    sooner(stalls_at * magnitude(way_).millimetres(), [this] {
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
  const Distance way = how == LegEnd::kWholeWay ? way_ : moved();
  const LegResult result{.end = how, .moved = way, .switched = edge_ ? switched_ : way, .at = timeline_.now()};
  const Distance from = height_;
  moving_ = false;
  height_ = height_ + way;
  if (how == LegEnd::kWholeWay && skips != Distance()) height_ = height_ - std::exchange(skips, Distance());
  if (on_leg) on_leg(Leg{.began = began_, .from = from, .to = height_, .ramp = ramp_, .until = until_, .end = how});
  if (on_rest_) {
    const auto on_rest = std::exchange(on_rest_, nullptr);
    on_rest(result);
  }
}

}  // namespace plumbline
