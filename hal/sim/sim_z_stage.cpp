#include "hal/sim/sim_z_stage.hpp"

#include <algorithm>

#include "hal/sim/sim_call.hpp"

namespace plumbline {
namespace {

constexpr Distance kBackOffWay = 2_mm;
constexpr Distance kReleaseWay = 1_mm;  // no more: where the switch lies, the part may be at the film
constexpr Distance kSlack = 2_mm;       // that an approach goes beyond the end stop's nominal height
constexpr Speed kApproachSpeed(5);
constexpr Speed kFindSpeed(0.5);

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
  return at_ + plant_.stage().moved();
}

TimePoint SimZStage::do_ends_by() const { return ends_by_; }

void SimZStage::start(Phase phase, Distance way, Speed speed, StageSwitch until) {
  phase_ = phase;
  plant_.start_leg(way, std::min(speed, limits().fastest), until, [this](const LegResult& leg) { on_rest(leg); });
}

Status SimZStage::do_begin_move(ZPosition target, Speed speed) {
  const SimCall call(plant_);
  report_ = {.began_at = plant_.now(), .ended_at = {}, .at = at_, .arrived = false, .steps_lost = {}};
  moving_ = true;
  stopping_ = false;
  failed_ = false;
  start(Phase::kMove, plant_.stage().rounded(target - at_), speed, StageSwitch::kNone);
  ends_by_ = plant_.stage().ends_at();
  return {};
}

Status SimZStage::do_begin_homing() {
  const SimCall call(plant_);
  report_ = {.began_at = plant_.now(), .ended_at = {}, .at = at_, .arrived = false, .steps_lost = {}};
  was_homed_ = std::exchange(homed_, false);
  moving_ = true;
  stopping_ = false;
  failed_ = false;
  const Distance whole = limits().end_stop - limits().lowest + kSlack;
  // Whole way up, and four short ones at a millimetre or two each; ramps are below a second.
  ends_by_ = plant_.now() + std::chrono::seconds(30) +
             std::chrono::duration_cast<nanoseconds>(Ramp(whole, kApproachSpeed, limits().acceleration).duration());
  if (!plant_.stage().end_stop_pressed()) {
    start(Phase::kApproach, whole, kApproachSpeed, StageSwitch::kPressed);
  } else if (was_homed_ && at_ < limits().end_stop - kBackOffWay) {
    rest(false, ErrorCode::kEndStopStuck, "the end stop is pressed although the stage is not there: check its switch");
  } else {
    start(Phase::kRelease, -kReleaseWay, kFindSpeed, StageSwitch::kReleased);
  }
  return {};
}

void SimZStage::rest(bool arrived, ErrorCode problem, const char* message) {
  moving_ = false;
  report_.at = at_;
  report_.ended_at = plant_.now();
  report_.arrived = arrived;
  failed_ = message != nullptr;
  if (failed_) {
    homed_ = false;
    problem_ = Error::format(problem, "%s", message);
  }
  plant_.tell(EventKind::kMotionEnded);
}

void SimZStage::on_rest(const LegResult& leg) {
  const ZPosition from = at_;
  at_ = at_ + leg.moved;
  if (leg.end == LegEnd::kStalled && phase_ == Phase::kApproach) {
    rest(false, ErrorCode::kEndStopNotFound,
         "the stage met its upper end and not the end stop: check its switch and cable");
  } else if (leg.end == LegEnd::kStalled) {
    rest(false, ErrorCode::kStageStalled, "the stage is blocked: look for what is in its way");
  } else if (leg.end == LegEnd::kStopped || (stopping_ && phase_ != Phase::kMove)) {
    rest(false, ErrorCode::kCancelled, nullptr);
  } else if (phase_ == Phase::kMove || phase_ == Phase::kReturn) {
    if (phase_ == Phase::kReturn) homed_ = true;
    rest(true, ErrorCode::kCancelled, nullptr);
  } else {
    at_ = from;
    home_further(leg);
  }
}

void SimZStage::home_further(const LegResult& leg) {
  const bool switched = leg.end == LegEnd::kSwitched;
  if (phase_ == Phase::kFind && switched) return found(leg);
  at_ = at_ + leg.moved;
  if (phase_ == Phase::kRelease && !switched) {
    rest(false, ErrorCode::kEndStopStuck, "the end stop stays pressed: check its switch");
  } else if (phase_ == Phase::kApproach || phase_ == Phase::kFind) {
    if (!switched) {
      rest(false, ErrorCode::kEndStopNotFound,
           "the stage went its whole way and met no end stop: check its switch and cable");
    } else {
      start(Phase::kBackOff, -kBackOffWay, kApproachSpeed, StageSwitch::kNone);
    }
  } else if (plant_.stage().end_stop_pressed()) {
    rest(false, ErrorCode::kEndStopStuck, "the end stop stays pressed after backing off: check its switch");
  } else {
    start(Phase::kFind, kBackOffWay + kSlack, kFindSpeed, StageSwitch::kPressed);
  }
}

void SimZStage::found(const LegResult& leg) {
  if (was_homed_) report_.steps_lost = at_ + leg.switched - limits().end_stop;
  at_ = limits().end_stop + (leg.moved - leg.switched);
  start(Phase::kReturn, plant_.stage().rounded(limits().highest - at_), kApproachSpeed, StageSwitch::kNone);
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
    return fail(ErrorCode::kDeviceTimeout, "the stage did not end its motion: switch the printer off and on");
  if (failed_) return tl::unexpected<Error>(problem_);
  return report_;
}

}  // namespace plumbline
