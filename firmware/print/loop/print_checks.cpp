#include "firmware/print/loop/print_checks.hpp"

#include "firmware/messages/printer_code.hpp"
#include "firmware/print/loop/layer_checks.hpp"
#include "firmware/print/loop/tank_fill.hpp"
#include "slicer/core/numbers/mib.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {
namespace {

/// Share of a layer's height by which layers may differ without a word.
constexpr double kUnevenNoted = 0.01;

CheckOutcome passed_if(bool good) { return good ? CheckOutcome::kPassed : CheckOutcome::kFailed; }
CheckOutcome noted_unless(bool good) { return good ? CheckOutcome::kPassed : CheckOutcome::kWarned; }

}  // namespace

Status PrintChecks::run(const PrintGrid& masks, std::uint64_t cured_pixels, std::optional<double> left_ml,
                        bool has_journal) {
  check_job(has_journal);
  check_resin(cured_pixels, left_ml);
  check_lamp_dark();
  PLUMBLINE_TRY(check_panel(masks));
  check_cover();
  return check_temperatures();
}

void PrintChecks::conclude(Check check, CheckOutcome outcome, FaultCode code) {
  CheckResult& concluded = result(check);
  concluded.outcome = outcome;
  if (outcome == CheckOutcome::kFailed && fault_ == FaultCode::kNone) {
    fault_ = code;
    failed_ = check;
  }
  observer_.checked(check, concluded);
}

void PrintChecks::check_job(bool has_journal) {
  const PrintPlan& plan = settings_.plan;
  result(Check::kMemory).detail.add("%.1f of %.1f MiB", mib(settings_.memory_needed), mib(settings_.memory_budget));
  result(Check::kMemory).told = {
      PrinterCode::kCheckMemory,
      {{Fact::kNeededMib, mib(settings_.memory_needed)}, {Fact::kAvailableMib, mib(settings_.memory_budget)}}};
  conclude(Check::kMemory, passed_if(settings_.memory_needed <= settings_.memory_budget), FaultCode::kOutOfMemory);

  const ZPosition top = lift_from(plan, plan.layers - 1)[1].target;
  const ZPosition highest = machine_.stage.limits().highest;
  const bool on_plate = settings_.first_layer_pixels > 0;
  result(Check::kObject)
      .detail.add("%u layer%s, %.2f mm, %s; the last lift ends at %.2f mm, the stage goes up to %.2f mm", plan.layers,
                  plural_s(plan.layers), height_of(plan, plan.layers - 1).above_film().millimetres(),
                  on_plate ? "stands on the plate" : "nothing holds it because the first layer is empty",
                  top.above_film().millimetres(), highest.above_film().millimetres());
  result(Check::kObject).told = {on_plate ? PrinterCode::kCheckObject : PrinterCode::kCheckObjectHangs,
                                 {{Fact::kLayers, plan.layers},
                                  {Fact::kHeightMm, top.above_film().millimetres()},
                                  {Fact::kLimitMm, highest.above_film().millimetres()}}};
  conclude(Check::kObject, passed_if(on_plate && top <= highest),
           on_plate ? FaultCode::kOutsideTravel : FaultCode::kNothingToPrint);

  const bool known = !settings_.issues.view().empty();
  result(Check::kMasks).detail.add("%s", known ? settings_.issues.c_str() : "checked when the print began");
  result(Check::kMasks).told = !known                 ? PrinterCode::kCheckMasksBefore
                               : settings_.has_issues ? PrinterCode::kCheckMasksIssues
                                                      : PrinterCode::kCheckMasksClean;
  conclude(Check::kMasks, noted_unless(!settings_.has_issues));

  // As high as the stage's steps make them: what is planned may be lower.
  const PlanRun& run = settings_.run;
  const bool first_is_dark = settings_.first_cure_depth <= run.first;
  const Distance height = first_is_dark ? run.first : run.thickest;
  // The thickest layers of an adaptive print are exposed longer.
  const Distance thicker = plan.steps.all_one() ? Distance() : std::max(run.thickest - plan.exposed_height, Distance());
  const Distance depth = first_is_dark ? settings_.first_cure_depth : settings_.cure_depth + thicker;
  result(Check::kLight)
      .detail.add("%s of %.3f mm cures %.3f mm deep", first_is_dark ? "the first layer" : "a layer",
                  height.millimetres(), depth.millimetres());
  result(Check::kLight).told = {PrinterCode::kCheckLight,
                                {{Fact::kHeightMm, height.millimetres()}, {PrinterFact::kCureMm, depth.millimetres()}}};
  if (plan.steps.all_one() &&
      (run.thickest - run.thinnest).millimetres() > kUnevenNoted * plan.layer_height.millimetres()) {
    result(Check::kLight)
        .detail.add("; on the stage's steps the layers are %.4f to %.4f mm high", run.thinnest.millimetres(),
                    run.thickest.millimetres());
    result(Check::kLight).told.code = static_cast<ToldCode>(PrinterCode::kCheckLightSteps);
    result(Check::kLight).told.add(static_cast<Fact>(PrinterFact::kThinnestMm), run.thinnest.millimetres());
    result(Check::kLight).told.add(static_cast<Fact>(PrinterFact::kThickestMm), run.thickest.millimetres());
  }
  conclude(Check::kLight, passed_if(depth > height), FaultCode::kTooLittleLight);

  result(Check::kJournal).detail.add("%s", has_journal ? "kept" : "none, so a power cut ends the print for good");
  result(Check::kJournal).told = has_journal ? PrinterCode::kCheckJournal : PrinterCode::kCheckJournalNone;
  conclude(Check::kJournal, noted_unless(has_journal));
}

