#include "firmware/print/job/print_plan.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/print/job/layer_exposures.hpp"
#include "firmware/print/job/plan_check.hpp"
#include "hal/ramp.hpp"
#include "hal/z_stage.hpp"
#include "slicer/core/resin/bottom_fade.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

nanoseconds seconds(double value) { return nanoseconds(std::llround(value * 1e9)); }

/// Who is to blame for a value, before a message: "profile standard: ", "part.sl1: ", or nobody but the person who set it.
FixedText<160> blamed(const PrintProfile& profile, PrintKey key) {
  FixedText<160> text;
  switch (profile.sources[index_of(key)]) {
    case ValueSource::kProfile: text.add("profile %s: ", profile.name.c_str()); break;
    case ValueSource::kArchive: text.add("%s: ", PrintableText(profile.archive).c_str()); break;
    case ValueSource::kPrinter:
    case ValueSource::kPerson: break;
  }
  return text;
}

Status check_moves(const PrintProfile& profile, const MachineFile& machine) {
  for (const PrintKey key :
       {PrintKey::kLiftSpeed, PrintKey::kLiftSpeed2, PrintKey::kRetractSpeed, PrintKey::kRetractSpeed2}) {
    const PrintField& field = kPrintFields[index_of(key)];
    const double speed = value_of(profile, field);
    if (speed <= machine.max_speed_mm_min) continue;
    return telling(
        Told(PrinterCode::kStageSlow,
             {{PrinterFact::kSpeedMmMin, speed}, {PrinterFact::kLimitMmMin, machine.max_speed_mm_min}}, profile.name),
        fail(ErrorCode::kBadSetting,
             "%s%.*s is %g mm/min, this printer's Z stage moves at %g mm/min at most:\tlower it",
             blamed(profile, key).c_str(), static_cast<int>(field.name.size()), field.name.data(), speed,
             machine.max_speed_mm_min));
  }
  const double whole = profile.lift_height + profile.lift_height2;
  if (profile.retract_height2 <= whole) return {};
  return fail(
      ErrorCode::kBadSetting,
      "%sretract_height2 is %g mm, allowed is at most the whole lift, lift_height + lift_height2 = %g mm:\tlower "
      "it, or lift higher",
      blamed(profile, PrintKey::kRetractHeight2).c_str(), profile.retract_height2, whole);
}

/// Of the longer exposure.
PrintKey longest_of(const PrintProfile& profile) {
  return profile.initial_exposure_time > profile.exposure_time ? PrintKey::kInitialExposureTime
                                                               : PrintKey::kExposureTime;
}

Status check_exposures(const PrintProfile& profile, const MachineFile& machine) {
  const PrintKey key = longest_of(profile);
  const PrintField& field = kPrintFields[index_of(key)];
  const double longest = value_of(profile, field);
  if (longest <= machine.max_exposure_s) return {};
  const bool is_archives = profile.sources[index_of(key)] == ValueSource::kArchive;
  const Told told(PrinterCode::kExposureLong,
                  {{PrinterFact::kExposureS, longest}, {PrinterFact::kLimitS, machine.max_exposure_s}},
                  is_archives ? profile.archive : profile.name);
  if (is_archives) {
    return telling(
        told,
        fail(ErrorCode::kExposureTooLong,
             "%sits exposure %s is %g s, this printer's lamp may be lit for %g s at most.\tSlice it again "
             "with a shorter exposure",
             blamed(profile, key).c_str(), key == PrintKey::kInitialExposureTime ? "of the first layers" : "of a layer",
             longest, machine.max_exposure_s));
  }
  return telling(told, fail(ErrorCode::kExposureTooLong,
                            "%san exposure is %g s, this printer's lamp may be lit for %g s at most:\tlower %.*s",
                            blamed(profile, key).c_str(), longest, machine.max_exposure_s,
                            static_cast<int>(field.name.size()), field.name.data()));
}

Status check_height(const PrintPlan& plan) {
  const ZPosition top = height_of(plan, plan.layers - 1) + plan.lift + plan.lift2;
  if (top <= plan.highest) return {};
  return telling(Told(PrinterCode::kLastLiftHigh, {{Fact::kHeightMm, top.above_film().millimetres()},
                                                   {Fact::kLimitMm, plan.highest.above_film().millimetres()},
                                                   {Fact::kExcessMm, (top - plan.highest).millimetres()}}),
                 fail(ErrorCode::kDoesNotFit,
                      "the lift of the last layer ends at %.2f mm, the Z stage goes up to %.2f mm: make the object "
                      "%.2f mm lower, or "
                      "lift_height2 smaller",
                      top.above_film().millimetres(), plan.highest.above_film().millimetres(),
                      (top - plan.highest).millimetres()));
}

