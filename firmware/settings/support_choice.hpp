#pragma once
/// What is said of supports for one job: on, off or nothing, and some of their settings. The rest is a profile's.

#include <array>
#include <optional>

#include "slicer/core/error.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline {

struct SupportChoice {
  std::optional<bool> enable;                                       ///< nothing said: as the profile has it
  std::array<std::optional<double>, kSupportFields.size()> values;  ///< in the order of kSupportFields

  /// @param enabled, settings  of the profile
  /// @returns what the job gets; none: no supports
  /// @retval ErrorCode::kBadSetting  settings that contradict each other, or one that nothing uses
  [[nodiscard]] Expected<std::optional<SupportSettings>> over(bool enabled, SupportSettings settings) const;
};

}  // namespace plumbline
