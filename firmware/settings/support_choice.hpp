#pragma once
/// A job's choice of supports: on, off or unspecified, and some of their settings. The profile has the rest.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "firmware/io/text/json_writer.hpp"
#include "firmware/settings/settings_file.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware::inline settings {

/// Lists of places that belong to a job, not to a profile.
inline constexpr std::array<PlaceField, 2> kPlaceFields = {
    {{"support_at", &SupportSettings::added, "places x, y, z; numbers from -1000 to 1000 mm"},
     {"no_support_at", &SupportSettings::blocked,
      "places x, y, z or x, y, z, radius; numbers from -1000 to 1000 mm, radii from 0.1 to 100 mm"}}};

/// Reads places, such as "12.5,3,20.1; 40,22,8", and adds them to a list. A field with a radius also takes "40,22,8,3"; it is 2 mm if not given.
/// @returns the first that is not a place or has no room; empty: all were added
std::string_view add_places(std::string_view text, const PlaceField& field, SupportPlaces& places);

/// Writes a member: "support_at": [[12.5, 3, 20.1]].
void write_places(JsonWriter& json, const PlaceField& field, const SupportPlaces& places);

struct SupportChoice {
  std::optional<bool> enable;         ///< none: as in the profile
  std::optional<std::size_t> preset;  ///< of kSupportPresets; `values` override it
  std::optional<SupportStand> stand;  ///< none: see put_into()
  std::optional<bool> buildplate_only;
  std::array<std::optional<double>, kSupportFields.size()> values;  ///< in the order of kSupportFields
  std::array<SupportPlaces, kPlaceFields.size()> places;            ///< in the order of kPlaceFields
  bool operator==(const SupportChoice&) const = default;

  bool has_places() const { return places[0].count + places[1].count > 0; }
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

/// The same for the lists of places, which a profile does not have.
void add_place_rules(std::vector<SettingRule>& rules, SupportChoice& choice);

/// A choice as plain numbers, from a process that is not trusted.
struct PassedSupports {
  std::array<std::uint32_t, 4>
      words{};  ///< enable, preset, stand, buildplate_only: 0: not said, else 1 more than the value
  std::array<std::uint32_t, kSupportFields.size()> has{};  ///< 1: there is one
  std::array<double, kSupportFields.size()> value{};
  std::array<SupportPlaces, kPlaceFields.size()> places;
};
PassedSupports pass(const SupportChoice& choice);
/// @returns false: a value is impossible
bool receive(const PassedSupports& passed, SupportChoice& choice);

}  // namespace plumbline::firmware::inline settings
