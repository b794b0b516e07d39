#include "firmware/daemon/stick/stick_scans.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/daemon/stick/scan_series.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/io/scan_names.hpp"
#include "firmware/told/printer_code.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/reader/formats/foreign_formats.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline {
namespace {

Error about_foreign(std::string_view name, const ForeignFormat& format) {
  return Error::format(ErrorCode::kUnknownFormat, "%s %s (%s);\t%s", PrintableText(name).c_str(), format.kind.what,
                       format.program, format.kind.advice)
      .tell({format.kind.code, {}, name});
}

/// Whether an operating system has made the folder: for its own files, or as its bin.
bool is_systems_folder(std::string_view name) {
  constexpr std::array<std::string_view, 5> kNames = {"system volume information", "$recycle.bin", "recycler",
                                                      "__macosx", "lost.dir"};
  return std::find(kNames.begin(), kNames.end(), in_lower_case(name)) != kNames.end();
}

Error about_inner_job(const std::string& name) {
  return Error::format(ErrorCode::kBadSetting,
                       "%s: is in a folder;\tmove it to the stick's top folder, and give the scan's path in it",
                       PrintableText(name).c_str())
      .tell({PrinterCode::kStickInnerJob, {}, name});
}

/// Collects scans and job.toml. Anything that may have been meant as one of them is an error, never skipped: without its
/// job.toml a scan would be printed at the wrong size.
struct StickListing final : StickMount::FileVisitor {
  void on_file(std::string_view name, std::uint64_t bytes) override {
    const auto length = static_cast<int>(name.size());
    const std::string lower = in_lower_case(name);
    if (lower == kJobFile) {
      if (!scans.job_file.view().empty()) {
        wrong_job = Error::format(ErrorCode::kBadSetting, "%s and %.*s: the stick has two jobs.\tKeep only one of them",
                                  scans.job_file.c_str(), length, name.data())
                        .tell({PrinterCode::kStickTwoJobs, {}, name});
        return;
      }
      scans.job_file.add("%.*s", length, name.data());
    } else if (lower.starts_with(kJobFile)) {
      nearly_job =
          Error::format(ErrorCode::kBadSetting, "%.*s: looks like the stick's job.\tCall it job.toml, or remove it",
                        length, name.data())
              .tell({PrinterCode::kStickOtherJob, {}, name});
    } else if (const ForeignFormat* const foreign = foreign_format(name)) {
      if (!scans.foreign) scans.foreign = about_foreign(name, *foreign);
    } else if (is_scan_name(name)) {
      if (scans.count == StickScans::kMost) {
        ++scans.left_out;
      } else {
        StickScan& scan = scans.list[scans.count++];
        scan.name.add("%.*s", length, name.data());
        scan.bytes = bytes;
      }
    }
  }
  void on_folder(std::string_view name) override {
    if (in_lower_case(name) == kJobFile || is_scan_name(name)) return on_other(name, "a folder");
    if (const ForeignFormat* const foreign = foreign_format(name)) {  // a scan of FARO's is a folder
      if (!scans.foreign) scans.foreign = about_foreign(name, *foreign);
      return;
    }
    if (is_systems_folder(name)) return;
    folders.emplace(name);
    if (folders.size() > StickScans::kMostFolders) folders.erase(std::prev(folders.end()));
  }
  void on_other(std::string_view name, const char* what) override {
    const auto length = static_cast<int>(name.size());
    if (in_lower_case(name) == kJobFile) {
      wrong_job = Error::format(ErrorCode::kBadSetting, "%.*s: %s, not a file.\tPut a file there, or remove it", length,
                                name.data(), what);
    } else if (is_scan_name(name)) {
      wrong_scan =
          Error::format(ErrorCode::kCannotOpen, "%.*s: %s, not a file.\tRemove it, or name the scan in job.toml",
                        length, name.data(), what);
    }
  }

  StickScans scans;
  std::set<std::string> folders;
  std::optional<Error> wrong_job, nearly_job, wrong_scan;
};

/// The scans of one folder.
struct FolderListing final : StickMount::FileVisitor {
  void on_file(std::string_view name, std::uint64_t bytes) override {
    if (is_scan_name(name) && ++count <= StickScans::kMost) files.emplace(name, bytes);
    if (foreign_format(name) != nullptr && (foreign.empty() || name < foreign)) foreign = name;
    if (in_lower_case(name) == kJobFile) job_file = name;
  }
  void on_folder(std::string_view name) override {
    const bool is_foreign = foreign_format(name) != nullptr;
    if (is_foreign && (foreign.empty() || name < foreign)) foreign = name;
    if (is_foreign || is_systems_folder(name)) return;
    folders.emplace(name);
    if (folders.size() > StickScans::kMostFoldersOfAll) folders.erase(std::prev(folders.end()));
  }
  void on_other(std::string_view /*name*/, const char* /*what*/) override {}

