#pragma once
/// One print in the printer's memory, from its scan or from what was stored of an interrupted print, to its report. The next
/// print takes the same memory.

#include <optional>
#include <span>
#include <string_view>

#include "firmware/print/archive_masks.hpp"
#include "firmware/print/mask_renderer.hpp"
#include "firmware/print/plan/plan_check.hpp"
#include "firmware/print/print_job.hpp"
#include "firmware/print/sliced_archive.hpp"
#include "firmware/print/sliced_scan.hpp"
#include "firmware/print/store/job_store.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/slicer.hpp"

namespace plumbline {

/// Whether a print may begin as its contract says.
using Acceptance = FunctionRef<Status(const Contract& contract)>;
inline constexpr auto kAcceptAll = [](const Contract&) -> Status { return {}; };

class PrintSession {
 public:
  /// Room in the report for exposures beyond one a layer: a layer that was interrupted takes two.
  static constexpr std::size_t kSpareExposures = 256;

  /// @param arena  all of it is the session's. Must outlive it, as must board and store
  /// @param store  null: nothing is stored, so a power cut ends the print for good
  /// @param decoder  of an archive's layers; null: this process decodes them
  PrintSession(const BoardFile& board, const MachineFile& machine, Arena& arena, JobStore* store,
               LayerDecoder* decoder = nullptr);
  ~PrintSession();
  PrintSession(const PrintSession&) = delete;
  PrintSession& operator=(const PrintSession&) = delete;

  /// Slices a scan and gets ready to print. The scan is not needed afterwards.
  /// @param supports  valid by check_support_settings(); none: no supports
  /// @param accept    asked before anything is stored
  /// @retval any error of slice(), find_supports(), plan_print(), `accept`, check_plan(), JobStore::begin(), Journal::open()
  /// @retval ErrorCode::kBadSetting  the profile refuses what the checks of the masks have found, or asks about it
  /// @retval ErrorCode::kCancelled
  [[nodiscard]] Status slice_scan(ScanSources scan, const SliceSettings& settings,
                                  const std::optional<SupportSettings>& supports, const PrintProfile& profile,
                                  ProgressSink* progress, Acceptance accept = kAcceptAll);
  [[nodiscard]] Status slice_scan(ByteSource& scan, const SliceSettings& settings,
                                  const std::optional<SupportSettings>& supports, const PrintProfile& profile,
                                  ProgressSink* progress) {
    ByteSource* const one[] = {&scan};
    return slice_scan(ScanSources(one), settings, supports, profile, progress);
  }

  /// Gets ready to print what another process has sliced.
  /// @param sliced  in this session's arena, at its bottom
  /// @param scan    its name
  /// @retval any error of check_plan() and JobStore::begin()
  /// @param contract  of it: what somebody has seen
  [[nodiscard]] Status take(const SlicedScan& sliced, std::string_view scan, std::string_view profile,
                            const Contract& contract);
  /// The print's id, before take(). Otherwise it gets one of its own.
  void set_id(std::uint64_t id) { facts_.print_id = id; }
  /// Names a file of the scan for the report, before take(). slice_scan() does it itself.
  /// @pre called at most kMostScans times
  void add_scan_file(std::string_view name);

  /// Prepares the print of an archive.
  /// @param sliced   its layers are in this session's arena, at its bottom
  /// @param contract  of it
  /// @param archive  the file; with a store, the copy that JobStore::receive() has made
  /// @param hash     of its bytes
  /// @retval any error of check_plan() and JobStore::begin()
  [[nodiscard]] Status take(const SlicedArchive& sliced, std::string_view name, std::string_view profile,
                            const Contract& contract, Descriptor archive, std::uint64_t hash);

  /// Loads the interrupted print.
  /// @retval any error of JobStore::load(), Journal::open() and check_plan()
  /// @retval ErrorCode::kUnsupported  it was made for another printer, or by another version
  [[nodiscard]] Status load();

  /// Prints. @pre slice_scan(), take() or load() was called, once. A print that ends for good, or that the checks refuse before its
  /// first layer, is removed from the store.
  /// @param record  durable when it returns; null: the tank is full, and nobody keeps a record
  PrintReport print(Machine& machine, PrintObserver& observer, MachineRecord* record = nullptr);

  const SliceReport& sliced() const { return slice_report_; }
  const JobFacts& facts() const { return facts_; }
  const Contract& contract() const { return facts_.contract; }
  const PrintPlan& plan() const { return facts_.contract.plan; }
  const PrintGrid& grid() const { return parts_.rrep.grid; }
  /// For an archive it has only the grid: see mask().
  const RRep& rrep() const { return parts_.rrep; }
  const Supports& supports() const { return parts_.supports; }
  bool is_archive() const { return parts_.is_archive(); }
  /// The mask of a layer. @pre the print is not running
  [[nodiscard]] Expected<ConstBitImage> mask(std::uint32_t layer) { return source_->mask(layer); }
  /// Known only after slice_scan(): the requested settings, the supports by purpose, and the pixels that they add.
  const std::optional<SupportSettings>& support_settings() const { return support_settings_; }
  const SupportCounts& support_counts() const { return support_counts_; }
  std::uint64_t support_pixels() const { return support_pixels_; }
  /// Names of the scan's files; longer ones are cut.
  std::span<const FileName> scan_files() const { return std::span(facts_.files).first(facts_.file_count); }
  /// Of the masks; none for a print resumed from its store, whose masks were checked when it began.
  const std::optional<StackFindings>& findings() const { return findings_; }
  MaskFigures mask_figures() const;
  double pixel_ml() const;   ///< of the layers but the first
  double needed_ml() const;  ///< resin in all masks

 private:
  [[nodiscard]] Status begin(std::string_view scan, std::string_view profile, const Contract& contract,
                             const StackFindings& findings);
  [[nodiscard]] Status make_source();
  [[nodiscard]] Status make_ready();
  /// Resin that the first layer takes more than one of the usual height.
  double first_layer_more_ml() const;

  const BoardFile& board_;
  const MachineFile& machine_;
  Arena& arena_;
  JobStore* store_;
  std::size_t bottom_, top_;

  SliceReport slice_report_;
  JobFacts facts_;
  PlanRun run_;  ///< of the facts' plan
  MaskParts parts_;
  std::optional<SupportSettings> support_settings_;
  SupportCounts support_counts_;
  std::uint64_t support_pixels_ = 0;
  std::optional<StackFindings> findings_;
  Descriptor archive_;
  OwnLayerDecoder own_decoder_;
  LayerDecoder* decoder_;
  std::optional<StreamMasks> stream_masks_;  ///< one of these
  std::optional<ArchiveMasks> archive_masks_;
  MaskSource* source_ = nullptr;
  std::optional<MaskRenderer> masks_;
  std::optional<JournalFile> journal_file_;
  std::optional<Journal> journal_;
  bool resumed_ = false;  ///< load() was called
  std::span<ExposureLine> lines_;
  std::span<nanoseconds> scratch_;
  std::uint64_t first_layer_pixels_ = 0;
  MachineRecord unkept_{machine_.tank_volume_ml};
  std::span<const ExposureLine> exposures_;
};

}  // namespace plumbline
