#include "firmware/print/job/contract.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware/io/text/json_writer.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/print/job/layer_exposures.hpp"
#include "firmware/slice/proof_report.hpp"
#include "hal/uv_lamp.hpp"
#include "slicer/core/words/plural.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

double seconds_in(nanoseconds time) { return std::chrono::duration<double>(time).count(); }
double mm_min_in(Speed speed) { return speed.value() * 60; }

bool is_silent(const Contract& contract, PrintKey key) {
  return contract.is_archive && contract.sources[index_of(key)] == ValueSource::kProfile;
}

/// "faded_layers 8, exposure_time 2.5 s (profile)": what has the same source as the value behind it shares its brackets.
class ValueList {
 public:
  explicit ValueList(const Contract& contract) : contract_(contract) {}

  void add(PrintKey key) {
    const PrintField& field = kPrintFields[index_of(key)];
    const ValueSource source = contract_.sources[index_of(key)];
    if (source_ && *source_ != source) close();
    text_.add("%s%.*s %.6g%s", any_ ? ", " : "", static_cast<int>(field.name.size()), field.name.data(),
              value_of(contract_.plan, key), field.is_whole() ? "" : field.unit);
    any_ = true;
    source_ = source;
  }
  std::string_view close() {
    if (const auto source = std::exchange(source_, std::nullopt)) {
      const auto word = kSourceWords[static_cast<std::size_t>(*source)];
      text_.add(" (%.*s)", static_cast<int>(word.size()), word.data());
    }
    return text_.view();
  }

 private:
  const Contract& contract_;
  FixedText<600> text_;
  std::optional<ValueSource> source_;
  bool any_ = false;
};

}  // namespace

double value_of(const PrintPlan& plan, PrintKey key) {
  switch (key) {
    case PrintKey::kLayerHeight: return plan.exposed_height.millimetres();
    case PrintKey::kInitialLayerHeight: return (plan.layer_height + plan.first_layer_more).millimetres();
    case PrintKey::kBottomLayerCount: return plan.bottom_layers;
    case PrintKey::kInitialExposureTime: return seconds_in(plan.initial_exposure);
    case PrintKey::kFadedLayers: return plan.faded_layers;
    case PrintKey::kExposureTime: return seconds_in(plan.exposure);
    case PrintKey::kDelayBeforeExposure: return seconds_in(plan.rest_before_exposure);
    case PrintKey::kDelayAfterExposure: return seconds_in(plan.rest_after_exposure);
    case PrintKey::kLiftHeight: return plan.lift.millimetres();
    case PrintKey::kLiftSpeed: return mm_min_in(plan.lift_speed);
    case PrintKey::kLiftHeight2: return plan.lift2.millimetres();
    case PrintKey::kLiftSpeed2: return mm_min_in(plan.lift_speed2);
    case PrintKey::kWaitTimeAfterLift: return seconds_in(plan.wait_after_lift);
    case PrintKey::kRetractSpeed: return mm_min_in(plan.retract_speed);
    case PrintKey::kRetractHeight2: return plan.retract2.millimetres();
    case PrintKey::kRetractSpeed2: return mm_min_in(plan.retract_speed2);
    case PrintKey::kElefantFootCompensation: return plan.elephant_foot.millimetres();
    case PrintKey::kPauseLiftHeight: return plan.pause_lift.millimetres();
  }
  return 0;
}

Status check_test(const PrintPlan& plan) {
  if (plan.test.count == 0 || plan.grey_exposures == 0) return {};
  return fail(ErrorCode::kBadSetting,
              "an exposure test can't be done with the exposures of grey_exposures:\tprint without grey");
}