void PrintChecks::check_resin(std::uint64_t cured_pixels, std::optional<double> left_ml) {
  const double needed = static_cast<double>(settings_.cured_pixels - cured_pixels) * settings_.pixel_ml +
                        (cured_pixels == 0 ? settings_.first_layer_more_ml : 0);
  const double tank = settings_.tank_ml;
  CheckResult& check = result(Check::kResin);
  check.detail.add("%.1f ml needed, ", needed);
  const PrinterFact needs = PrinterFact::kNeededMl, left = PrinterFact::kLeftMl;
  bool enough = false;
  if (!left_ml) {
    check.detail.add("nobody has said how much is in the tank");
    check.told = {PrinterCode::kCheckResinUnknown, {{needs, needed}}};
  } else if (needs_filling(left_ml, needed, tank)) {
    check.detail.add("%.1f ml in the tank: it is to be filled before", *left_ml);
    check.told = {PrinterCode::kCheckResinFill, {{needs, needed}, {left, *left_ml}}};
  } else if (needed > usable_ml(left_ml, tank)) {
    check.detail.add("a full tank holds %.0f ml; the print will pause for more", tank);
    check.told = {PrinterCode::kCheckResinShort, {{needs, needed}, {PrinterFact::kTankMl, tank}}};
  } else {
    check.detail.add("%.1f ml in the tank", *left_ml);
    check.told = {PrinterCode::kCheckResin, {{needs, needed}, {left, *left_ml}}};
    enough = true;
  }
  conclude(Check::kResin, noted_unless(enough));
}

void PrintChecks::check_lamp_dark() {
  machine_.lamp.turn_off();
  const bool lit = machine_.lamp.lit();
  result(Check::kLampDark).detail.add("%s", lit ? "there is light although the lamp is off" : "dark");
  result(Check::kLampDark).told = lit ? PrinterCode::kCheckLampLit : PrinterCode::kCheckLampDark;
  conclude(Check::kLampDark, passed_if(!lit), FaultCode::kLampStuckOn);
}