Status check_light(const PrintPlan& plan, const PrintProfile& profile, const MachineFile& machine) {
  const double most = std::chrono::duration<double>(most_light_in_a_minute(plan)).count();
  if (most <= machine.max_light_per_minute_s) return {};
  const PrintKey key = longest_of(profile);
  const bool is_archives = profile.sources[index_of(key)] == ValueSource::kArchive;
  const Told told(PrinterCode::kLightLong,
                  {{PrinterFact::kExposureS, most}, {PrinterFact::kLimitS, machine.max_light_per_minute_s}},
                  is_archives ? profile.archive : profile.name);
  if (is_archives) {
    return telling(
        told, fail(ErrorCode::kExposureTooLong,
                   "%sits exposures give up to %.1f s of light in a minute, this printer's lamp may be lit for %g s of "
                   "one.\tSlice it again with shorter exposures, or raise wait_time_after_lift in the profile %s",
                   blamed(profile, key).c_str(), most, machine.max_light_per_minute_s, profile.name.c_str()));
  }
  return telling(told,
                 fail(ErrorCode::kExposureTooLong,
                      "%sup to %.1f s of light in a minute, this printer's lamp may be lit for %g s of one:\tlower "
                      "initial_exposure_time or exposure_time, or raise wait_time_after_lift",
                      blamed(profile, key).c_str(), most, machine.max_light_per_minute_s));
}

/// Takes an exposure test into a plan whose other values are known.
Status plan_test(const PrintProfile& profile, PrintPlan& plan) {
  const ExposureTest& test = profile.exposure_test;
  if (test.strips == 0) return {};
  if (profile.adaptive) {
    return fail(ErrorCode::kBadSetting, "an exposure test takes layers of one height:\tleave out adaptive layers");
  }
  nanoseconds before{};
  for (; plan.test.count < test.strips; ++plan.test.count) {
    const double exposure = test.seconds[plan.test.count];
    const nanoseconds time =
        std::chrono::round<std::chrono::microseconds>(seconds(exposure));  // as the journal keeps it
    if (time - before < plan.least_exposure) {
      const auto in_seconds = [](nanoseconds t) { return std::chrono::duration<double>(t).count(); };
      return fail(
          ErrorCode::kBadSetting,
          "exposure test: %g s is %g s more than %g s, this printer's lamp is lit for %g s at least:\tleave out one",
          exposure, in_seconds(time - before), in_seconds(before), in_seconds(plan.least_exposure));
    }
    plan.test.exposures[plan.test.count] = before = time;
  }
  plan.exposure = before;
  return {};
}

double fade_of(const PrintPlan& plan, std::uint32_t layer) {
  return bottom_fade(layer, plan.bottom_layers, plan.faded_layers);
}

/// An exposure of a layer as high as the profile's, for this one.
nanoseconds for_height(const PrintPlan& plan, std::uint32_t layer, nanoseconds exposure) {
  if (plan.steps.all_one()) return exposure;
  const double higher_mm = (thickness_of(plan, layer) - plan.exposed_height).millimetres();
  return nanoseconds(std::llround(static_cast<double>(exposure.count()) * dose_factor(higher_mm, plan.penetration_mm)));
}

nanoseconds move_time(const PrintPlan& plan, Distance way, Speed speed) {
  if (way <= Distance()) return {};
  return seconds(Ramp(way, speed, plan.acceleration).duration().count());
}

/// As PlateMoves::lower_to() moves.
nanoseconds lowering_time(const PrintPlan& plan, ZPosition from, std::uint32_t layer) {
  const TwoStageMove down = retract_to(plan, layer);
  const ZPosition near = std::min({from, down[1].target + plan.lift + plan.lift2, plan.highest});
  return move_time(plan, from - near, plan.fastest) + move_time(plan, near - down[0].target, down[0].speed) +
         move_time(plan, down[0].target - down[1].target, down[1].speed);
}

/// For the panel: a change to each mask that the layer may need, and to black.
nanoseconds changing_time(const PrintPlan& plan, std::uint32_t layer) {
  return plan.mask_change * (most_exposures_of(plan, layer).count() + 1);
}

/// Of a layer, from the rest before its exposure to the wait after its lift.
nanoseconds curing_time(const PrintPlan& plan, std::uint32_t layer) {
  return plan.rest_before_exposure + exposure_of(plan, layer) + changing_time(plan, layer) + plan.rest_after_exposure +
         move_time(plan, plan.lift, plan.lift_speed) + move_time(plan, plan.lift2, plan.lift_speed2) +
         plan.wait_after_lift;
}

}  // namespace

