#pragma once
/// Settings of supports: their shape and where they are needed, in the words of resin slicers.

#include <array>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Names and defaults are those of PrusaSlicer's SLA settings where it has one. Lengths are mm, angles degrees.
///
///        object
///     ___________
///         ||        head_penetration into the object
///        /  \       head cone: head_front_diameter to pillar_diameter over head_width
///        |  |       pillar
///       /    \      base cone: pillar_diameter to base_diameter over base_height
///     ----------- plate
struct SupportSettings {
  double head_front_diameter = 0.4;  ///< where a support meets the object
  double head_penetration = 0.2;     ///< how far the head reaches into the object; never through it
  double head_width = 1;             ///< length of the head cone, along the support
  double pillar_diameter = 1;
  double base_diameter = 4;    ///< of the base on the plate; a support that ends on the object has a head there instead
  double base_height = 1;      ///< of the base cone
  double critical_angle = 45;  ///< from the horizontal; a steeper surface needs no supports
  /// Between two held places; an overhang longer than half of it gets supports.
  double max_bridge_length = 3;
};

/// A setting, as in files, command lines and reports.
struct SupportField {
  std::string_view key;  ///< as in PrusaSlicer: "support_pillar_diameter"
  double SupportSettings::*member;
  double low, high;  ///< inclusive
  std::string_view unit;
  std::string_view help;  ///< one line
};

inline constexpr std::array<SupportField, 8> kSupportFields = {{
    {"support_head_front_diameter", &SupportSettings::head_front_diameter, 0.1, 3, "mm",
     "Where a support meets the object"},
    {"support_head_penetration", &SupportSettings::head_penetration, 0, 2, "mm",
     "How far its head goes on into the object, never through it"},
    {"support_head_width", &SupportSettings::head_width, 0.1, 10, "mm", "Length of the head cone"},
    {"support_pillar_diameter", &SupportSettings::pillar_diameter, 0.2, 10, "mm", "Of the pillar below the head"},
    {"support_base_diameter", &SupportSettings::base_diameter, 0.2, 30, "mm", "Of the base on the plate"},
    {"support_base_height", &SupportSettings::base_height, 0, 10, "mm", "Of the base's cone"},
    {"support_critical_angle", &SupportSettings::critical_angle, 10, 80, "deg",
     "From the horizontal: what is steeper carries itself"},
    {"support_max_bridge_length", &SupportSettings::max_bridge_length, 0.2, 30, "mm",
     "Between two places that are held; half of it may jut out"},
}};

/// @retval ErrorCode::kBadSetting  a value is out of range, the head is wider than the pillar, or the pillar wider than the base;
///                                 the message names the key, the value and what is allowed
[[nodiscard]] Status check_support_settings(const SupportSettings& settings);

}  // namespace plumbline