Expected<Contract> make_contract(const PrintProfile& profile, const MachineFile& machine,
                                 const ContractSubject& subject) {
  const PrintGrid grid = machine_grid(subject.grid, subject.sizes.relative());
  const auto layer_height = static_cast<double>(grid.layer_height_mm);
  auto plan = plan_print(profile, machine, layer_height, grid.layers, subject.steps);
  PLUMBLINE_TRY(plan);
  if (subject.is_archive) {
    plan->grey = {};
    plan->grey_exposures = subject.grey > 0 ? machine.panel.grey.exposures : 0;
  }
  PLUMBLINE_TRY(check_test(*plan));
  if (subject.columns < plan->test.count) {
    return fail(ErrorCode::kBadSetting, "an exposure test of %u strips needs as many pixels along x, the object has %u",
                plan->test.count, subject.columns);
  }
  plan->test.begin = subject.left;
  plan->test.end = subject.left + subject.columns;
  Contract contract;
  contract.plan = *plan;
  contract.sources = profile.sources;
  if (profile.initial_layer_height == 0) {  // NOLINT(clang-diagnostic-float-equal): nobody has said one
    contract.sources[index_of(PrintKey::kInitialLayerHeight)] = profile.sources[index_of(PrintKey::kLayerHeight)];
  }
  const auto pitch_x = static_cast<double>(grid.pitch_x_mm), pitch_y = static_cast<double>(grid.pitch_y_mm);
  const Vec3d shrinks = subject.sizes.relative();
  contract.width_mm = subject.columns * pitch_x / shrinks[0];
  contract.depth_mm = subject.rows * pitch_y / shrinks[1];
  contract.height_mm = height_of(*plan, plan->layers - 1).above_film().millimetres() / shrinks[2];
  contract.sizes = subject.sizes;
  contract.rotation_deg = subject.rotation_deg;
  contract.best_way_up = subject.best_way_up;
  const double first_more = plan->first_layer_more.millimetres();
  contract.resin_ml = resin_ml(subject.cured_pixels, pitch_x, pitch_y, layer_height) +
                      resin_ml(subject.first_layer_pixels, pitch_x, pitch_y, first_more);
  contract.time = std::chrono::duration_cast<std::chrono::seconds>(print_time(*plan));
  const Irradiance light(machine.power_mw_cm2);
  contract.cure_depth = cure_depth(profile, light, plan->test.count > 0 ? plan->test.exposures[0] : plan->exposure);
  contract.first_cure_depth = cure_depth(profile, light, plan->initial_exposure);
  contract.is_archive = subject.is_archive;
  contract.kind = contract.plan.grey.is_known() ? shown_grey(profile, machine) : Grey::kOff;
  contract.grey = subject.grey;
  const bool too_short = plan->grey_exposures > 0 && grey_exposures_of(*plan, plan->layers - 1) == 0;
  contract.shows_grey = machine.panel.grey.has_grey() && !too_short;
  contract.grey_lost = contract.shows_grey ? 0 : subject.grey_lost;
  const auto doubt = [&contract](Doubt about, bool is_doubtful) {
    const unsigned bit = is_doubtful ? 1U << static_cast<unsigned>(about) : 0U;
    contract.doubts = static_cast<std::uint8_t>(contract.doubts | bit);
  };
  doubt(Doubt::kLayerHeight, is_silent(contract, PrintKey::kLayerHeight));
  doubt(Doubt::kExposure,
        is_silent(contract, PrintKey::kExposureTime) || is_silent(contract, PrintKey::kInitialExposureTime));
  contract.proof = subject.proof;
  doubt(Doubt::kPoints, contract.proof.is_doubtful());
  doubt(Doubt::kGrey, contract.grey > kMostGrey && !contract.shows_grey);
  return contract;
}

namespace {

/// Edge of a strip, mm along x from where the object begins. @param strip  up to their number
double strip_mm(const Contract& contract, std::uint32_t strip) {
  return contract.width_mm * strip / contract.plan.test.count;
}

void write_test(JsonWriter& json, const Contract& contract) {
  const TestStrips& test = contract.plan.test;
  if (test.count == 0) return;
  json.begin_array("exposure_test");
  for (std::uint32_t c = 0; c < test.count; ++c) {
    json.begin_object(kOneLine);
    json.member("strip", c + 1);
    json.member("from_mm", thousandths(strip_mm(contract, c)));
    json.member("to_mm", thousandths(strip_mm(contract, c + 1)));
    json.member("exposure_s", seconds_in(test.exposures[c]));
    json.end_object();
  }
  json.end_array();
}

/// "test       strips along x, from where the object begins: 0.0 to 7.5 mm 1.6 s, 7.5 to 15.0 mm 2 s"
FixedText<400> test_line(const Contract& contract) {
  const TestStrips& test = contract.plan.test;
  FixedText<400> text;
  text.add("test       strips along x, from where the object begins:");
  for (std::uint32_t c = 0; c < test.count; ++c) {
    text.add("%s %.1f to %.1f mm %g s", c == 0 ? "" : ",", strip_mm(contract, c), strip_mm(contract, c + 1),
             seconds_in(test.exposures[c]));
  }
  return text;
}

}  // namespace

