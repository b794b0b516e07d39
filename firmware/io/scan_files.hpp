#pragma once
/// The files of a job's scan, open.

#include <span>
#include <string>
#include <vector>

#include "firmware/io/file_source.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline {

class ScanFiles {
 public:
  /// @param paths  1 to kMostScans, in the order in which they are to be read
  /// @retval ErrorCode::kCannotOpen   any of them: FileSource::open()
  /// @retval ErrorCode::kBadSetting   too many, or none
  [[nodiscard]] static Expected<ScanFiles> open(std::span<const std::string> paths);

  ScanSources sources() const { return sources_; }
  std::string title() const { return title_of(sources_).c_str(); }
  /// Without their folders.
  std::vector<std::string> names() const;

 private:
  std::vector<FileSource> files_;     ///< as long as it was when sources_ was made
  std::vector<ByteSource*> sources_;  ///< into files_
};

}  // namespace plumbline
