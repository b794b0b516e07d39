#include "firmware/settings/support_choice.hpp"

namespace plumbline::firmware::inline settings {

Expected<std::optional<SupportSettings>> SupportChoice::over(bool enabled, SupportSettings settings) const {
  const bool wanted = enable.value_or(enabled);
  std::string_view given = preset            ? "support_preset"
                           : stand           ? "support_stand"
                           : buildplate_only ? "support_buildplate_only"
                                             : "";
  if (preset) apply(kSupportPresets[*preset], settings);
  settings.stand = stand.value_or(settings.stand);
  settings.buildplate_only = buildplate_only.value_or(settings.buildplate_only);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) continue;
    const SupportField& field = kSupportFields[i];
    given = field.key;
    settings.*field.member = *values[i];
    if (field.member != &SupportSettings::object_elevation) continue;
    if (!stand) settings.stand = *values[i] > 0 ? SupportStand::kRaised : SupportStand::kPlate;
    if (wanted && *values[i] > 0 && settings.stand == SupportStand::kPlate) {
      return fail(ErrorCode::kBadSetting,
                  "support_object_elevation is %g mm, but support_stand is plate.\tGive one of the two", *values[i]);
    }
  }
  if (!wanted && !given.empty()) {
    return fail(ErrorCode::kBadSetting, "%.*s is given, but supports are off.\tTurn them on with --supports auto",
                static_cast<int>(given.size()), given.data());
  }
  if (!wanted) return std::nullopt;
  PLUMBLINE_TRY(check_support_settings(settings));
  return settings;
}

}  // namespace plumbline::firmware::inline settings
