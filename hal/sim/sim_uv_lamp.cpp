#include "hal/sim/sim_uv_lamp.hpp"

#include "hal/sim/sim_call.hpp"

namespace plumbline {

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
                "the lamp's supply was cut because it would not go dark: have the lamp repaired");
  }
  LampWire* const wire = plant_.settings().lamp_wire;
  if (plant_.faulty(FaultKind::kLampUnarmed) || (wire != nullptr && !wire->light(cure))) {
    return fail(ErrorCode::kLampFailed,
                "the lamp's keeper does not answer, so the lamp was not lit: restart the printer");
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
  if (LampWire* const wire = plant_.settings().lamp_wire) wire->darken();
  if (!plant_.powered()) return;
  plant_.lamp_line(false);
  plant_.tell(EventKind::kExposureEnded);
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

void SimUvLamp::do_darken() noexcept {
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
    return fail(ErrorCode::kLampStuckOn,
                "the lamp does not go dark, nor with its supply cut: pull the plug of the printer");
  }
  if (supply_cut_) {
    return fail(ErrorCode::kLampStuckOn, "the lamp did not go dark until its supply was cut: have the lamp repaired");
  }
  report_.dose = plant_.monitored_dose();
  // What a monitor takes for light at all.
  if (report_.dose.value() < 0.01 * dose_of(limits().irradiance, report_.lit).value()) {
    return fail(ErrorCode::kLampDead, "the lamp gave no light: check lamp and fuse");
  }
  return report_;
}

}  // namespace plumbline
