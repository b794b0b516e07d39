#pragma once
/// Resin and print settings: board/profiles/*.toml, each key explained in board/README.md.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/settings/board_file.hpp"
#include "firmware/settings/check_policy.hpp"
#include "firmware/settings/exposure_test.hpp"
#include "firmware/settings/print_fields.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/resin/peel_force.hpp"
#include "slicer/slice_settings.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware::inline settings {

/// mm: largest absolute_correction, either way.
inline constexpr double kMostMoved = 0.5;

/// By Grey.
inline constexpr std::array<std::string_view, 3> kGreyWords = {"off", "vertical", "full"};

/// Names are those of PrusaSlicer's SLA settings where it has one. Every number is inside the range given in
/// board/README.md. Heights in mm, times in s, speeds in mm/min, as resin users know them; PrintPlan has them as types.
struct PrintProfile {
  std::string name;              ///< [profile]
  double penetration_depth = 0;  ///< [resin] mm: Dp of Jacobs' working curve Cd = Dp ln(E / Ec)
  double critical_energy = 0;    ///< [resin] mJ/cm2: Ec of that curve
  std::optional<double>
      exchange;       ///< [resin] 0: doses of layers add up, 1: each lift brings fresh resin. None: not known
  double blur = 0.5;  ///< [resin] pixels: sigma of the Gaussian that blurs the light
  /// [resin] by how much larger than the object its masks are, along x, y and z: times the printer's relative_correction
  std::array<double, 3> material_correction = {1, 1, 1};
  PeelSettings peel;                     ///< [resin] green_strength, plate_adhesion and peel_...
  double bottle_cost = 0;                ///< [resin] of a bottle, in any currency; 0: unknown
  double bottle_volume = 0;              ///< [resin] ml of a bottle; 0: unknown
  double layer_height = 0;               ///< [print] mm; of an adaptive print, that of the exposures
  double min_layer_height = 0.02;        ///< [print] mm, of an adaptive print
  double max_layer_height = 0.1;         ///< [print] mm, of an adaptive print
  bool adaptive = false;                 ///< layers are as high as the surface allows
  Grey grey = Grey::kOff;                ///< [print]
  double initial_layer_height = 0;       ///< mm, of an archive's first layer; 0: as high as the others
  double exposure_time = 0;              ///< [print] s
  double initial_exposure_time = 0;      ///< [print] s, of the bottom layers
  ExposureTest exposure_test;            ///< instead of exposure_time, which is the longest of it
  std::uint32_t bottom_layer_count = 0;  ///< [print] layers exposed for initial_exposure_time
  std::uint32_t faded_layers = 0;        ///< [print] layers after them, over which the exposure falls to exposure_time
  double delay_before_exposure = 0;      ///< [print] s, from the Z stage's stop to the light
  double delay_after_exposure = 0;       ///< [print] s, from the end of the light to the lift
  double lift_height = 0;                ///< [print] mm, first, slow part of the lift: the peel
  double lift_speed = 0;                 ///< [print] mm/min
  double lift_height2 = 0;               ///< [print] mm, second, fast part; 0: none
  double lift_speed2 = 0;                ///< [print] mm/min
  double wait_time_after_lift = 0;       ///< [print] s, at the top
  double retract_speed = 0;              ///< [print] mm/min, first, fast part of the way down
  double retract_height2 = 0;            ///< [print] mm, second, slow part, next to the film; 0: none
  double retract_speed2 = 0;             ///< [print] mm/min
  double elefant_foot_compensation =
      0;                           ///< [print] mm of the bottom layers' outline that get a normal layer's light only
  double absolute_correction = 0;  ///< [print] mm by which every outline is moved, outwards if above 0
  double pause_lift_height = 0;    ///< [print] mm that a pause raises the part
  bool supports_enable = true;     ///< [supports] for jobs that don't say
  SupportSettings supports;        ///< [supports] what they look like
  std::string archive;             ///< name of the archive that has said some of the values; empty: none has
  CheckPolicy checks;              ///< [checks] what happens when the masks have an issue
  std::array<ValueSource, kPrintKeyCount> sources = {};  ///< of the values of [print], in the order of kPrintFields
};

/// Reads a profile; see read_settings_file() for the errors.
/// @param path  as messages show it
[[nodiscard]] Expected<PrintProfile> read_print_profile(const std::string& path);

/// The same from text in memory.
[[nodiscard]] Expected<PrintProfile> parse_print_profile(std::string_view text, std::string_view path);

/// The same by name.
/// @param name_or_path, board_path  see find_profile()
[[nodiscard]] Expected<PrintProfile> read_print_profile(const std::string& name_or_path, const std::string& board_path);

/// The printer's own profile; the defaults without a printer, or if it can't be read.
PrintProfile profile_or_defaults(const std::optional<BoardFile>& board);
/// [checks] of the printer's own profile; the defaults without a printer, or if its profile can't be read.
CheckPolicy checks_of(const std::optional<BoardFile>& board);
/// The [resin] of a board's profile, for the checks; the defaults if there is none or it is wrong.
PeelSettings peel_of(const std::optional<BoardFile>& board);

/// How deep a dose cures: Dp ln(E / Ec), Jacobs' working curve (1992). Negative below Ec.
double cure_depth_mm(const PrintProfile& profile, double dose_mj_cm2);

/// The true size: what a print shrinks by (the printer's correction times the resin's), and by how much its outlines are moved.
/// @param settings  with the lengths of the machine, which become the object's
void correct_sizes(const PrintProfile& profile, const BoardFile& board, SliceSettings& settings);

/// How the light of a print cures; not known if the profile has no `exchange`.
CureModel cure_model(const PrintProfile& profile, const MachineFile& machine);

/// The profile's, or off if the panel shows black and white only.
Grey shown_grey(const PrintProfile& profile, const MachineFile& machine);
/// cure_model() if shown_grey() is not off; else not known.
CureModel grey_model(const PrintProfile& profile, const MachineFile& machine);

/// Height of the R-Rep's layers for a print, mm: of an adaptive one the least.
double finest_layer_mm(const PrintProfile& profile);

/// What the slicer needs to know of the print: the resin, how deep light cures, and how high layers may be.
/// @param settings  after correct_sizes(): its layer height, finest_layer_mm() of the machine, is read
void tell_checks(const PrintProfile& profile, const MachineFile& machine, SliceSettings& settings);

}  // namespace plumbline::firmware::inline settings
