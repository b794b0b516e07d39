#include "firmware/print/print_job.hpp"

namespace plumbline {
namespace {

constexpr double kMiB = 1024.0 * 1024.0;

}  // namespace

void PrintJob::conclude(Check check, CheckOutcome outcome, FaultCode code) {
  CheckResult& concluded = result(check);
  concluded.outcome = outcome;
  if (outcome == CheckOutcome::kFailed && refused_ == FaultCode::kNone) {
    refused_ = code;
    refused_by_ = check;
  }
  observer_.checked(check, concluded);
}

/// All of them, so that a user who must do something hears of everything at once. The stage is homed after these.
Status PrintJob::run_checks() {
  check_job();
  check_resin();
  PLUMBLINE_TRY(check_devices());
  PLUMBLINE_TRY(check_temperatures());
  if (refused_ != FaultCode::kNone) {
    fault(refused_, result(refused_by_).detail.c_str());
    return {};
  }
  PLUMBLINE_TRY(machine_.thermals.set_fan(Fan::kLamp, 1));
  PLUMBLINE_TRY(machine_.thermals.set_fan(Fan::kChamber, 1));
  if (report_.first_layer > 0) report_.marked_layer = report_.first_layer;
  apply(PrintEvent::kChecksPassed);
  return {};
}

void PrintJob::check_job() {
  const auto judge = [](bool good) { return good ? CheckOutcome::kPassed : CheckOutcome::kFailed; };

  result(Check::kMemory)
      .detail.add("%.1f of %.1f MiB", static_cast<double>(settings_.memory_needed) / kMiB,
                  static_cast<double>(settings_.memory_budget) / kMiB);
  conclude(Check::kMemory, judge(settings_.memory_needed <= settings_.memory_budget), FaultCode::kOutOfMemory);

  const ZPosition top = lift_from(plan_, plan_.layers - 1)[1].target;
  const bool on_plate = settings_.first_layer_pixels > 0;
  const bool within = top <= machine_.stage.limits().highest;
  result(Check::kObject)
      .detail.add("%u layers, %.2f mm; %s; the last lift ends at %.2f of %.2f mm", plan_.layers,
                  height_of(plan_, plan_.layers - 1).above_film().millimetres(),
                  on_plate ? "stands on the plate" : "its first layer is empty, so that nothing would hold it",
                  top.above_film().millimetres(), machine_.stage.limits().highest.above_film().millimetres());
  conclude(Check::kObject, judge(on_plate && within),
           on_plate ? FaultCode::kOutsideTravel : FaultCode::kNothingToPrint);

  result(Check::kLight)
      .detail.add("resin sets %.3f mm deep under the light of a layer of %.3f mm", settings_.cure_depth.millimetres(),
                  plan_.layer_height.millimetres());
  conclude(Check::kLight, judge(settings_.cure_depth > plan_.layer_height), FaultCode::kTooLittleLight);

  result(Check::kJournal).detail.add("%s", journal_ != nullptr ? "kept" : "none: a power cut ends the print for good");
  conclude(Check::kJournal, journal_ != nullptr ? CheckOutcome::kPassed : CheckOutcome::kWarned, FaultCode::kNone);
}

void PrintJob::check_resin() {
  const double needed = static_cast<double>(settings_.cured_pixels - entry_.cured_pixels) * settings_.pixel_ml;
  const bool enough = needed <= settings_.tank_ml;
  result(Check::kResin)
      .detail.add("%.1f ml needed, a full tank holds %.0f ml%s", needed, settings_.tank_ml,
                  enough ? "" : ": the print will ask for more");
  conclude(Check::kResin, enough ? CheckOutcome::kPassed : CheckOutcome::kWarned, FaultCode::kNone);
}

Status PrintJob::check_devices() {
  machine_.lamp.turn_off();
  const bool lit = machine_.lamp.lit();
  result(Check::kLampDark).detail.add("%s", lit ? "there is light although the lamp is off: pull the plug" : "dark");
  conclude(Check::kLampDark, lit ? CheckOutcome::kFailed : CheckOutcome::kPassed, FaultCode::kLampStuckOn);

  MaskDisplay& panel = machine_.mask;
  const PrintGrid& grid = masks_.grid();
  if (panel.columns() != grid.columns || panel.rows() != grid.rows) {
    result(Check::kPanel)
        .detail.add("it has %u x %u pixels, the print %u x %u", panel.columns(), panel.rows(), grid.columns, grid.rows);
    conclude(Check::kPanel, CheckOutcome::kFailed, FaultCode::kPanelSize);
  } else if (const auto blanked = panel.blank(); !blanked) {
    if (blanked.error().code() == ErrorCode::kPowerLost) return blanked;
    result(Check::kPanel).detail.add("%s", blanked.error().message());
    conclude(Check::kPanel, CheckOutcome::kFailed, fault_of(blanked.error().code()));
  } else {
    result(Check::kPanel).detail.add("%u x %u pixels, black", panel.columns(), panel.rows());
    conclude(Check::kPanel, CheckOutcome::kPassed, FaultCode::kNone);
  }

  const bool open = machine_.panel.cover_open();
  result(Check::kCover)
      .detail.add("%s", !settings_.has_cover_switch ? "this printer has no switch at its cover"
                        : open                      ? "open: close it"
                                                    : "closed");
  conclude(Check::kCover,
           !settings_.has_cover_switch ? CheckOutcome::kWarned
           : open                      ? CheckOutcome::kFailed
                                       : CheckOutcome::kPassed,
           FaultCode::kCoverOpen);
  return {};
}

Status PrintJob::check_temperatures() {
  CheckResult& check = result(Check::kTemperatures);
  const auto lamp = machine_.thermals.temperature(TemperatureSite::kLamp);
  const auto resin = machine_.thermals.temperature(TemperatureSite::kResin);
  for (const auto* reading : {&lamp, &resin}) {
    if (*reading) continue;
    if (reading->error().code() == ErrorCode::kPowerLost) return tl::unexpected<Error>(reading->error());
    check.detail.add("%s", reading->error().message());
    conclude(Check::kTemperatures, CheckOutcome::kFailed, fault_of(reading->error().code()));
    return {};
  }
  check.detail.add("lamp %.1f degrees, %.0f at most; resin %.1f degrees, %.0f to %.0f", lamp->value(),
                   settings_.lamp_max.value(), resin->value(), settings_.resin_min.value(),
                   settings_.resin_max.value());
  const FaultCode code = *lamp > settings_.lamp_max     ? FaultCode::kLampTooHot
                         : *resin < settings_.resin_min ? FaultCode::kResinTooCold
                         : *resin > settings_.resin_max ? FaultCode::kResinTooWarm
                                                        : FaultCode::kNone;
  conclude(Check::kTemperatures, code == FaultCode::kNone ? CheckOutcome::kPassed : CheckOutcome::kFailed, code);
  return {};
}

/// Before each layer: a hot lamp cools down, a fan that stands and a sensor that is dead end the print before heat does.
Status PrintJob::look_after_temperatures() {
  const auto lamp = machine_.thermals.temperature(TemperatureSite::kLamp);
  PLUMBLINE_TRY(lamp);
  const auto resin = machine_.thermals.temperature(TemperatureSite::kResin);
  PLUMBLINE_TRY(resin);
  if (machine_.thermals.fan_health(Fan::kLamp) == FanHealth::kStalled) {
    fault(FaultCode::kFanStalled, "the lamp's fan does not turn although it is to");
  } else if (*lamp > settings_.lamp_max) {
    apply(PrintEvent::kTooHot);
  } else if (*resin < settings_.resin_min || *resin > settings_.resin_max) {
    FixedText<128> text;
    text.add("the resin has %.1f degrees, %.0f to %.0f are allowed", resin->value(), settings_.resin_min.value(),
             settings_.resin_max.value());
    fault(*resin < settings_.resin_min ? FaultCode::kResinTooCold : FaultCode::kResinTooWarm, text.c_str());
  }
  return {};
}

}  // namespace plumbline
