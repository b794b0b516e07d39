#include "firmware/daemon/stick/stick_scans.hpp"

#include <algorithm>
#include <iterator>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/daemon/stick/folder_listing.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/io/scan_names.hpp"
#include "firmware/messages/printer_code.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

Error about_inner_job(const std::string& name) {
  return Error::format(ErrorCode::kBadSetting,
                       "%s: is in a folder;\tmove it to the stick's top folder, and give the scan's path in it",
                       PrintableText(name).c_str())
      .tell({PrinterCode::kStickInnerJob, {}, name});
}

/// The newest first, then single files, then by name.
bool comes_first(const StickEntry& a, const StickEntry& b) {
  if (a.modified != b.modified) return a.modified > b.modified;
  if ((a.names.size() == 1) != (b.names.size() == 1)) return a.names.size() == 1;
  return a.names < b.names;
}

/// Sorts entries and keeps the first. @returns how many were left out
std::size_t keep_first(std::vector<StickEntry>& entries, std::size_t most) {
  std::sort(entries.begin(), entries.end(), comes_first);
  const std::size_t over = entries.size() - std::min(entries.size(), most);
  entries.resize(entries.size() - over);
  return over;
}

/// As people sort names: "a" before "B". ASCII only.
bool is_before(const StickFolder& a, const StickFolder& b) {
  const std::string first = in_lower_case(a.name), second = in_lower_case(b.name);
  return first != second ? first < second : a.name < b.name;
}

/// Bytes for which a request has room.
constexpr std::size_t kLongestPath = 255;

bool is_too_long(const StickEntry& entry) {
  return std::any_of(entry.names.begin(), entry.names.end(),
                     [](const auto& name) { return name.size() > kLongestPath; });
}

/// Lists a folder with those below it, the nearest first.
class Walk {
 public:
  Walk(const StickMount& mount, std::string_view top, ListingBudget& budget) : mount_(mount), budget_(budget) {
    scans_.folder = top;
    scans_.partitions_left_out = mount.unread_partitions();
  }

  /// @param listing  of the folder itself
  Status run(const FolderListing& listing) {
    const std::string& top = scans_.folder;
    const std::size_t depth = top.empty() ? 0 : static_cast<std::size_t>(std::count(top.begin(), top.end(), '/')) + 1;
    scans_.list = listing.entries(top, true);
    left_out_of(listing, scans_.list);
    scans_.left_out += listing.count - listing.files.size();
    scans_.left_out += keep_first(scans_.list, StickScans::kMost);
    add_folders(listing, top, depth, std::nullopt);
    for (std::size_t i = 0; i < found_.size(); ++i) PLUMBLINE_TRY(look_into(i));
    finish();
    return {};
  }
  StickScans take() { return std::move(scans_); }

 private:
  struct Found {
    std::string path;
    std::size_t depth = 0;  ///< 1: in the stick's top folder
    std::size_t row = 0;    ///< of rows_
  };
  /// A folder in the one that is listed.
  struct Row {
    std::size_t found = 0;
    std::size_t entries = 0;  ///< with those of the folders below it
  };

  /// Counts what a listing does not have, and takes what nobody could open out of `entries`.
  void left_out_of(const FolderListing& listing, std::vector<StickEntry>& entries) {
    scans_.folders_left_out += listing.folders_left_out + (listing.is_cut ? 1 : 0);
    const auto too_long = std::remove_if(entries.begin(), entries.end(), is_too_long);
    scans_.left_out += static_cast<std::size_t>(entries.end() - too_long);
    entries.erase(too_long, entries.end());
  }

  /// Remembers the folders in a folder, to look into them later.
  /// @param row  of that folder; none: it is the one that is listed
  void add_folders(const FolderListing& listing, const std::string& path, std::size_t depth,
                   std::optional<std::size_t> row) {
    for (const std::string& name : listing.folders) {
      const std::string inner = path_on_stick(path, name, 0);
      if (depth == budget_.limits().depth || found_.size() == budget_.limits().folders || inner.size() > kLongestPath) {
        ++scans_.folders_left_out;
        continue;
      }
      if (!row) rows_.push_back({found_.size(), 0});
      found_.push_back({inner, depth + 1, row.value_or(rows_.size() - 1)});
    }
  }

