#pragma once
/// One folder of a stick, and what may be spent on looking at it.

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/daemon/stick/stick_scans.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"
#include "slicer/reader/formats/foreign_formats.hpp"

namespace plumbline::firmware {

/// What is left of ListingLimits.
class ListingBudget {
 public:
  ListingBudget(const ListingLimits& limits, const std::function<Status()>& look) : limits_(limits), look_(look) {}

  const ListingLimits& limits() const { return limits_; }
  /// @returns whether another name may be read
  Expected<bool> spend_entry();
  bool has_facts() const { return entries_ <= limits_.entries && now_ < began_ + limits_.facts; }
  bool is_over() const { return now_ >= began_ + limits_.names; }

 private:
  using HostClock = std::chrono::steady_clock;
  const ListingLimits& limits_;
  const std::function<Status()>& look_;
  std::size_t entries_ = 0;
  HostClock::time_point began_ = HostClock::now(), now_ = began_, looked_ = began_;
};

/// What a folder has, of all partitions. The newest StickScans::kMost of its scans are kept, whatever their number.
class FolderListing final : public StickMount::FileVisitor {
 public:
  struct File {
    std::string name;
    StickFileFacts facts;
  };

  explicit FolderListing(ListingBudget& budget) : budget_(budget) {}
  void on_file(std::string_view name, const StickFileFacts& facts) override;
  void on_folder(std::string_view name) override;
  void on_other(std::string_view name, const char* what) override;
  void on_unlisted() override { is_cut = true; }
  bool wants_facts(std::string_view name) override;
  Expected<bool> goes_on() override;

  /// Whether every scan in it is among the files, so that those of a series can be told.
  bool has_all_files() const { return files.size() == count && !is_cut; }
  /// The entries that it makes, in no order.
  /// @param folder  as StickScans::folder
  /// @param single  also those that are in a series
  std::vector<StickEntry> entries(std::string_view folder, bool single) const;

  std::vector<File> files;
  std::set<std::string> folders;                           ///< without those that an operating system has made
  std::size_t count = 0;                                   ///< of scans, with those that are not in `files`
  std::size_t folders_left_out = 0;                        ///< beyond ListingLimits::folders
  bool is_cut = false;                                     ///< there may be more in it
  std::vector<std::string> job_files;                      ///< names with their partition
  std::optional<Error> wrong_job, nearly_job, wrong_scan;  ///< which matter in the top folder only
  std::string foreign;                                     ///< the first file of another kind, by name

 private:
  ListingBudget& budget_;
};

/// Whether most files with this ending are no scans or prints.
bool is_mostly_other(std::string_view name);

Error about_foreign(std::string_view name, const ForeignFormat& format);

}  // namespace plumbline::firmware
