#include "hal/sim/sim_uv_lamp.hpp"

#include "hal/sim/sim_call.hpp"

namespace plumbline::inline hal::inline sim {

SimUvLamp::SimUvLamp(Plant& plant, Interlock& interlock, Clock& clock)
    : UvLamp(plant.settings().lamp, interlock, clock), plant_(plant) {}

SimUvLamp::~SimUvLamp() {
  off(ExposureEnd::kStopped);
  for (const auto& due : {deadline_, cover_, watch_}) plant_.timeline().cancel(due);
}

Expected<TimePoint> SimUvLamp::do_begin(nanoseconds cure) {
  const SimCall call(plant_);
  if (supply_cut_) {
    return fail(ErrorCode::kLampFailed,
                "the lamp's supply was cut because the lamp would not go off:\thave the lamp repaired");
  }
  LampWire* const wire = plant_.settings().lamp_wire;
  if (plant_.has_fault(FaultKind::kLampUnarmed) || (wire != nullptr && !wire->light(cure))) {
    return fail(ErrorCode::kLampFailed,
                "the lamp's keeper does not answer, so nothing was lit:\tswitch the printer off and on");
  }
  deadline_ = plant_.timeline().at(plant_.now() + cure, [this] { off(ExposureEnd::kTimeUp); });
  report_ = {.began_at = plant_.now(),
             .asked = cure,
             .lit = {},
             .end = ExposureEnd::kTimeUp,
             .dose = Dose(0),
             .source = DoseSource::kMeasured};
  on_ = true;
  plant_.expect_light(cure);
  plant_.lamp_line(true);
  return report_.began_at;
}

void SimUvLamp::off(ExposureEnd end) {
  if (!on_) return;
  on_ = false;
  report_.end = end;
  report_.lit = plant_.now() - report_.began_at;
  plant_.timeline().cancel(deadline_);
  if (LampWire* const wire = plant_.settings().lamp_wire) wire->turn_off();
  if (!plant_.powered()) return;
  plant_.lamp_line(false);
  plant_.push_event(EventKind::kExposureEnded);
  watch_ = plant_.timeline().at(plant_.now() + kStuckAfter, [this] {
    if (!plant_.light() || on_) return;
    supply_cut_ = true;
    plant_.lamp_supply(false);
  });
}

void SimUvLamp::cover_opened() {
  if (!on_) return;
  cover_ = plant_.timeline().at(plant_.now() + kCoverReaction, [this] { off(ExposureEnd::kCoverOpened); });
}

bool SimUvLamp::do_over() const {
  const SimCall call(plant_);
  return !on_;
}

void SimUvLamp::do_turn_off() noexcept {
  const SimCall call(plant_);
  off(ExposureEnd::kStopped);
}

bool SimUvLamp::do_lit() const {
  const SimCall call(plant_);
  return plant_.light();
}

Expected<ExposureReport> SimUvLamp::do_report() {
  const SimCall call(plant_);
  PLUMBLINE_TRY(plant_.wait_until(plant_.now() + 3 * kStuckAfter, [this] { return !plant_.light(); }));
  if (plant_.light()) {
    return fail(ErrorCode::kLampStuckOn, "the lamp stays on even with its supply cut:\tpull the printer's plug");
  }
  if (supply_cut_) {
    return fail(ErrorCode::kLampStuckOn, "the lamp went off only when its supply was cut:\thave the lamp repaired");
  }
  report_.dose = plant_.monitored_dose();
  // Less than 1 % of the expected dose counts as no light.
  if (report_.dose.value() < 0.01 * dose_of(limits().irradiance, report_.lit).value()) {
    return fail(ErrorCode::kLampDead, "the lamp gave no light:\tcheck the lamp and its fuse");
  }
  return report_;
}

}  // namespace plumbline::inline hal::inline sim
