#include "firmware/io/scan_files.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>
#include <utility>

#include "firmware/io/scan_names.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/reader/view_poses.hpp"

namespace plumbline::firmware {
namespace {

namespace fs = std::filesystem;

/// The paths, and instead of each folder those of its scans.
Expected<std::vector<std::string>> with_folders_listed(std::span<const std::string> paths) {
  std::vector<std::string> listed;
  for (const std::string& path : paths) {
    std::error_code problem;
    if (!fs::is_directory(path, problem)) {
      listed.push_back(path);
      continue;
    }
    FolderScans scans;
    for (fs::directory_iterator entry(path, problem), end; !problem && entry != end; entry.increment(problem)) {
      const std::string name = entry->path().filename().string();
      std::error_code unknown;
      if (!name.starts_with('.') && !entry->is_directory(unknown)) scans.add(name);
    }
    if (problem) {
      return fail(ErrorCode::kCannotOpen, "%s: the folder can't be listed: %s", path.c_str(),
                  problem.message().c_str());
    }
    auto found = scans.paths(without_slash(path));
    PLUMBLINE_TRY(found);
    std::move(found->begin(), found->end(), std::back_inserter(listed));
  }
  return listed;
}

/// Points that are read twice make a scan look denser and less noisy than it is.
Status check_each_once(const std::vector<std::string>& paths) {
  std::set<fs::path> seen;
  for (const std::string& path : paths) {
    std::error_code problem;
    const fs::path file = fs::weakly_canonical(path, problem);
    if (!problem && !seen.insert(file).second) {
      return fail(ErrorCode::kBadSetting, "%s is given twice: name each file of the scan once",
                  PrintableText(path).c_str());
    }
  }
  return {};
}

/// Adds each .conf beside the first file that says where any of the files lies.
void add_poses_beside(std::vector<std::string>& paths) {
  const fs::path folder = fs::path(paths.front()).parent_path();
  std::vector<std::string> found;
  std::error_code problem;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, problem), end; !problem && entry != end;
       entry.increment(problem)) {
    std::error_code unknown;
    if (!is_pose_file(entry->path().native()) || !entry->is_regular_file(unknown)) continue;
    std::string text(kMostPoseBytes, ' ');
    std::ifstream(entry->path()).read(text.data(), static_cast<std::streamsize>(text.size()));
    const auto is_named = [&](const std::string& path) {
      return text.find("mesh " + fs::path(path).filename().string() + " ") != std::string::npos;
    };
    if (std::any_of(paths.begin(), paths.end(), is_named)) found.push_back(folder / entry->path().filename());
  }
  std::sort(found.begin(), found.end());
  paths.insert(paths.end(), found.begin(), found.end());
}

}  // namespace

Expected<ScanFiles> ScanFiles::open(std::span<const std::string> paths) {
  auto listed = with_folders_listed(paths);
  PLUMBLINE_TRY(listed);
  put_poses_last(*listed);
  if (listed->size() > 1 && !is_pose_file(listed->back())) add_poses_beside(*listed);
  if (listed->empty() || listed->size() > kMostScans) {
    return fail(
        ErrorCode::kBadSetting,
        "a scan of %zu files was given; it may have 1 to %zu. Join some of them: text files can be concatenated",
        listed->size(), kMostScans);
  }
  PLUMBLINE_TRY(check_each_once(*listed));
  ScanFiles scan;
  scan.files_.reserve(listed->size());
  for (const std::string& path : *listed) {
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

}  // namespace plumbline::firmware
