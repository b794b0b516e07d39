#include "firmware/settings/support_choice.hpp"

namespace plumbline::firmware::inline settings {

Expected<std::optional<SupportSettings>> SupportChoice::over(bool enabled, SupportSettings settings) const {
  const bool wanted = enable.value_or(enabled);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) continue;
    const SupportField& field = kSupportFields[i];
    if (!wanted) {
      return fail(ErrorCode::kBadSetting, "%.*s is given, but supports are off.\tTurn them on with --supports auto",
                  static_cast<int>(field.key.size()), field.key.data());
    }
    settings.*field.member = *values[i];
  }
  if (!wanted) return std::nullopt;
  PLUMBLINE_TRY(check_support_settings(settings));
  return settings;
}

}  // namespace plumbline::firmware::inline settings
