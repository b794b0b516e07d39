#pragma once
/// The options of a job, and the same options completed from the printer's board file and this computer.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/settings/board_file.hpp"
#include "slicer/slice_settings.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware::inline settings {

struct PrintProfile;

/// As on the command line. Absent options come from the board file or have a default.
struct JobOptions {
  std::vector<std::string> scans;                ///< files of one scan, in this order; 1 to kMostScans
  std::string printer;                           ///< a printer's name or board file; empty: none
  std::optional<double> pixel_pitch_mm;          ///< kFinestMm to kCoarsestMm; without a printer only
  std::optional<double> layer_height_mm;         ///< kFinestMm to kCoarsestMm, or kAdaptiveHeight
  std::optional<double> absolute_correction_mm;  ///< -kMostMoved to kMostMoved
  double scale = 1;                              ///< kSmallestScale to kLargestScale
  bool fit = false;                              ///< with a printer only
  std::optional<PrintSize> size;                 ///< instead of the scale; kSmallestSizeMm to kLargestSizeMm
  std::array<double, 3> rotate_degrees = {};
  Units units = Units::kMillimetres;
  ReadAs as = ReadAs::kAuto;
  BaseChoice base = BaseChoice::kAuto;
  FloorChoice floor;
  bool orient = false;                      ///< turn it the best way up; without rotate_degrees only
  CleanSide keep_clean = CleanSide::kNone;  ///< with `orient` only
  bool keep_all = false;                    ///< keep stray pieces and small cavities
  std::optional<std::uint32_t> arena_mib;   ///< MiB
  std::optional<std::uint32_t> threads;     ///< 1 to kMostThreads
  bool verbose = false;                     ///< also times, memory and counts
  bool quiet = false;
  bool json = false;
};

inline constexpr double kFinestMm = 0.005;
inline constexpr double kCoarsestMm = 1;
inline constexpr double kSmallestScale = 1e-6;
inline constexpr double kLargestScale = 1e6;
inline constexpr std::uint32_t kMostThreads = 64;
inline constexpr std::uint32_t kMostDefaultThreads = 8;  ///< more gain little, and each takes a share of the arena

/// The completed options.
struct JobSetup {
  PlacementSettings placement;     ///< with the lengths of the machine, which slice_settings() corrects
  std::string printer_name;        ///< empty without a printer
  std::optional<BoardFile> board;  ///< none without a printer
  std::size_t arena_bytes = 0;
  ReadAs as = ReadAs::kAuto;
  BaseChoice base = BaseChoice::kAuto;
  FloorChoice floor;
  bool orient = false;
  CleanSide keep_clean = CleanSide::kNone;
  bool keep_all = false;
  PeelSettings peel;                             ///< of the board's profile
  std::optional<double> absolute_correction_mm;  ///< none: the profile's
  std::uint32_t threads = 1;
};

/// The settings of slice() and inspect().
/// @param supports  of the print, which need room on the plate; none: no supports
/// @param profile   of the print; null: the board's own
SliceSettings slice_settings(const JobSetup& setup, const std::optional<SupportSettings>& supports = {},
                             const PrintProfile* profile = nullptr);

/// Completes the options.
/// @param built_bytes  of the largest arena the program was built for
/// @retval ErrorCode::kBadSetting  the job asks for more arena than that, or still for an adaptive layer height
/// @retval any error of read_board_file()
[[nodiscard]] Expected<JobSetup> set_up(const JobOptions& options, std::size_t built_bytes);

/// Starts the threads of later parallel regions now, so that none is made while a job runs.
/// @param threads  JobSetup::threads
void start_threads(std::uint32_t threads);

}  // namespace plumbline::firmware::inline settings