Expected<PrintPlan> plan_print(const PrintProfile& profile, const MachineFile& machine, double layer_height_mm,
                               std::uint32_t layers, const LayerSteps& steps) {
  PLUMBLINE_TRY(check_moves(profile, machine));
  PLUMBLINE_TRY(check_exposures(profile, machine));
  PrintPlan plan;
  plan.layers = steps.layers(layers);
  plan.steps = steps;
  plan.layer_height = Distance::millimetres(layer_height_mm);
  plan.exposed_height = steps.all_one() ? plan.layer_height : Distance::millimetres(profile.layer_height);
  plan.penetration_mm = profile.penetration_depth;
  if (profile.initial_layer_height > 0) {
    plan.first_layer_more = Distance::millimetres(profile.initial_layer_height) - plan.layer_height;
  }
  plan.exposure = seconds(profile.exposure_time);
  plan.initial_exposure = seconds(profile.initial_exposure_time);
  plan.bottom_layers = profile.bottom_layer_count;
  plan.faded_layers = profile.faded_layers;
  plan.rest_before_exposure = seconds(profile.delay_before_exposure);
  plan.rest_after_exposure = seconds(profile.delay_after_exposure);
  plan.wait_after_lift = seconds(profile.wait_time_after_lift);
  plan.lift = Distance::millimetres(profile.lift_height);
  plan.lift2 = Distance::millimetres(profile.lift_height2);
  plan.lift_speed = mm_per_min(profile.lift_speed);
  plan.lift_speed2 = mm_per_min(profile.lift_speed2);
  plan.retract2 = Distance::millimetres(profile.retract_height2);
  plan.retract_speed = mm_per_min(profile.retract_speed);
  plan.retract_speed2 = mm_per_min(profile.retract_speed2);
  plan.pause_lift = Distance::millimetres(profile.pause_lift_height);
  plan.grey = grey_model(profile, machine);
  if (!steps.all_one()) {  // rays enter in layers of the least height
    const auto dose = [&](Distance height) {
      return plan.grey.dose * dose_factor((height - plan.exposed_height).millimetres(), plan.penetration_mm);
    };
    std::uint32_t most = 1;
    for (const LayerSteps::Run& run : steps.runs()) most = std::max<std::uint32_t>(most, run.step);
    plan.grey.most_dose = dose(plan.layer_height * std::int64_t{most});
    plan.grey.dose = dose(plan.layer_height);
  }
  if (plan.grey.is_known()) plan.grey_exposures = machine.panel.grey.exposures;
  plan.elephant_foot = Distance::millimetres(profile.elefant_foot_compensation);
  plan.highest = ZPosition(Distance::millimetres(machine.end_stop_height_mm - kEndStopClearanceMm));
  plan.fastest = mm_per_min(machine.max_speed_mm_min);
  plan.acceleration = Acceleration(machine.max_acceleration_mm_s2);
  constexpr double kFrame = 1.0 / 60;  // panels are scanned out 60 times a second
  plan.mask_change = seconds(kFrame + machine.refresh_delay_ms / 1000);
  // The shortest exposure of a profile, and of a lamp that is slow to warm up one of which its warm-up is a tenth.
  plan.least_exposure = std::max(seconds(0.1), seconds(machine.warm_up_ms / 100));
  PLUMBLINE_TRY(plan_test(profile, plan));
  PLUMBLINE_TRY(check_height(plan));
  PLUMBLINE_TRY(check_light(plan, profile, machine));
  PLUMBLINE_TRY(check_plan(plan, profile.archive.empty() ? profile.name : profile.archive, machine));
  return plan;
}

nanoseconds exposure_of(const PrintPlan& plan, std::uint32_t layer) {
  const auto difference = static_cast<double>((plan.exposure - plan.initial_exposure).count());
  const nanoseconds exposure = plan.initial_exposure + nanoseconds(std::llround(difference * fade_of(plan, layer)));
  return for_height(plan, layer, exposure);
}

nanoseconds normal_exposure_of(const PrintPlan& plan, std::uint32_t layer) {
  return for_height(plan, layer, plan.exposure);
}

ZPosition height_of(const PrintPlan& plan, std::uint32_t layer) {
  return ZPosition(plan.layer_height * std::int64_t{plan.steps.of(layer).end()} + plan.first_layer_more);
}

Distance thickness_of(const PrintPlan& plan, std::uint32_t layer) {
  const Distance height = plan.layer_height * std::int64_t{plan.steps.of(layer).step};
  return layer == 0 ? height + plan.first_layer_more : height;
}

