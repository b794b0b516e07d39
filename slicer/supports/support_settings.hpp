#pragma once
/// Settings of supports: their shape and where they are needed, in the words of resin slicers.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline::inline slicer {

/// How the object stands. kAuto: on the plate if its underside is flat (stand.hpp), raised otherwise.
enum class SupportStand : std::uint8_t { kAuto, kPlate, kRaised };
/// In this order.
inline constexpr std::array<std::string_view, 3> kStandWords = {"auto", "plate", "raised"};

/// A place of the print, mm: x and y from the corner of the mask, z from the plate, as findings have it.
struct SupportPlace {
  double x = 0, y = 0, z = 0;
  double radius = 0;  ///< of a ball that is kept free of tips; 0: of a place that gets one
  bool operator==(const SupportPlace&) const = default;
};
/// Of fixed size, so that it can be passed between processes.
struct SupportPlaces {
  std::array<SupportPlace, 32> list{};
  std::uint32_t count = 0;
  bool operator==(const SupportPlaces&) const = default;
  std::span<const SupportPlace> all() const { return std::span(list).first(std::min<std::size_t>(count, list.size())); }
};
/// mm, above or below a place: where the surface is looked for that gets its tip.
inline constexpr double kPlaceReach = 1.5;

/// Lengths are mm, angles degrees. A name that PrusaSlicer has means what it means there, as do the defaults except those of the
/// pad, which is thinner here and bevelled.
///
///        object
///     ___________
///         ||        head_penetration into the object
///        /  \       head: head_front_diameter to pillar_diameter over head_width, along the surface's normal
///        |  |       pillar
///       /    \      base: pillar_diameter to base_diameter over base_height
///     \________/    raft: pad_wall_thickness high, its edge bevelled by pad_wall_slope
///     ----------- plate
struct SupportSettings {
  double head_front_diameter = 0.4;  ///< where a support of medium load meets the object
  double head_penetration = 0.4;     ///< how far the head reaches into the object, and a foot on it; never through it
  double head_width = 3;             ///< length of the head
  double pillar_diameter = 1;
  double base_diameter = 4;  ///< of the base; a support that ends on the object has a head there instead
  double base_height = 1;
  double base_safety_distance = 1;       ///< of pillars and bases from the object
  double critical_angle = 45;            ///< of bridges and braces, from the horizontal
  double max_bridge_length = 15;         ///< of the bridge from a head to a pillar
  double max_pillar_link_distance = 10;  ///< between pillars that are braced
  double points_minimal_distance = 1;    ///< between tips that share the load of an overhang
  double object_elevation = 5;           ///< of a raised object above the raft; 0: all objects stand on the plate
  double pad_wall_thickness = 0.8;       ///< height of the raft; 0: none
  double pad_wall_slope = 45;  ///< of its edge, from the horizontal: wider at the top, so that a scraper gets below
  double pad_brim_size = 0.8;  ///< by which it is wider than the bases: as wide as its bevel
  double pad_max_merge_distance = 50;  ///< between bases that it joins
  // What follows is ours.
  double overhang_angle = 35;  ///< from the horizontal; a steeper surface carries itself
  double overhang_span = 5;    ///< between two held places; an overhang longer than half of it gets supports
  double area_per_tip = 12;    ///< mm2 of overhang that a tip carries at most
  // PrusaSlicer's again, but for the last.
  double points_density_relative = 100;  ///< percent of the tips
  bool buildplate_only = false;          ///< no support ends on the object
  SupportStand stand = SupportStand::kAuto;
  SupportPlaces added;    ///< places that get tips, needed or not
  SupportPlaces blocked;  ///< where no other tips are set
};

/// Diameters of head and pillar, mm, that go together.
struct SupportPreset {
  std::string_view name;
  double head_front_diameter, head_penetration, pillar_diameter;
};
/// The names are those of ChiTuBox, whose manual shows tips of 0.3 and 0.6 mm. Medium is PrusaSlicer's "0.05 Normal" for the SL1; heavy has
/// the head of its "0.1 Fast @SL1S" and the pillar of its "0.1 Fast" (PrusaResearch.ini 1.5.1). It has no light one: its pillar is ours.
inline constexpr std::array<SupportPreset, 3> kSupportPresets = {
    {{"light", 0.3, 0.3, 0.8}, {"medium", 0.4, 0.4, 1}, {"heavy", 0.6, 0.6, 1.3}}};
inline constexpr std::array kPresetWords = {kSupportPresets[0].name, kSupportPresets[1].name, kSupportPresets[2].name};