  Status look_into(std::size_t which) {
    const Found found = found_[which];  // a copy: found_ grows
    if (budget_.is_over()) {
      ++scans_.folders_left_out;
      return {};
    }
    FolderListing listing(budget_);
    const auto listed = mount_.for_each_file(listing, found.path);
    if (!listed && listed.error().code() != ErrorCode::kCannotRead) return listed;
    listing.is_cut = listing.is_cut || !listed;
    if (!listing.job_files.empty()) {  // without it its scan would have the wrong size
      if (!scans_.foreign) scans_.foreign = about_inner_job(path_on_stick(found.path, listing.job_files[0], 0));
      return {};
    }
    auto entries = listing.entries(found.path, false);
    left_out_of(listing, entries);
    // Those that are not kept are listed when the folder is opened.
    rows_[found.row].entries += entries.size() + listing.count - listing.files.size();
    const auto unlikely = std::partition(entries.begin(), entries.end(), [](const StickEntry& entry) {
      return entry.names.size() > 1 || !is_mostly_other(entry.names[0]);
    });
    below_.insert(below_.end(), std::move_iterator(entries.begin()), std::move_iterator(unlikely));
    unlikely_.insert(unlikely_.end(), std::move_iterator(unlikely), std::move_iterator(entries.end()));
    keep_first(below_, StickScans::kMostWithFolders);
    keep_first(unlikely_, StickScans::kMostWithFolders);
    if (foreign_.empty() && !listing.foreign.empty()) foreign_ = path_on_stick(found.path, listing.foreign, 0);
    add_folders(listing, found.path, found.depth, found.row);
    return {};
  }

  void finish() {
    std::vector<StickEntry>& list = scans_.list;
    auto& below = below_.empty() && list.empty() ? unlikely_ : below_;
    const std::size_t room = StickScans::kMostWithFolders - std::min(StickScans::kMostWithFolders, list.size());
    keep_first(below, room);
    list.insert(list.end(), std::move_iterator(below.begin()), std::move_iterator(below.end()));
    keep_first(list, StickScans::kMost);
    auto& folders = scans_.folders;
    for (const Row& row : rows_) {
      if (row.entries > 0) folders.push_back({std::move(found_[row.found].path), row.entries});
    }
    std::sort(folders.begin(), folders.end(), is_before);
    const std::size_t shown = std::min(folders.size(), StickScans::kMostFolders);
    scans_.folders_left_out += folders.size() - shown;
    folders.resize(shown);
    // What lies beside scans in some folder is of no concern.
    if (!scans_.foreign && !foreign_.empty() && list.empty()) {
      scans_.foreign = about_foreign(foreign_, *foreign_format(foreign_));
    }
  }

  const StickMount& mount_;
  ListingBudget& budget_;
  StickScans scans_;
  std::vector<Found> found_;
  std::vector<Row> rows_;
  std::vector<StickEntry> below_, unlikely_;  ///< of the folders below: the newest
  std::string foreign_;
};

Error about_two_jobs(const std::vector<std::string>& names) {
  return Error::format(ErrorCode::kBadSetting, "%s and %s: the stick has two jobs.\tKeep only one of them",
                       PrintableText(names[0]).c_str(), PrintableText(names[1]).c_str())
      .tell({PrinterCode::kStickTwoJobs, {}, names[1]});
}

}  // namespace

bool is_scan_name(std::string_view name) {
  return is_archive_name(name) || (is_scan_file_name(name) && !in_lower_case(name).starts_with(kJobFile));
}

std::string StickScans::name_within(std::string_view name) const {
  std::string shown(name);
  if (!folder.empty()) shown.erase(shown.find(folder + "/"), folder.size() + 1);
  return shown;
}

std::string_view parent_of(std::string_view folder) {
  const auto slash = folder.rfind('/');
  return slash == std::string_view::npos ? std::string_view() : folder.substr(0, slash);
}

Expected<StickScans> list_scans(const StickMount& mount, std::string_view folder, const std::function<Status()>& look,
                                const ListingLimits& limits) {
  ListingBudget budget(limits, look);
  FolderListing listing(budget);
  PLUMBLINE_TRY(mount.for_each_file(listing, folder));
  Walk walk(mount, folder, budget);
  if (!folder.empty()) {
    PLUMBLINE_TRY(walk.run(listing));
    return walk.take();
  }
  if (listing.wrong_job) return tl::unexpected<Error>(*listing.wrong_job);
  if (listing.job_files.size() > 1) return tl::unexpected<Error>(about_two_jobs(listing.job_files));
  if (!listing.job_files.empty()) {
    StickScans scans = walk.take();
    scans.job_file.add("%s", listing.job_files[0].c_str());
    return scans;
  }
  if (listing.nearly_job) return tl::unexpected<Error>(*listing.nearly_job);
  if (listing.wrong_scan) return tl::unexpected<Error>(*listing.wrong_scan);
  PLUMBLINE_TRY(walk.run(listing));
  StickScans scans = walk.take();
  if (!listing.foreign.empty()) scans.foreign = about_foreign(listing.foreign, *foreign_format(listing.foreign));
  return scans;
}

}  // namespace plumbline::firmware