TwoStageMove lift_from(const PrintPlan& plan, std::uint32_t layer) {
  const ZPosition peeled = height_of(plan, layer) + plan.lift;
  return {StageMove{peeled, plan.lift_speed}, StageMove{peeled + plan.lift2, plan.lift_speed2}};
}

TwoStageMove retract_to(const PrintPlan& plan, std::uint32_t layer) {
  const ZPosition height = height_of(plan, layer);
  return {StageMove{height + plan.retract2, plan.retract_speed}, StageMove{height, plan.retract_speed2}};
}

StageMove pause_above(const PrintPlan& plan, std::uint32_t layer) {
  return {std::min(height_of(plan, layer) + plan.pause_lift, plan.highest), plan.lift_speed2};
}

nanoseconds layer_time(const PrintPlan& plan, std::uint32_t layer) {
  // The way down starts where the lift of the layer below ended. time_to_end() adds the first layer's way from the top.
  const nanoseconds down = layer > 0 ? lowering_time(plan, lift_from(plan, layer - 1)[1].target, layer) : nanoseconds();
  return down + curing_time(plan, layer);
}

nanoseconds most_light_in_a_minute(const PrintPlan& plan) {
  constexpr nanoseconds kMinute = std::chrono::seconds(60);
  const std::uint32_t same_from = plan.bottom_layers + plan.faded_layers;
  nanoseconds most{};
  // The minute that ends with a layer's exposure has the most light of those that end in it. Once it holds only layers after the fade,
  // all others are like it.
  for (std::uint32_t last = 0; last < plan.layers; ++last) {
    nanoseconds light{};
    nanoseconds left = kMinute;
    std::uint32_t layer = last;
    for (;; --layer) {
      const nanoseconds exposure = exposure_of(plan, layer);
      light += std::min(exposure, left);
      // Without the exposure a layer's time is the time in the dark since the layer below.
      left -= layer_time(plan, layer) - changing_time(plan, layer);
      if (layer == 0 || left <= nanoseconds::zero()) break;
    }
    most = std::max(most, light);
    if (layer >= same_from && plan.steps.all_one()) break;
  }
  return most;
}

nanoseconds remaining_time(const PrintPlan& plan, std::uint32_t first) {
  // Layers of one height after the fade take the same time.
  const std::uint32_t same_from = plan.bottom_layers + plan.faded_layers;
  nanoseconds time{};
  for (std::uint32_t layer = first; layer < plan.layers;) {
    const std::uint32_t end = layer < same_from ? layer + 1 : std::min(plan.layers, plan.steps.run_end(layer));
    time += layer_time(plan, layer) * (end - layer);
    layer = end;
  }
  return time;
}

nanoseconds homing_time(const PrintPlan& plan, ZPosition from) {
  const Distance up = plan.highest + Distance::millimetres(kEndStopClearanceMm) - from;
  return move_time(plan, up, ZStage::kApproachSpeed) + move_time(plan, ZStage::kBackOff, ZStage::kApproachSpeed) +
         move_time(plan, ZStage::kBackOff, ZStage::kFindSpeed) +
         move_time(plan, Distance::millimetres(kEndStopClearanceMm), ZStage::kApproachSpeed);
}

nanoseconds time_to_end(const PrintPlan& plan, ZPosition from, std::uint32_t first, nanoseconds lit) {
  nanoseconds time{};
  ZPosition at = from;
  if (first < plan.layers) {
    time += lowering_time(plan, from, first) + curing_time(plan, first) - lit + remaining_time(plan, first + 1);
    time -= plan.mask_change * most_exposures_of(plan, first).at(lit);  // for masks that have had their light
    at = lift_from(plan, plan.layers - 1)[1].target;
  }
  return time + move_time(plan, plan.highest - at, plan.fastest) + homing_time(plan, plan.highest);
}

nanoseconds print_time(const PrintPlan& plan) { return time_to_end(plan, plan.highest, 0); }

Distance cure_depth(const PrintProfile& profile, Irradiance irradiance, nanoseconds lit) {
  return Distance::millimetres(cure_depth_mm(profile, dose_of(irradiance, lit).value()));
}

double resin_ml(std::uint64_t cured_pixels, double pitch_x_mm, double pitch_y_mm, double layer_height_mm) {
  constexpr double kCubicMillimetresPerMillilitre = 1000;
  return static_cast<double>(cured_pixels) * pitch_x_mm * pitch_y_mm * layer_height_mm / kCubicMillimetresPerMillilitre;
}

double resin_cost(const PrintProfile& profile, double ml) {
  return profile.bottle_volume > 0 ? profile.bottle_cost * ml / profile.bottle_volume : 0;
}

}  // namespace plumbline::firmware