void write_contract(JsonWriter& json, const Contract& contract) {
  json.member("width_mm", thousandths(contract.width_mm));
  json.member("depth_mm", thousandths(contract.depth_mm));
  json.member("height_mm", thousandths(contract.height_mm));
  json.member("rotation_deg", contract.rotation_deg);
  json.member("best_way_up", contract.best_way_up);
  write_corrections(json, contract.sizes);
  json.member("points_off_percent", thousandths(100 * contract.proof.share_off()));
  json.member("grey_percent", thousandths(100 * contract.grey));
  json.member("grey_lost_percent", thousandths(100 * contract.grey_lost));
  json.member("shows_grey", contract.shows_grey);
  json.member("grey", kGreyWords[static_cast<std::size_t>(contract.kind)]);
  write_test(json, contract);
  json.member("resin_ml", thousandths(contract.resin_ml));
  json.member("time_s", contract.time);
  constexpr double kDigits = 1e6;
  json.begin_array("values", kOneLine);
  for (const PrintField& field : kPrintFields) {
    json.begin_object(kOneLine);
    json.member("key", field.name);
    json.member("value", std::round(value_of(contract.plan, field.key) * kDigits) / kDigits);
    json.member("unit", field.unit + 1);
    json.member("source", kSourceWords[static_cast<std::size_t>(contract.sources[index_of(field.key)])]);
    json.member("can_change", field.can_be_changed());
    json.end_object();
  }
  json.end_array();
}

namespace {

/// "heights    0.02 to 0.1 mm, as the surface allows: 412 layers where 1190 would be 0.05 mm high"
FixedText<160> heights_line(const PrintPlan& plan) {
  std::uint32_t least = LayerSteps::kMostStep, most = 1;
  for (const LayerSteps::Run& run : plan.steps.runs()) {
    least = std::min<std::uint32_t>(least, run.step);
    most = std::max<std::uint32_t>(most, run.step);
  }
  const double height = height_of(plan, plan.layers - 1).above_film().millimetres();
  const double usual = plan.exposed_height.millimetres(), unit = plan.layer_height.millimetres();
  FixedText<160> text;
  text.add("heights    %.4g to %.4g mm, as the surface allows: %u layers where %.0f would be %.4g mm high",
           least * unit, most * unit, plan.layers, std::ceil(height / usual), usual);
  return text;
}

void say_grey(const Contract& contract, std::string_view name,
              const std::function<void(const Told&, std::string_view)>& say) {
  const double grey = 100 * contract.grey, lost = 100 * contract.grey_lost;
  FixedText<200> text;
  text.add("%.3g %% of the area of %s is grey: %.3g %% vanishes, the rest cures as white", grey,
           PrintableText(name).c_str(), lost);
  say({PrinterCode::kArchiveGrey, {{Fact::kPercent, grey}, {PrinterFact::kLostPercent, lost}}, name}, text.view());
}

}  // namespace

