#include "firmware/daemon/stick/stick_scans.hpp"

#include <algorithm>
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

namespace plumbline {
namespace {

Error about_foreign(std::string_view name, const ForeignFormat& format) {
  return Error::format(ErrorCode::kUnknownFormat, "%s %s (%s);\t%s", PrintableText(name).c_str(), format.kind.what,
                       format.program, format.kind.advice)
      .tell({format.kind.code, {}, name});
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
    if (is_scan_file_name(name) && ++count <= StickScans::kMost) files.emplace(name, bytes);
    if (foreign_format(name) != nullptr && (foreign.empty() || name < foreign)) foreign = name;
  }
  void on_folder(std::string_view name) override { folders.emplace(name); }
  void on_other(std::string_view /*name*/, const char* /*what*/) override {}

  std::map<std::string, std::uint64_t> files;
  std::set<std::string> folders;
  std::string foreign;  ///< a file of another kind
  std::size_t count = 0;
};

/// Adds the series of a folder.
/// @param folder  as a prefix: "" or "bust/"
void add_series(StickScans& scans, const std::map<std::string, std::uint64_t>& files, const std::string& folder) {
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
    }
  }
}

/// Finds series in the top folder and in two levels of folders below it. A folder with too many files has none: some of a series might
/// be missing.
Status find_all_series(StickScans& scans, std::set<std::string> folders, const StickMount& mount) {
  if (scans.left_out == 0) {
    std::map<std::string, std::uint64_t> files;
    for (std::size_t i = 0; i < scans.count; ++i) files.emplace(scans.list[i].name.view(), scans.list[i].bytes);
    add_series(scans, files, "");
  }
  std::string foreign;
  for (const std::string& folder : folders) {
    FolderListing listing;
    const auto listed = mount.for_each_file(listing, folder);
    if (!listed && listed.error().code() != ErrorCode::kCannotRead) return listed;
    if (!listed) continue;
    if (listing.count == listing.files.size()) add_series(scans, listing.files, folder + "/");
    if (foreign.empty() && !listing.foreign.empty()) foreign.append(folder).append("/").append(listing.foreign);
    if (folder.find('/') != std::string::npos) continue;
    for (const std::string& inner : listing.folders) {
      if (folders.size() < StickScans::kMostFoldersOfAll) folders.insert(folder + "/" + inner);  // looked into later
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
  if (!has_job) PLUMBLINE_TRY(find_all_series(scans, listing.folders, mount));
  return scans;
}

}  // namespace plumbline
