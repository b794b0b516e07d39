#pragma once
/// What is on a stick to choose from.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// A scan, a mesh or a sliced print; or scans of one folder that are parts of one, as their names say: see scan_series.hpp.
struct StickEntry {
  /// On the stick: one, or those of a series, sorted. More than kMostScans can't be sliced.
  std::vector<std::string> names;
  std::uint64_t bytes = 0;    ///< of all
  std::int64_t modified = 0;  ///< s since 1970, of the newest
  bool operator==(const StickEntry&) const = default;
};

struct StickFolder {
  std::string name;         ///< on the stick
  std::size_t entries = 0;  ///< scans, meshes, prints and series in it and in the folders below it
};

/// A folder of a stick. The entries are its own and, while there are few of them, the newest of the folders below it: newest first, then by
/// name. In a folder below, files of a series are offered only as one, and no .txt, .csv or .zip alone unless there is nothing else. A folder
/// with a job.toml is passed over.
struct StickScans {
  static constexpr std::size_t kMost = kMostListedScans;
  static constexpr std::size_t kMostWithFolders = 16;  ///< of the folder's own and the others' together
  static constexpr std::size_t kMostFolders = kMostListedFolders;
  std::string folder;  ///< that is listed, a name for StickMount::for_each_file(); empty: the stick's top folder
  std::vector<StickEntry> list;
  std::vector<StickFolder> folders;  ///< those in it that have entries, by name
  std::size_t left_out = 0;          ///< files for which there was no room, or which were beyond the limits
  std::size_t folders_left_out = 0;  ///< that were not looked into to the end, or not listed
  std::size_t partitions_left_out = 0;
  FixedText<256> job_file;       ///< its name on the stick; empty: there is none
  std::optional<Error> foreign;  ///< about a file of another kind, or a job.toml in a folder

  /// A name on the stick as it is shown beside `folder`: "2:bust.ply" of "2:scans/bust.ply" in "scans".
  std::string name_within(std::string_view name) const;
};

/// What a listing looks at, so that it ends on any stick. A person waits for it.
struct ListingLimits {
  std::size_t depth = 8;      ///< of folders in folders, from the stick's top on
  std::size_t folders = 500;  ///< with the longest names they take half of what reserve_heap() has
  std::size_t entries = 20'000;
  /// Then no file's size and date are looked up any more, and then no name is read.
  std::chrono::milliseconds facts{4000}, names{8000};
  std::chrono::milliseconds look{10};  ///< between two looks at buttons and stick
};

/// Whether a file is offered as a scan, by its name: its ending is one of scan_endings.hpp, and it is
/// not a text that comes with scans, such as README.txt.
bool is_scan_name(std::string_view name);

/// The folder that a folder is in. @pre it is not empty
std::string_view parent_of(std::string_view folder);

/// Lists a folder, and looks into those below it.
/// @param folder  as StickScans::folder. That of the top folder includes looking for a job.toml, without which nothing else is listed
/// @param look    called every ListingLimits::look; an error ends the listing
/// @retval ErrorCode::kBadSetting  a job.toml that is not a file; two of them; or a name that looks like a misspelt job.toml's
/// @retval ErrorCode::kCannotOpen  without a job.toml: something with a scan's name that is not a file
/// @retval the errors of StickMount::for_each_file() for `folder`, and of `look`
[[nodiscard]] Expected<StickScans> list_scans(
    const StickMount& mount, std::string_view folder = {},
    const std::function<Status()>& look = [] { return Status(); }, const ListingLimits& limits = {});

}  // namespace plumbline::firmware
