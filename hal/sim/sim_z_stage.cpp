#include "hal/sim/sim_z_stage.hpp"

#include <algorithm>
#include <cmath>

#include "hal/sim/sim_call.hpp"

namespace plumbline::inline hal::inline sim {
namespace {

// As on a board: hal/linux/stage/z_stage.cpp.
constexpr Distance kRelease = 1_mm;
constexpr Distance kOvertravel = 2_mm;

}  // namespace

SimZStage::SimZStage(Plant& plant, Interlock& interlock) : ZStage(plant.settings().travel, interlock), plant_(plant) {}

SimZStage::~SimZStage() { plant_.stage().cut(); }

bool SimZStage::do_homed() const { return homed_; }

bool SimZStage::do_moving() const {
  const SimCall call(plant_);
  return moving_;
}

bool SimZStage::do_end_stop_pressed() const {
  const SimCall call(plant_);
  return plant_.stage().end_stop_pressed();
}

ZPosition SimZStage::do_position() const {
  const SimCall call(plant_);
  return position_ + counted(plant_.stage().moved());
}

TimePoint SimZStage::do_ends_by() const { return ends_by_; }

void SimZStage::begin_report() {
  report_ = {};
  report_.began_at = plant_.now();
  report_.position = position_;
}

Distance SimZStage::built(Distance asked) const {
  const auto& otherwise = plant_.settings().built_otherwise;
  return otherwise ? Distance::micrometres(asked.micrometres() * otherwise->travel_ratio) : asked;
}

Distance SimZStage::counted(Distance travel) const {
  const auto& otherwise = plant_.settings().built_otherwise;
  return otherwise ? Distance::micrometres(travel.micrometres() / otherwise->travel_ratio) : travel;
}

void SimZStage::start(Phase phase, Distance distance, Speed speed, StageSwitch until) {
  phase_ = phase;
  const auto& otherwise = plant_.settings().built_otherwise;
  const Speed true_speed = std::min(speed, limits().fastest) * (otherwise ? std::abs(otherwise->travel_ratio) : 1);
  plant_.start_leg(built(distance), true_speed, until, [this](LegResult leg) {
    leg.moved = counted(leg.moved);
    leg.switched = counted(leg.switched);
    on_rest(leg);
  });
}

Status SimZStage::do_begin_move(ZPosition target, Speed speed) {
  const SimCall call(plant_);
  begin_report();
  moving_ = true;
  stopping_ = false;
  problem_.reset();
  start(Phase::kMove, plant_.stage().rounded(target - position_), speed, StageSwitch::kNone);
  ends_by_ = plant_.stage().ends_at();
  return {};
}

Status SimZStage::do_begin_jog(Distance distance, Speed speed) {
  const SimCall call(plant_);
  begin_report();
  homed_ = false;
  moving_ = true;
  stopping_ = false;
  problem_.reset();
  start(Phase::kJog, distance, speed, StageSwitch::kPressed);
  ends_by_ = plant_.stage().ends_at();
  return {};
}

Status SimZStage::do_begin_homing() {
  const SimCall call(plant_);
  begin_report();
  homed_from_ = position_;
  was_homed_ = std::exchange(homed_, false);
  moving_ = true;
  stopping_ = false;
  problem_.reset();
  const Distance travel = limits().end_stop - limits().lowest + kOvertravel;
  // The whole travel, plus 30 s for the short legs: at most 1 + 2 + 4 mm, of which 5 mm at 0.5 mm/s, and ramps below 1 s.
  ends_by_ = plant_.now() + std::chrono::seconds(30) +
             std::chrono::duration_cast<nanoseconds>(Ramp(travel, kApproachSpeed, limits().acceleration).duration());
  if (!plant_.stage().end_stop_pressed()) {
    start(Phase::kApproach, travel, kApproachSpeed, StageSwitch::kPressed);
  } else if (was_homed_ && position_ < limits().end_stop - kBackOff) {
    fail_motion(Error::format(ErrorCode::kEndStopStuck,
                              "the end stop is pressed, but the stage is elsewhere:\tcheck the switch"));
  } else {
    start(Phase::kRelease, -kRelease, kFindSpeed, StageSwitch::kReleased);
  }
  return {};
}

void SimZStage::finish_motion(bool arrived) {
  moving_ = false;
  report_.position = position_;
  report_.ended_at = plant_.now();
  report_.arrived = arrived;
  plant_.push_event(EventKind::kMotionEnded);
}

void SimZStage::fail_motion(const Error& problem) {
  homed_ = false;
  problem_ = problem;
  finish_motion(false);
}

void SimZStage::on_rest(const LegResult& leg) {
  const ZPosition from = position_;
  position_ = position_ + leg.moved;
  if (leg.end == LegEnd::kStalled && phase_ == Phase::kApproach) {
    fail_motion(Error::format(ErrorCode::kEndStopNotFound,
                              "the stage met its upper end before the end stop:\tcheck switch and cable"));
  } else if (leg.end == LegEnd::kStalled) {
    fail_motion(Error::format(ErrorCode::kStageStalled, "the stage is blocked:\tlook for what is in its way"));
  } else if (leg.end == LegEnd::kStopped || (stopping_ && phase_ != Phase::kMove)) {
    finish_motion(false);
  } else if (phase_ == Phase::kJog) {
    finish_motion(leg.end == LegEnd::kComplete);
  } else if (phase_ == Phase::kMove || phase_ == Phase::kReturn) {
    if (phase_ == Phase::kReturn) {
      homed_ = true;
      report_.began_at_height = began_at_height_;
    }
    finish_motion(true);
  } else {
    position_ = from;
    continue_homing(leg);
  }
}

void SimZStage::continue_homing(const LegResult& leg) {
  const bool switched = leg.end == LegEnd::kSwitched;
  if (phase_ == Phase::kFind && switched) return on_end_stop_found(leg);
  position_ = position_ + leg.moved;
  if (phase_ == Phase::kRelease && !switched) {
    fail_motion(Error::format(ErrorCode::kEndStopStuck, "the end stop stays pressed:\tcheck its switch"));
  } else if (phase_ == Phase::kApproach || phase_ == Phase::kFind) {
    if (!switched) {
      fail_motion(
          Error::format(ErrorCode::kEndStopNotFound,
                        "the stage covered its whole travel without meeting the end stop:\tcheck switch and cable"));
    } else {
      start(Phase::kBackOff, -kBackOff, kApproachSpeed, StageSwitch::kNone);
    }
  } else if (plant_.stage().end_stop_pressed()) {
    fail_motion(
        Error::format(ErrorCode::kEndStopStuck, "the end stop stays pressed after backing off:\tcheck its switch"));
  } else {
    start(Phase::kFind, kBackOff + kOvertravel, kFindSpeed, StageSwitch::kPressed);
  }
}

void SimZStage::on_end_stop_found(const LegResult& leg) {
  if (was_homed_) report_.steps_lost = position_ + leg.switched - limits().end_stop;
  began_at_height_ = limits().end_stop - (position_ + leg.switched - homed_from_);
  position_ = limits().end_stop + (leg.moved - leg.switched);
  start(Phase::kReturn, plant_.stage().rounded(limits().highest - position_), kApproachSpeed, StageSwitch::kNone);
}

Status SimZStage::do_stop() {
  const SimCall call(plant_);
  if (!moving_) return {};
  stopping_ = true;
  plant_.stage().stop();
  ends_by_ = plant_.stage().ends_at();
  return {};
}

Expected<MotionReport> SimZStage::do_finish() {
  const SimCall call(plant_);
  constexpr auto kGrace = std::chrono::seconds(1);
  PLUMBLINE_TRY(plant_.wait_until(ends_by_ + kGrace, [this] { return !moving_; }));
  if (moving_)
    return fail(ErrorCode::kDeviceTimeout, "the stage did not end its motion:\tswitch the printer off and on");
  if (problem_) return tl::unexpected<Error>(*problem_);
  return report_;
}

}  // namespace plumbline::inline hal::inline sim