inline void apply(const SupportPreset& preset, SupportSettings& settings) {
  settings.head_front_diameter = preset.head_front_diameter;
  settings.head_penetration = preset.head_penetration;
  settings.pillar_diameter = preset.pillar_diameter;
}

/// A setting, as in files, command lines and reports.
struct SupportField {
  std::string_view key;  ///< as in PrusaSlicer: "support_pillar_diameter"
  double SupportSettings::*member;
  double low, high;  ///< inclusive
  std::string_view unit;
  std::string_view help;  ///< one line
};

/// Diameters of tips of light and heavy load, as shares of head_front_diameter.
inline constexpr double kLightTip = 0.75;
inline constexpr double kHeavyTip = 1.5;
/// Largest island that a light tip carries, mm2: UVtools would still call a larger one, on one such tip, an island.
inline constexpr double kLightLoad = 0.7;

/// Largest support_overhang_span, mm: bounds the memory of the search.
inline constexpr double kLongestSpan = 30;

inline constexpr std::array<SupportField, 20> kSupportFields = {{
    {"support_head_front_diameter", &SupportSettings::head_front_diameter, 0.1, 3, "mm",
     "Where a support meets the object; 3/4 of it under a light load, 3/2 under a heavy one"},
    {"support_head_penetration", &SupportSettings::head_penetration, 0, 2, "mm",
     "How far its head goes on into the object, never through it"},
    {"support_head_width", &SupportSettings::head_width, 0.1, 10, "mm", "Length of the head"},
    {"support_pillar_diameter", &SupportSettings::pillar_diameter, 0.2, 10, "mm", "Of the pillar below the head"},
    {"support_base_diameter", &SupportSettings::base_diameter, 0.2, 30, "mm", "Of the pillar's base"},
    {"support_base_height", &SupportSettings::base_height, 0, 10, "mm", "Of the base's cone"},
    {"support_base_safety_distance", &SupportSettings::base_safety_distance, 0, 10, "mm",
     "Of pillars and bases from the object"},
    {"support_critical_angle", &SupportSettings::critical_angle, 30, 80, "deg",
     "Of bridges and braces, from the horizontal"},
    {"support_max_bridge_length", &SupportSettings::max_bridge_length, 0, 50, "mm",
     "From a head to a pillar beside it"},
    {"support_max_pillar_link_distance", &SupportSettings::max_pillar_link_distance, 0, 50, "mm",
     "Between pillars that are braced; 0: no braces"},
    {"support_points_minimal_distance", &SupportSettings::points_minimal_distance, 0, 10, "mm",
     "Between tips that share a load"},
    {"support_object_elevation", &SupportSettings::object_elevation, 0, 50, "mm",
     "Of a raised object above the raft; 0: all objects stand on the plate"},
    {"pad_wall_thickness", &SupportSettings::pad_wall_thickness, 0, 10, "mm",
     "Height of the raft below a raised object; 0: none"},
    {"pad_wall_slope", &SupportSettings::pad_wall_slope, 45, 90, "deg",
     "Of the raft's edge, from the horizontal: below 90 a scraper gets under it"},
    {"pad_brim_size", &SupportSettings::pad_brim_size, 0, 20, "mm", "By which the raft is wider than the bases"},
    {"pad_max_merge_distance", &SupportSettings::pad_max_merge_distance, 0, 100, "mm",
     "Between bases that the raft joins"},
    {"support_overhang_angle", &SupportSettings::overhang_angle, 10, 80, "deg",
     "From the horizontal: what is steeper carries itself"},
    {"support_overhang_span", &SupportSettings::overhang_span, 0.2, kLongestSpan, "mm",
     "Between two places that are held; half of it may jut out"},
    {"support_area_per_tip", &SupportSettings::area_per_tip, 0.5, 100, "mm2", "Overhang that a tip carries at most"},
    {"support_points_density_relative", &SupportSettings::points_density_relative, 10, 500, "%",
     "Tips below overhangs, relative to what area per tip and span give"},
}};

/// mm above the plate at which a raised object begins; 0: none is raised.
inline double lift_mm(const SupportSettings& settings) {
  const bool stays = settings.stand == SupportStand::kPlate || !(settings.object_elevation > 0);
  return stays ? 0 : settings.object_elevation + settings.pad_wall_thickness;
}

/// @retval ErrorCode::kBadSetting  a value is out of range, the head is wider than the pillar, the pillar wider than the base, or the
///                                 object is to be raised by 0 mm; the message names the key, the value and what is allowed
[[nodiscard]] Status check_support_settings(const SupportSettings& settings);

}  // namespace plumbline::inline slicer