void for_each_doubt(const Contract& contract, std::string_view name,
                    const std::function<void(const Told&, std::string_view)>& say) {
  const PrintableText shown = name;
  const auto value = [&](PrintKey key) { return value_of(contract.plan, key); };
  if (contract.doubts_about(Doubt::kLayerHeight)) {
    const double height = value(PrintKey::kLayerHeight);
    FixedText<200> text;
    text.add("%s does not say how high its layers are: %.6g mm is the profile's", shown.c_str(), height);
    say({PrinterCode::kArchiveNoHeight, {{PrinterFact::kLayerHeightMm, height}}, name}, text.view());
  }
  if (contract.doubts_about(Doubt::kExposure)) {
    FixedText<200> text;
    text.add("%s does not say how long its layers are exposed:", shown.c_str());
    Told told(PrinterCode::kArchiveNoExposure, {}, name);
    const bool normal = is_silent(contract, PrintKey::kExposureTime);
    const bool first = is_silent(contract, PrintKey::kInitialExposureTime);
    if (normal) {
      text.add(" %.6g s", value(PrintKey::kExposureTime));
      told.add(static_cast<Fact>(PrinterFact::kExposureS), value(PrintKey::kExposureTime));
    }
    if (first) {
      text.add("%s %.6g s for the first", normal ? " and" : "", value(PrintKey::kInitialExposureTime));
      told.add(static_cast<Fact>(PrinterFact::kFirstExposureS), value(PrintKey::kInitialExposureTime));
    }
    text.add(" %s the profile's", normal && first ? "are" : "is");
    say(told, text.view());
  }
  if (contract.doubts_about(Doubt::kPoints)) {
    say(told_off(contract.proof), points_off_sentence(contract.proof).view());
  }
  if (contract.doubts_about(Doubt::kGrey)) say_grey(contract, name, say);
}

namespace {

/// What grey on a panel of black and white costs.
FixedText<200> grey_exposures_line(const PrintPlan& plan) {
  const std::uint32_t n = grey_exposures_of(plan, plan.layers - 1);
  const double least = seconds_in(plan.least_exposure);
  FixedText<200> text;
  if (n == 0) {
    text.add("grey       becomes black or white: half an exposure would be shorter than %.3g s", least);
    return text;
  }
  text.add("grey       by up to %u exposures of a layer instead of one: %.2f s more for a layer with grey pixels",
           n + 1, seconds_in(plan.mask_change * n));
  if (n < plan.grey_exposures) text.add(". With %u, one would be shorter than %.3g s", plan.grey_exposures + 1, least);
  return text;
}

}  // namespace

void for_each_contract_line(const Contract& contract, const std::function<void(std::string_view)>& say) {
  FixedText<300> size;
  size.add("prints     %s", size_line(contract).c_str());
  if (contract.best_way_up) {
    size.add(", turned its best way up");
  } else if (contract.rotation_deg != std::array<double, 3>{}) {
    size.add(", turned by %g, %g, %g degrees", contract.rotation_deg[0], contract.rotation_deg[1],
             contract.rotation_deg[2]);
  }
  if (contract.grey > 0) {
    size.add(", %.3g %% of its area grey", 100 * contract.grey);
    if (!contract.shows_grey) {
      size.add(": the panel shows black or white, so %.3g %% of the area vanishes", 100 * contract.grey_lost);
    }
  }
  say(size.view());
  if (!contract.plan.steps.all_one()) say(heights_line(contract.plan).view());
  if (contract.plan.grey_exposures > 0) say(grey_exposures_line(contract.plan).view());
  if (contract.plan.test.count > 0) say(test_line(contract).view());
  if (contract.sizes.any()) say("corrected  " + std::string(contract.sizes.text().view()));
  const auto line = [&](const char* title, std::initializer_list<PrintKey> keys) {
    ValueList values(contract);
    for (const PrintKey key : keys) values.add(key);
    const auto listed = values.close();
    FixedText<640> text;
    text.add("%-11s%.*s", title, static_cast<int>(listed.size()), listed.data());
    say(text.view());
  };
  using enum PrintKey;
  line("layers", {kLayerHeight, kInitialLayerHeight, kElefantFootCompensation});
  line("exposure", {kBottomLayerCount, kInitialExposureTime, kFadedLayers, kExposureTime});
  line("lift", {kLiftHeight, kLiftSpeed, kLiftHeight2, kLiftSpeed2});
  line("retract", {kRetractSpeed, kRetractHeight2, kRetractSpeed2});
  line("waits", {kDelayBeforeExposure, kDelayAfterExposure, kWaitTimeAfterLift});
}

FixedText<160> size_line(const Contract& contract) {
  FixedText<160> text;
  text.add("%.1f x %.1f x %.1f mm, %u layer%s, %.1f ml, %lld min", contract.width_mm, contract.depth_mm,
           contract.height_mm, contract.plan.layers, plural_s(contract.plan.layers), contract.resin_ml,
           static_cast<long long>((contract.time.count() + 59) / 60));
  return text;
}

}  // namespace plumbline::firmware
