#pragma once
/// `plumbline slice` without its command line: a scan file becomes a folder of layers, or an .sl1 archive.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "firmware/io/job_progress.hpp"
#include "firmware/io/scan_files.hpp"
#include "firmware/pictures/png.hpp"
#include "firmware/settings/check_policy.hpp"
#include "firmware/slice/job_archive.hpp"
#include "firmware/slice/job_directory.hpp"
#include "firmware/slice/job_report.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/resin/cure_model.hpp"
#include "slicer/slicer.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware {

/// What an .sl1 archive says besides the masks.
struct ArchiveOutput {
  BoardFile board;
  PrintProfile profile;
  std::function<double(const PrintGrid&)> seconds;  ///< that a print takes, by its machine_grid(); 0: not known
};

struct SliceJobSettings {
  std::vector<std::string> scan_paths;   ///< files of one scan, in this order
  std::string output_path;               ///< a folder, or the archive
  std::optional<ArchiveOutput> archive;  ///< none: a folder
  std::string printer_name;              ///< for the manifest; empty: none
  SliceSettings slice;                   ///< supports: valid by check_support_settings()
  CheckPolicy checks;
  CureModel grey;  ///< of the machine's layers, known if slice.grey is not off. With a printer only
  bool preview = true;
};

/// One job. prepare() takes all the heap memory that the job needs. (One exception: without a printer the size of the masks is unknown until the scan has been read, so their encoder is
/// made when they are admitted, before the first one.)
class SliceJob {
 public:
  /// Opens the scan, the folder, the encoders and the team of threads.
  /// @param arena  must outlive the job; all of it is the job's
  /// @retval ErrorCode::kCannotOpen, kCannotWrite, kOutOfMemory
  [[nodiscard]] static Expected<SliceJob> prepare(const SliceJobSettings& settings, Arena& arena);

  /// Slices and writes. After an error the folder holds nothing of this job, and there is no archive.
  /// @retval ErrorCode::kCancelled  progress said so
  /// @retval ErrorCode::kBadSetting  settings.checks refuse what was found, or ask about it
  /// @retval any error of slice(), JobDirectory, JobArchive and PngEncoder
  [[nodiscard]] Status run(JobProgress& progress);

  const JobReport& report() const { return report_; }

 private:
  static constexpr std::size_t kPages = 3;  ///< preview, coverage, issues

  SliceJob(const SliceJobSettings& settings, Arena& arena, ScanFiles scan)
      : settings_(settings), arena_(&arena), scan_(std::move(scan)) {}

  [[nodiscard]] Status work(JobProgress& progress);
  void plan_layers(const RRep& rrep, const Supports& supports);
  [[nodiscard]] Status write_layers(const RRep& rrep, const Supports& supports, std::span<std::uint64_t> hashes,
                                    JobProgress& progress);
  [[nodiscard]] Status write_archive_end(const RRep& rrep, const Supports& supports);
  [[nodiscard]] Status draw_preview_page(const RRep& rrep, const Supports& supports, std::span<std::uint8_t> rgb);
  [[nodiscard]] Status write_pages(const RRep& rrep, const Supports& supports);
  [[nodiscard]] Status write_manifest_file(std::span<const std::uint64_t> hashes);

  SliceJobSettings settings_;
  Arena* arena_;
  ScanFiles scan_;
  std::optional<JobDirectory> directory_;  ///< one of these
  std::optional<JobArchive> archive_;
  std::optional<PngEncoder> masks_;
  std::array<std::optional<PictureEncoder>, kPages> pictures_;  ///< an archive needs one
  JobReport report_;
};

}  // namespace plumbline::firmware
