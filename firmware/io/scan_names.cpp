#include "firmware/io/scan_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "slicer/core/words/printable_text.hpp"
#include "slicer/reader/formats/foreign_formats.hpp"
#include "slicer/reader/formats/scan_endings.hpp"
#include "slicer/reader/scan_sources.hpp"
#include "slicer/reader/view_poses.hpp"

namespace plumbline::firmware {

std::string in_lower_case(std::string_view name) {
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return lower;
}

bool is_scan_file_name(std::string_view name) {
  // Text files that come with scans; no scan has such a name.
  constexpr std::array<std::string_view, 7> kTexts = {"readme.txt",  "read me.txt",   "license.txt", "licence.txt",
                                                      "copying.txt", "changelog.txt", "notes.txt"};
  const std::string lower = in_lower_case(name);
  if (std::find(kTexts.begin(), kTexts.end(), lower) != kTexts.end()) return false;
  const auto has_ending = [&lower](std::string_view ending) {
    return lower.size() > ending.size() && std::string_view(lower).ends_with(ending);
  };
  return std::any_of(kMarkedEndings.begin(), kMarkedEndings.end(), has_ending) ||
         std::any_of(kXyzEndings.begin(), kXyzEndings.end(), has_ending);
}

void FolderScans::add(std::string_view name) {
  if (is_pose_file(name) && names_.size() < kMostScans) {
    names_.emplace_back(name);
    return;
  }
  if (!is_scan_file_name(name)) {
    if (foreign_format(name) != nullptr && (foreign_.empty() || name < foreign_)) foreign_ = name;
    return;
  }
  if (++count_ <= kMostScans) names_.emplace_back(name);
}

Expected<std::vector<std::string>> FolderScans::paths(std::string_view folder) const {
  const PrintableText shown(folder, 200);
  if (const ForeignFormat* const foreign = foreign_format(foreign_); count_ == 0 && foreign != nullptr) {
    return fail(ErrorCode::kNoPoints, "%s: the folder has no scans, and %s %s (%s):\t%s", shown.c_str(),
                PrintableText(foreign_, 79).c_str(), foreign->kind.what, foreign->program, foreign->kind.advice);
  }
  if (count_ == 0) {
    return fail(ErrorCode::kNoPoints,
                "%s: the folder has no scans:\tname one with files such as .ply, .stl, .xyz or .e57 in it",
                shown.c_str());
  }
  if (count_ > kMostScans) {
    return fail(ErrorCode::kBadSetting,
                "%s: the folder has %zu scans, but one scan may have %zu files at most:\tjoin some of them, or name "
                "those that are needed",
                shown.c_str(), count_, kMostScans);
  }
  std::vector<std::string> paths;
  for (const std::string& name : names_) paths.push_back(std::string(folder) + "/" + name);
  std::sort(paths.begin(), paths.end());
  put_poses_last(paths);
  return paths;
}

void put_poses_last(std::vector<std::string>& paths) {
  std::stable_partition(paths.begin(), paths.end(), [](const std::string& path) { return !is_pose_file(path); });
}

std::string_view without_slash(std::string_view path) {
  while (path.size() > 1 && path.ends_with('/')) path.remove_suffix(1);
  return path;
}

}  // namespace plumbline::firmware
