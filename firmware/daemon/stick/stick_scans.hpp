#pragma once
/// What is on a stick to choose from.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/io/text/fixed_text.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

struct StickScan {
  static constexpr std::size_t kLongestName = 255;
  FixedText<kLongestName + 1> name;
  std::uint64_t bytes = 0;
};

/// Scans in one folder that are parts of one, as their names say: see scan_series.hpp.
struct StickSeries {
  std::vector<std::string>
      names;                ///< on the stick, sorted, 2 to StickScans::kMost; more than kMostScans can't be sliced
  std::uint64_t bytes = 0;  ///< of all
};

/// The scans, meshes and sliced prints in a stick's top folder, by name, then those in two levels of folders below it, then the series of
/// all. In a folder below, files of a series are offered only as one, and no .txt, .csv or .zip alone. A folder with a job.toml is passed over.
struct StickScans {
  static constexpr std::size_t kMost = 64;  ///< scans and series together
  static constexpr std::size_t kMostSeries = 8;
  static constexpr std::size_t kMostFolders = 16;       ///< of the top folder, the first by name
  static constexpr std::size_t kMostFoldersOfAll = 32;  ///< that are looked into
  std::array<StickScan, kMost> list;
  std::size_t count = 0;
  std::vector<StickSeries> series;
  std::size_t left_out = 0;      ///< scans and series for which there was no room
  FixedText<256> job_file;       ///< its name on the stick; empty: there is none
  std::optional<Error> foreign;  ///< about a file of another kind, or a job.toml in a folder
};

/// Whether a file is offered as a scan, by its name: its ending is one of scan_endings.hpp, and it is
/// not a text that comes with scans, such as README.txt.
bool is_scan_name(std::string_view name);

/// @retval ErrorCode::kBadSetting  a job.toml that is not a file; two of them; or a name that looks like a misspelt job.toml's
/// @retval ErrorCode::kCannotOpen  without a job.toml: something with a scan's name that is not a file
/// @retval the errors of StickMount::for_each_file()
[[nodiscard]] Expected<StickScans> list_scans(const StickMount& mount);

}  // namespace plumbline
