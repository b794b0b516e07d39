#pragma once
/// A job's choice of supports: on, off or unspecified, and some of their settings. The profile has the rest.

#include <array>
#include <cstddef>
#include <optional>

#include "slicer/core/error.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware::inline settings {

struct SupportChoice {
  std::optional<bool> enable;         ///< none: as in the profile
  std::optional<std::size_t> preset;  ///< of kSupportPresets; `values` override it
  std::optional<SupportStand> stand;  ///< none: as below
  std::optional<bool> buildplate_only;
  std::array<std::optional<double>, kSupportFields.size()> values;  ///< in the order of kSupportFields

  bool operator==(const SupportChoice&) const = default;

  /// Applies the choice to a profile. An elevation without a stand raises the object, or puts it on the plate if it is 0 mm.
  /// @param enabled, settings  of the profile
  /// @returns the settings of the job; none: no supports
  /// @retval ErrorCode::kBadSetting  settings contradict each other, or one is given although supports are off
  [[nodiscard]] Expected<std::optional<SupportSettings>> over(bool enabled, SupportSettings settings) const;
};

}  // namespace plumbline::firmware::inline settings