Status PrintChecks::check_panel(const PrintGrid& masks) {
  MaskDisplay& panel = machine_.mask;
  CheckResult& check = result(Check::kPanel);
  check.told = {PrinterCode::kCheckPanel, {{PrinterFact::kColumns, masks.columns}, {PrinterFact::kRows, masks.rows}}};
  if (panel.columns() != masks.columns || panel.rows() != masks.rows) {
    check.detail.add("the panel has %u x %u pixels, the masks %u x %u", panel.columns(), panel.rows(), masks.columns,
                     masks.rows);
    check.told = {PrinterCode::kCheckPanelOther,
                  {{PrinterFact::kColumns, masks.columns},
                   {PrinterFact::kRows, masks.rows},
                   {PrinterFact::kPanelColumns, panel.columns()},
                   {PrinterFact::kPanelRows, panel.rows()}}};
    conclude(Check::kPanel, CheckOutcome::kFailed, FaultCode::kPanelSize);
    return {};
  }
  if (const auto blanked = panel.blank(); !blanked) {
    if (blanked.error().code() == ErrorCode::kPowerLost) return blanked;
    conclude_failed(Check::kPanel, blanked.error());
    return {};
  }
  check.detail.add("%u x %u pixels, black", panel.columns(), panel.rows());
  conclude(Check::kPanel, CheckOutcome::kPassed);
  return {};
}

void PrintChecks::check_cover() {
  CheckResult& check = result(Check::kCover);
  if (!settings_.has_cover_switch) {
    check.detail.add("this printer has no cover switch");
    check.told = PrinterCode::kCheckCoverNone;
    conclude(Check::kCover, CheckOutcome::kWarned);
    return;
  }
  const bool open = machine_.panel.cover_open();
  check.detail.add("%s", open ? "open" : "closed");
  check.told = open ? PrinterCode::kCheckCoverOpen : PrinterCode::kCheckCoverClosed;
  conclude(Check::kCover, passed_if(!open), FaultCode::kCoverOpen);
}

Status PrintChecks::check_temperatures() {
  CheckResult& check = result(Check::kTemperatures);
  const auto found = read_temperatures(machine_.thermals);
  if (!found) {
    if (found.error().code() == ErrorCode::kPowerLost) return tl::unexpected<Error>(found.error());
    conclude_failed(Check::kTemperatures, found.error());
    return {};
  }
  const double lamp = (*found)[0].value(), resin = (*found)[1].value(), board = (*found)[2].value();
  const LayerFinding finding = firmware::check_temperatures(*found, settings_, false);
  const bool good = finding.fault == FaultCode::kNone;
  check.detail.add(
      "lamp %.1f degrees C, at most %.0f allowed; resin %.1f degrees C, %.0f to %.0f allowed; board %.1f "
      "degrees C, at most %.0f allowed%s",
      lamp, settings_.lamp_max.value(), resin, settings_.resin_min.value(), settings_.resin_max.value(), board,
      settings_.board_max.value(), good ? "" : "; the print waits for that");
  check.told = {PrinterCode::kCheckTemperatures,
                {{PrinterFact::kLampC, lamp},
                 {PrinterFact::kLampLimitC, settings_.lamp_max.value()},
                 {PrinterFact::kResinC, resin},
                 {PrinterFact::kResinLeastC, settings_.resin_min.value()},
                 {PrinterFact::kResinMostC, settings_.resin_max.value()},
                 {PrinterFact::kBoardC, board},
                 {PrinterFact::kBoardLimitC, settings_.board_max.value()}}};
  conclude(Check::kTemperatures, noted_unless(good));
  return {};
}

void PrintChecks::stage_homed() {
  result(Check::kStage)
      .detail.add("end stop found at %.2f mm", machine_.stage.limits().end_stop.above_film().millimetres());
  result(Check::kStage).told = {PrinterCode::kCheckStage,
                                {{Fact::kHeightMm, machine_.stage.limits().end_stop.above_film().millimetres()}}};
  conclude(Check::kStage, CheckOutcome::kPassed);
}

void PrintChecks::journal_in_doubt(const Spoken& doubt) {
  CheckResult& check = result(Check::kJournal);
  check.detail.clear();
  check.detail.add("%s", doubt.text.c_str());
  check.told = doubt.told;
  conclude(Check::kJournal, CheckOutcome::kWarned);
}

void PrintChecks::stage_failed(const Error& error) { conclude_failed(Check::kStage, error); }

/// Leaves out the error's advice: the fault that it becomes gives its own.
void PrintChecks::conclude_failed(Check check, const Error& error) {
  const std::string_view finding = error.finding();
  result(check).told = error.told();
  result(check).detail.add("%.*s", static_cast<int>(finding.size()), finding.data());
  conclude(check, CheckOutcome::kFailed, fault_of(error.code()));
}

}  // namespace plumbline::firmware
