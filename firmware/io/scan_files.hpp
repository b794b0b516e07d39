#pragma once
/// The open files of a job's scan.

#include <span>
#include <string>
#include <vector>

#include "firmware/io/file_source.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::firmware {

class ScanFiles {
 public:
  /// @param paths  files in the order to read them, and folders, whose scans are read in the order of their names: 1 to kMostScans files.
  ///               A .conf beside the first file that names any of them is read, too
  /// @retval the errors of FolderScans::paths()
  /// @retval ErrorCode::kCannotOpen   any of them: FileSource::open()
  /// @retval ErrorCode::kBadSetting   too many, or none, or one of them twice
  [[nodiscard]] static Expected<ScanFiles> open(std::span<const std::string> paths);

  ScanSources sources() const { return sources_; }
  std::string title() const { return title_of(sources_).c_str(); }
  /// File names without folders, printable.
  std::vector<std::string> names() const;

 private:
  std::vector<FileSource> files_;     ///< never grows after sources_ points into it
  std::vector<ByteSource*> sources_;  ///< into files_
};

}  // namespace plumbline::firmware