  std::map<std::string, std::uint64_t> files;
  std::set<std::string> folders;
  std::string foreign;   ///< a file of another kind
  std::string job_file;  ///< which counts in the top folder only
  std::size_t count = 0;
};

/// Whether most files with this ending are no scans or prints, so that in a folder one of them alone is not offered.
bool is_mostly_other(std::string_view name) {
  return has_ending(name, ".txt") || has_ending(name, ".csv") || has_ending(name, ".zip");
}

/// Adds the series of a folder.
/// @param folder  as a prefix: "" or "bust/"
/// @returns the names of their files, without the folder
std::set<std::string> add_series(StickScans& scans, const std::map<std::string, std::uint64_t>& files,
                                 const std::string& folder) {
  std::set<std::string> joined;
  std::vector<std::string> names;
  names.reserve(files.size());
  for (const auto& [name, bytes] : files) names.push_back(name);
  for (const auto& indices : find_series(names)) {
    if (scans.series.size() == StickScans::kMostSeries) {
      ++scans.left_out;
      continue;
    }
    StickSeries& series = scans.series.emplace_back();
    for (const std::size_t i : indices) {
      series.names.push_back(folder + names[i]);
      series.bytes += files.at(names[i]);
      joined.insert(names[i]);
    }
  }
  return joined;
}

/// Adds what a folder has beside its series.
void add_files(StickScans& scans, const FolderListing& listing, const std::set<std::string>& joined,
               const std::string& folder) {
  for (const auto& [name, bytes] : listing.files) {
    if (joined.count(name) > 0 || is_mostly_other(name)) continue;
    const std::string path = folder + name;
    if (scans.count == StickScans::kMost || path.size() > StickScan::kLongestName) {
      ++scans.left_out;
      continue;
    }
    StickScan& scan = scans.list[scans.count++];
    scan.name.add("%s", path.c_str());
    scan.bytes = bytes;
  }
}

/// Finds series in the top folder, and what is in two levels of folders below it. A folder with too many files is passed over: some of a
/// series might be missing.
Status look_into_folders(StickScans& scans, std::set<std::string> folders, const StickMount& mount) {
  if (scans.left_out == 0) {
    std::map<std::string, std::uint64_t> files;
    for (std::size_t i = 0; i < scans.count; ++i) files.emplace(scans.list[i].name.view(), scans.list[i].bytes);
    add_series(scans, files, "");
  }
  std::string foreign;
  for (const std::string& folder : folders) {
    const std::string prefix = folder + "/";
    FolderListing listing;
    const auto listed = mount.for_each_file(listing, folder);
    if (!listed && listed.error().code() != ErrorCode::kCannotRead) return listed;
    if (!listed) continue;
    if (!listing.job_file.empty()) {  // without it its scan would have the wrong size
      if (!scans.foreign) scans.foreign = about_inner_job(prefix + listing.job_file);
      continue;
    }
    if (listing.count == listing.files.size()) {
      add_files(scans, listing, add_series(scans, listing.files, prefix), prefix);
    }
    if (foreign.empty() && !listing.foreign.empty()) foreign = prefix + listing.foreign;
    if (folder.find('/') != std::string::npos) continue;
    for (const std::string& inner : listing.folders) {
      if (folders.size() < StickScans::kMostFoldersOfAll) folders.insert(prefix + inner);  // looked into later
    }
  }
  // What lies beside scans in some folder is of no concern.
  if (!scans.foreign && !foreign.empty() && scans.count == 0 && scans.series.empty()) {
    scans.foreign = about_foreign(foreign, *foreign_format(foreign));
  }
  const std::size_t room = StickScans::kMost - scans.series.size();
  if (scans.count > room) {
    scans.left_out += scans.count - room;
    scans.count = room;
  }
  return {};
}

}  // namespace

bool is_scan_name(std::string_view name) {
  return is_archive_name(name) || (is_scan_file_name(name) && !in_lower_case(name).starts_with(kJobFile));
}

Expected<StickScans> list_scans(const StickMount& mount) {
  StickListing listing;
  PLUMBLINE_TRY(mount.for_each_file(listing));
  if (listing.wrong_job) return tl::unexpected<Error>(*listing.wrong_job);
  StickScans& scans = listing.scans;
  const bool has_job = !scans.job_file.view().empty();
  if (!has_job && listing.nearly_job) return tl::unexpected<Error>(*listing.nearly_job);
  if (!has_job && listing.wrong_scan) return tl::unexpected<Error>(*listing.wrong_scan);
  std::sort(scans.list.begin(), scans.list.begin() + static_cast<std::ptrdiff_t>(scans.count),
            [](const auto& a, const auto& b) { return a.name.view() < b.name.view(); });
  if (!has_job) PLUMBLINE_TRY(look_into_folders(scans, listing.folders, mount));
  return scans;
}

}  // namespace plumbline
