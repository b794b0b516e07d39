#include "firmware/print/job/plan_check.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/messages/printer_code.hpp"
#include "hal/ramp.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

Distance size_of(Distance distance) { return std::max(distance, -distance); }

double seconds_of(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

/// Where a stage can stand.
class StepPlaces {
 public:
  /// @param tie  a nanometre up or down: which way a stage goes that is sent to halfway between two steps
  StepPlaces(const MachineFile& machine, Distance tie)
      : end_stop_(Distance::millimetres(machine.end_stop_height_mm)), step_nm_(machine.step_mm() * 1e6), tie_(tie) {}

  ZPosition nearest(ZPosition target) const {
    const double steps = std::round(static_cast<double>((target - end_stop_ + tie_).nanometres()) / step_nm_);
    return end_stop_ + Distance::nanometres(std::llround(steps * step_nm_));
  }
  Distance step() const { return Distance::nanometres(std::llround(step_nm_)); }
  /// The multiple of the step, at least one, that is nearest to a layer's height.
  Distance whole_steps(Distance height) const {
    const double steps = std::round(static_cast<double>(height.nanometres()) / step_nm_);
    return Distance::nanometres(std::llround(std::max(steps, 1.0) * step_nm_));
  }

 private:
  ZPosition end_stop_;
  double step_nm_;
  Distance tie_;
};

/// When a print is lit, layer by layer, on a stage that only stands at its steps.
class LitTimes {
 public:
  struct Lit {
    nanoseconds from{}, to{};
  };

  LitTimes(const PrintPlan& plan, const StepPlaces& places)
      : plan_(plan), places_(places), at_(places.nearest(retract_to(plan, 0)[1].target)) {}

  /// The light of the next layer. @pre there is one
  Lit next() {
    // The time starts with the first layer in its place.
    if (layer_ > 0) {
      for (const StageMove& leg : retract_to(plan_, layer_)) move(leg);
    }
    now_ += plan_.rest_before_exposure;
    const Lit lit{now_, now_ + exposure_of(plan_, layer_)};
    now_ = lit.to + plan_.rest_after_exposure;
    for (const StageMove& leg : lift_from(plan_, layer_)) move(leg);
    now_ += plan_.wait_after_lift;
    ++layer_;
    return lit;
  }

 private:
  void move(const StageMove& leg) {
    const ZPosition to = places_.nearest(leg.target);
    now_ += nanoseconds(std::llround(Ramp(size_of(to - at_), leg.speed, plan_.acceleration).duration().count() * 1e9));
    at_ = to;
  }

  const PrintPlan& plan_;
  const StepPlaces& places_;
  ZPosition at_;
  nanoseconds now_{};
  std::uint32_t layer_ = 0;
};

Status check_heights(const PrintPlan& plan, std::string_view name, const StepPlaces& places, PlanRun& run) {
  const auto share = [](Distance height, double part) { return Distance::micrometres(height.micrometres() * part); };
  ZPosition below;
  for (std::uint32_t layer = 0; layer < std::max(plan.layers, 2U); ++layer) {
    const Distance planned = thickness_of(plan, layer);
    const ZPosition at = places.nearest(height_of(plan, layer));
    const Distance made = at - below;
    below = at;
    Distance allowed = share(planned, kLayerTolerance);
    if (layer == 0) allowed = std::min(std::max(allowed, share(places.step(), 0.5)), share(planned, 0.5));
    constexpr Distance kRounding = Distance::nanometres(2);
    if (size_of(made - planned) > allowed + kRounding) {
      const Distance fits = places.whole_steps(planned);
      const double off = std::abs(made.millimetres() / planned.millimetres() - 1) * 100;
      return telling(Told(PrinterCode::kStageSteps, {{Fact::kLayer, layer},
                                                     {PrinterFact::kMadeMm, made.millimetres()},
                                                     {PrinterFact::kPlannedMm, planned.millimetres()},
                                                     {PrinterFact::kStepMm, places.step().millimetres()},
                                                     {PrinterFact::kFitsMm, fits.millimetres()}}),
                     fail(ErrorCode::kBadSetting,
                          "%s: layer %u would be %.4f mm high instead of %.4f mm, because this printer's Z stage moves "
                          "in steps of %.4f mm; its dose would be off by %.0f %%.\tChoose a height of whole steps, "
                          "such as %.4f mm, or smaller microsteps",
                          PrintableText(name).c_str(), layer, made.millimetres(), planned.millimetres(),
                          places.step().millimetres(), off, fits.millimetres()));
    }
    if (layer >= plan.layers) continue;
    if (layer == 0) {
      run.first = std::max(run.first, made);
    } else {
      run.thinnest = std::min(run.thinnest, made);
      run.thickest = std::max(run.thickest, made);
    }
  }
  return {};
}

Status check_travel(const PrintPlan& plan, const MachineFile& machine, const StepPlaces& places) {
  // As high as a move may be asked to go, on the steps.
  const ZPosition highest =
      places.nearest(ZPosition(Distance::millimetres(machine.end_stop_height_mm - kEndStopClearanceMm)));
  const ZPosition top = places.nearest(lift_from(plan, plan.layers - 1)[1].target);
  if (top <= highest) return {};
  return telling(
      Told(PrinterCode::kLastLiftHigh, {{Fact::kHeightMm, top.above_film().millimetres()},
                                        {Fact::kLimitMm, highest.above_film().millimetres()},
                                        {Fact::kExcessMm, (top - highest).millimetres()}}),
      fail(ErrorCode::kDoesNotFit,
           "the lift of the last layer ends at %.2f mm, the Z stage goes up to %.2f mm: make the object "
           "%.2f mm lower, or lift_height2 smaller",
           top.above_film().millimetres(), highest.above_film().millimetres(), (top - highest).millimetres()));
}

/// Slides a minute over the print: `leaving` follows `lit` one minute behind.
Status check_light(const PrintPlan& plan, std::string_view name, const MachineFile& machine, const StepPlaces& places,
                   PlanRun& run) {
  constexpr nanoseconds kMinute = std::chrono::seconds(60);
  const auto refuse = [name](PrinterCode code, nanoseconds light, double limit_s, const char* words) -> Status {
    return telling(Told(code, {{PrinterFact::kExposureS, seconds_of(light)}, {PrinterFact::kLimitS, limit_s}}, name),
                   fail(ErrorCode::kExposureTooLong,
                        "%s: %.1f s of light %s, this printer's lamp may be lit for %g s.\tChoose "
                        "shorter exposures or longer waits",
                        PrintableText(name).c_str(), seconds_of(light), words, limit_s));
  };
  LitTimes ahead(plan, places), behind(plan, places);
  LitTimes::Lit leaving = behind.next();
  nanoseconds light{};
  for (std::uint32_t layer = 0; layer < plan.layers; ++layer) {
    const LitTimes::Lit lit = ahead.next();
    light += lit.to - lit.from;
    if (seconds_of(lit.to - lit.from) > machine.max_exposure_s) {
      return refuse(PrinterCode::kExposureLong, lit.to - lit.from, machine.max_exposure_s, "at once");
    }
    const nanoseconds began = lit.to - kMinute;
    for (; leaving.to <= began; leaving = behind.next()) light -= leaving.to - leaving.from;
    run.most_light = std::max(run.most_light, light - std::max(began - leaving.from, nanoseconds::zero()));
  }
  if (seconds_of(run.most_light) <= machine.max_light_per_minute_s) return {};
  return refuse(PrinterCode::kLightLong, run.most_light, machine.max_light_per_minute_s, "in a minute");
}

}  // namespace

Expected<PlanRun> check_plan(const PrintPlan& plan, std::string_view name, const MachineFile& machine) {
  PlanRun run;
  run.first = thickness_of(plan, 0);
  run.thinnest = run.thickest = thickness_of(plan, plan.layers > 1 ? 1 : 0);
  for (const Distance tie : {Distance::nanometres(1), Distance::nanometres(-1)}) {
    const StepPlaces places(machine, tie);
    PLUMBLINE_TRY(check_heights(plan, name, places, run));
    PLUMBLINE_TRY(check_travel(plan, machine, places));
    PLUMBLINE_TRY(check_light(plan, name, machine, places, run));
  }
  return run;
}

}  // namespace plumbline::firmware
