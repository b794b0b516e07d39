#include "firmware/daemon/stick/folder_listing.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "firmware/daemon/stick/scan_series.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/io/scan_names.hpp"
#include "firmware/messages/printer_code.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::firmware {
namespace {

/// Whether an operating system has made the folder: for its own files, or as its bin.
bool is_systems_folder(std::string_view name) {
  constexpr std::array<std::string_view, 5> kNames = {"system volume information", "$recycle.bin", "recycler",
                                                      "__macosx", "lost.dir"};
  return std::find(kNames.begin(), kNames.end(), in_lower_case(name)) != kNames.end();
}

bool is_newer(const FolderListing::File& a, const FolderListing::File& b) {
  if (a.facts.modified != b.facts.modified) return a.facts.modified > b.facts.modified;
  return a.name < b.name;
}

}  // namespace

Expected<bool> ListingBudget::spend_entry() {
  ++entries_;
  now_ = HostClock::now();
  if (now_ - looked_ >= limits_.look) {
    PLUMBLINE_TRY(look_());
    looked_ = HostClock::now();
  }
  return !is_over();
}

Expected<bool> FolderListing::goes_on() {
  const auto more = budget_.spend_entry();
  PLUMBLINE_TRY(more);
  is_cut = is_cut || !*more;
  return more;
}

bool FolderListing::wants_facts(std::string_view name) {
  return in_lower_case(name) == kJobFile || (is_scan_name(name) && budget_.has_facts());
}

void FolderListing::on_file(std::string_view name, const StickFileFacts& facts) {
  const std::string lower = in_lower_case(name);
  if (lower == kJobFile) {
    job_files.push_back(path_on_stick({}, name, facts.partition));
  } else if (lower.starts_with(kJobFile)) {
    nearly_job =
        Error::format(ErrorCode::kBadSetting, "%s: looks like the stick's job.\tCall it job.toml, or remove it",
                      PrintableText(name).c_str())
            .tell({PrinterCode::kStickOtherJob, {}, name});
  } else if (foreign_format(name) != nullptr) {
    if (foreign.empty() || name < foreign) foreign = name;
  } else if (is_scan_name(name)) {
    ++count;
    if (!budget_.has_facts()) return;
    File file{std::string(name), facts};
    if (files.size() < StickScans::kMost) {
      files.push_back(std::move(file));
      return;
    }
    const auto oldest = std::max_element(files.begin(), files.end(), is_newer);
    if (is_newer(file, *oldest)) *oldest = std::move(file);
  }
}

void FolderListing::on_folder(std::string_view name) {
  if (in_lower_case(name) == kJobFile || is_scan_name(name)) on_other(name, "a folder");
  if (foreign_format(name) != nullptr) {  // a scan of FARO's is a folder
    if (foreign.empty() || name < foreign) foreign = name;
    return;
  }
  if (is_systems_folder(name)) return;
  folders.emplace(name);
  if (folders.size() <= budget_.limits().folders) return;
  folders.erase(std::prev(folders.end()));
  ++folders_left_out;
}

void FolderListing::on_other(std::string_view name, const char* what) {
  const auto length = static_cast<int>(name.size());
  if (in_lower_case(name) == kJobFile) {
    wrong_job = Error::format(ErrorCode::kBadSetting, "%.*s: %s, not a file.\tPut a file there, or remove it", length,
                              name.data(), what);
  } else if (is_scan_name(name)) {
    wrong_scan = Error::format(ErrorCode::kCannotOpen, "%.*s: %s, not a file.\tRemove it, or name the scan in job.toml",
                               length, name.data(), what);
  }
}

std::vector<StickEntry> FolderListing::entries(std::string_view folder, bool single) const {
  std::vector<StickEntry> entries;
  std::set<std::string> joined;
  if (has_all_files()) {
    std::vector<const File*> own;
    for (const File& file : files) {
      if (file.facts.partition == 0) own.push_back(&file);
    }
    std::sort(own.begin(), own.end(), [](const File* a, const File* b) { return a->name < b->name; });
    std::vector<std::string> names;
    for (const File* const file : own) names.push_back(file->name);
    for (const auto& indices : find_series(names)) {
      StickEntry& series = entries.emplace_back();
      for (const std::size_t i : indices) {
        series.names.push_back(path_on_stick(folder, names[i], 0));
        series.bytes += own[i]->facts.bytes;
        series.modified = std::max(series.modified, own[i]->facts.modified);
        joined.insert(names[i]);
      }
    }
  }
  for (const File& file : files) {
    if (!single && joined.count(file.name) > 0) continue;
    entries.push_back(
        {{path_on_stick(folder, file.name, file.facts.partition)}, file.facts.bytes, file.facts.modified});
  }
  return entries;
}

bool is_mostly_other(std::string_view name) {
  return has_ending(name, ".txt") || has_ending(name, ".csv") || has_ending(name, ".zip");
}

Error about_foreign(std::string_view name, const ForeignFormat& format) {
  return Error::format(ErrorCode::kUnknownFormat, "%s %s (%s);\t%s", PrintableText(name).c_str(), format.kind.what,
                       format.program, format.kind.advice)
      .tell({format.kind.code, {}, name});
}

}  // namespace plumbline::firmware
