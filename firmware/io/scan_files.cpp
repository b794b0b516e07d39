#include "firmware/io/scan_files.hpp"

#include "slicer/core/printable_text.hpp"

namespace plumbline {

Expected<ScanFiles> ScanFiles::open(std::span<const std::string> paths) {
  if (paths.empty() || paths.size() > kMostScans) {
    return fail(
        ErrorCode::kBadSetting,
        "a scan of %zu files was given; it may have 1 to %zu. Join some of them: text files can be concatenated",
        paths.size(), kMostScans);
  }
  ScanFiles scan;
  scan.files_.reserve(paths.size());
  for (const std::string& path : paths) {
    auto file = FileSource::open(path);
    PLUMBLINE_TRY(file);
    scan.files_.push_back(std::move(*file));
  }
  for (FileSource& file : scan.files_) scan.sources_.push_back(&file);
  return scan;
}

std::vector<std::string> ScanFiles::names() const {
  std::vector<std::string> names;
  for (const FileSource& file : files_) names.emplace_back(PrintableText(file.name()).view());
  return names;
}

}  // namespace plumbline
