#pragma once
/// A job's choice of supports: on, off or unspecified, and some of their settings. The profile has the rest.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/settings/settings_file.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware::inline settings {

struct SupportChoice {
  std::optional<bool> enable;         ///< none: as in the profile
  std::optional<std::size_t> preset;  ///< of kSupportPresets; `values` override it
  std::optional<SupportStand> stand;  ///< none: see put_into()
  std::optional<bool> buildplate_only;
  std::array<std::optional<double>, kSupportFields.size()> values;  ///< in the order of kSupportFields
  bool operator==(const SupportChoice&) const = default;

  /// `settings` with what was chosen instead. A chosen elevation without a chosen stand raises the object, or puts it on the plate if it
  /// is 0 mm. The result may contradict itself: over() checks that.
  SupportSettings put_into(SupportSettings settings) const;

  /// Applies the choice to a profile.
  /// @param enabled, settings  of the profile
  /// @returns the settings of the job; none: no supports
  /// @retval ErrorCode::kBadSetting  settings contradict each other, or one is given although supports are off
  [[nodiscard]] Expected<std::optional<SupportSettings>> over(bool enabled, SupportSettings settings) const;
};

/// Rules for the keys of [supports] in a file, all optional; they store into `choice`. supports_enable is not among them.
void add_support_rules(std::vector<SettingRule>& rules, SupportChoice& choice);

/// A choice as plain numbers, from a process that is not trusted.
struct PassedSupports {
  std::array<std::uint32_t, 4>
      words{};  ///< enable, preset, stand, buildplate_only: 0: not said, else 1 more than the value
  std::array<std::uint32_t, kSupportFields.size()> has{};  ///< 1: there is one
  std::array<double, kSupportFields.size()> value{};
};
PassedSupports pass(const SupportChoice& choice);
/// @returns false: a value is impossible
bool receive(const PassedSupports& passed, SupportChoice& choice);

}  // namespace plumbline::firmware::inline settings
