#pragma once
/// Which files are scans or meshes, by their names.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// A name in lower case, for what is the same in any case. ASCII only.
std::string in_lower_case(std::string_view name);

/// Whether a file is read as a scan or a mesh: its ending is one of scan_endings.hpp, and it is not a text that comes with scans, such as
/// README.txt.
bool is_scan_file_name(std::string_view name);

/// The scans of a folder, which together are one scan.
class FolderScans {
 public:
  /// @param name  of a file in the folder; files that are no scans are passed over, but one that can be named is remembered
  void add(std::string_view name);

  /// @param folder  its path, without a slash at the end
  /// @returns the paths of its scans, 1 to kMostScans, sorted by name, and then of any .conf that may say where they lie
  /// @retval ErrorCode::kNoPoints    it has no scans; what another file is and how to export it, if that is known
  /// @retval ErrorCode::kBadSetting  it has more than kMostScans: how many
  [[nodiscard]] Expected<std::vector<std::string>> paths(std::string_view folder) const;

 private:
  std::vector<std::string> names_;  ///< of scans and of .conf files, kMostScans of each at most
  std::size_t count_ = 0;
  std::string foreign_;  ///< the first by name that foreign_format() knows; empty: there is none
};

/// Puts any .conf after the scans, as read_cloud() wants them.
void put_poses_last(std::vector<std::string>& paths);

/// A path without the slashes at its end.
std::string_view without_slash(std::string_view path);

}  // namespace plumbline::firmware
