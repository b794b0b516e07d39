#pragma once
/// Resin and print settings: board/profiles/*.toml, each key explained in board/README.md.

#include <cstdint>
#include <string>
#include <string_view>

#include "slicer/core/error.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline {

/// Names are those of PrusaSlicer's SLA settings where it has one. Every number is inside the range that board/README.md
/// gives. Heights mm, times s, speeds mm/min, as users of resin printers know them; PrintPlan has them in types.
struct PrintProfile {
  std::string name;                      ///< [profile]
  double penetration_depth = 0;          ///< [resin] mm: Dp of Jacobs' working curve Cd = Dp ln(E / Ec)
  double critical_energy = 0;            ///< [resin] mJ/cm2: Ec of that curve
  double bottle_cost = 0;                ///< [resin] of a bottle, in any currency; 0: not known
  double bottle_volume = 0;              ///< [resin] ml of a bottle; 0: not known
  double layer_height = 0;               ///< [print] mm
  double exposure_time = 0;              ///< [print] s
  double initial_exposure_time = 0;      ///< [print] s, of the bottom layers
  std::uint32_t bottom_layer_count = 0;  ///< [print] layers that are exposed for initial_exposure_time
  std::uint32_t faded_layers = 0;        ///< [print] layers after them whose exposure falls to exposure_time
  double delay_before_exposure = 0;      ///< [print] s, from the stage's rest to the light
  double delay_after_exposure = 0;       ///< [print] s, from the light's end to the lift
  double lift_height = 0;                ///< [print] mm, first and slow part of the lift: the peel
  double lift_speed = 0;                 ///< [print] mm/min
  double lift_height2 = 0;               ///< [print] mm, second and fast part; 0: none
  double lift_speed2 = 0;                ///< [print] mm/min
  double wait_time_after_lift = 0;       ///< [print] s, at the top
  double retract_speed = 0;              ///< [print] mm/min, first and fast part of the way down
  double retract_height2 = 0;            ///< [print] mm, second and slow part, next to the film; 0: none
  double retract_speed2 = 0;             ///< [print] mm/min
  double elefant_foot_compensation = 0;  ///< [print] mm, by which the outline of the bottom layers is drawn in
  double pause_lift_height = 0;          ///< [print] mm, to which a pause raises the part above the layer
  bool supports_enable = false;          ///< [supports] where the job says nothing
  SupportSettings supports;              ///< [supports] what they look like
};

/// Reads a profile; see read_settings_file() for the errors.
/// @param path  as it is to appear in messages
[[nodiscard]] Expected<PrintProfile> read_print_profile(const std::string& path);

/// The same from text in memory.
[[nodiscard]] Expected<PrintProfile> parse_print_profile(std::string_view text, std::string_view path);

/// The same by name.
/// @param name_or_path, board_path  see find_profile()
[[nodiscard]] Expected<PrintProfile> read_print_profile(const std::string& name_or_path, const std::string& board_path);

}  // namespace plumbline
