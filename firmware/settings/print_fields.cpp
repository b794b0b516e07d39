#include "firmware/settings/print_fields.hpp"

#include <algorithm>

#include "firmware/settings/print_profile.hpp"

namespace plumbline::firmware::inline settings {

const std::array<PrintField, kPrintKeyCount> kPrintFields = {{
    {PrintKey::kLayerHeight, "layer_height", &PrintProfile::layer_height, 0.005, 1, " mm"},
    {PrintKey::kInitialLayerHeight, "initial_layer_height", &PrintProfile::initial_layer_height, 0.005, 1, " mm", 0,
     false},
    {PrintKey::kBottomLayerCount, "bottom_layer_count", &PrintProfile::bottom_layer_count, 1, 100, " layers", 1},
    {PrintKey::kInitialExposureTime, "initial_exposure_time", &PrintProfile::initial_exposure_time, 0.1, 300, " s", 1},
    {PrintKey::kFadedLayers, "faded_layers", &PrintProfile::faded_layers, 0, 100, " layers", 1},
    {PrintKey::kExposureTime, "exposure_time", &PrintProfile::exposure_time, 0.1, 120, " s", 0.1},
    {PrintKey::kDelayBeforeExposure, "delay_before_exposure", &PrintProfile::delay_before_exposure, 0, 60, " s", 0.5},
    {PrintKey::kDelayAfterExposure, "delay_after_exposure", &PrintProfile::delay_after_exposure, 0, 60, " s", 0.5},
    {PrintKey::kLiftHeight, "lift_height", &PrintProfile::lift_height, 0.5, 30, " mm", 0.5},
    {PrintKey::kLiftSpeed, "lift_speed", &PrintProfile::lift_speed, 1, 1000, " mm/min", 5},
    {PrintKey::kLiftHeight2, "lift_height2", &PrintProfile::lift_height2, 0, 30, " mm", 0.5},
    {PrintKey::kLiftSpeed2, "lift_speed2", &PrintProfile::lift_speed2, 1, 1000, " mm/min", 10},
    {PrintKey::kWaitTimeAfterLift, "wait_time_after_lift", &PrintProfile::wait_time_after_lift, 0, 60, " s", 0.5},
    {PrintKey::kRetractSpeed, "retract_speed", &PrintProfile::retract_speed, 1, 1000, " mm/min", 10},
    {PrintKey::kRetractHeight2, "retract_height2", &PrintProfile::retract_height2, 0, 30, " mm", 0.5},
    {PrintKey::kRetractSpeed2, "retract_speed2", &PrintProfile::retract_speed2, 1, 1000, " mm/min", 5},
    {PrintKey::kElefantFootCompensation, "elefant_foot_compensation", &PrintProfile::elefant_foot_compensation, 0, 1,
     " mm"},
    {PrintKey::kPauseLiftHeight, "pause_lift_height", &PrintProfile::pause_lift_height, 1, 300, " mm"},
}};

const PrintField* find_print_field(std::string_view name) {
  const auto* const found =
      std::find_if(kPrintFields.begin(), kPrintFields.end(), [name](const PrintField& f) { return f.name == name; });
  return found == kPrintFields.end() ? nullptr : found;
}

double value_of(const PrintProfile& profile, const PrintField& field) {
  return std::visit([&profile](auto member) { return static_cast<double>(profile.*member); }, field.member);
}

void set_value(PrintProfile& profile, const PrintField& field, double value, ValueSource source) {
  std::visit([&](auto member) { profile.*member = static_cast<std::decay_t<decltype(profile.*member)>>(value); },
             field.member);
  profile.sources[index_of(field.key)] = source;
}

void set_values(PrintProfile& profile, const PrintValues& values, ValueSource source) {
  for (const PrintField& field : kPrintFields) {
    if (const auto value = values[index_of(field.key)]) set_value(profile, field, *value, source);
  }
}

PassedValues pass(const PrintValues& values) {
  PassedValues passed;
  for (std::size_t i = 0; i < kPrintKeyCount; ++i) {
    passed.has[i] = values[i] ? 1 : 0;
    passed.value[i] = values[i].value_or(0);
  }
  return passed;
}

const PrintField* receive(const PassedValues& passed, PrintValues& values) {
  for (const PrintField& field : kPrintFields) {
    const std::size_t i = index_of(field.key);
    if (passed.has[i] == 0) continue;
    if (!field.allows(passed.value[i])) return &field;
    values[i] = passed.value[i];
  }
  return nullptr;
}

}  // namespace plumbline::firmware::inline settings
