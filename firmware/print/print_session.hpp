#pragma once
/// One print in the printer's memory, to its report. The next print takes the same memory.

#include <optional>
#include <span>
#include <variant>

#include "firmware/print/job/job_store.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/job/mask_renderer.hpp"
#include "firmware/print/job/mask_source.hpp"
#include "firmware/print/job/printable.hpp"
#include "firmware/print/loop/print_settings.hpp"
#include "firmware/print/status/print_observer.hpp"
#include "firmware/settings/board_file.hpp"
#include "hal/machine.hpp"
#include "slicer/core/arena.hpp"

namespace plumbline::firmware {

class PrintSession {
 public:
  /// Room in the report for exposures beyond most_exposures(): one that was interrupted takes two.
  static constexpr std::size_t kSpareExposures = 256;

  /// @param arena  all of it is the session's. Must outlive it, as must board and store
  /// @param store  null: nothing is stored, so a power cut ends the print for good
  /// @param decoder  of an archive's layers; null: this process decodes them
  PrintSession(const BoardFile& board, const MachineFile& machine, Arena& arena, JobStore* store,
               LayerDecoder* decoder = nullptr);

  /// Takes what is to be printed, and stores it.
  /// @param what  its masks are in this session's arena, at its bottom. A print without an id gets one
  /// @retval any error of check_plan(), JobStore::begin() and Journal::open()
  [[nodiscard]] Status take(Printable what);

  /// Loads the interrupted print.
  /// @retval any error of JobStore::load(), Journal::open() and check_plan()
  /// @retval ErrorCode::kUnsupported  it was made for another printer, or by another version
  [[nodiscard]] Status load();

  /// Prints. @pre take() or load() was called, once. A print that ends for good, or that the checks refuse before its first layer, is
  /// removed from the store.
  /// @param record  durable when it returns; null: the tank is full, and nobody keeps a record
  PrintReport print(Machine& machine, PrintObserver& observer, MachineRecord* record = nullptr);

  const Printable& printable() const { return what_; }
  const Contract& contract() const { return what_.facts.contract; }
  const PrintPlan& plan() const { return contract().plan; }
  const PrintGrid& grid() const { return what_.parts.rrep.grid; }
  /// The mask of a layer. @pre the print is not running
  [[nodiscard]] Expected<ConstBitImage> mask(std::uint32_t layer) { return source().mask(layer); }
  MaskFigures mask_figures() const { return firmware::mask_figures(lines_, scratch_); }
  double pixel_ml() const;   ///< of the layers but the first
  double needed_ml() const;  ///< resin in all masks

 private:
  [[nodiscard]] Status make_ready();
  MaskSource& source();
  /// Resin that the first layer takes more than one of the usual height.
  double first_layer_more_ml() const;
  PrintSettings settings() const;

  const BoardFile& board_;
  const MachineFile& machine_;
  Arena& arena_;
  BottomScope bottom_;
  ArenaScope top_;
  JobStore* store_;

  Printable what_;
  bool resumed_ = false;  ///< load() was called
  PlanRun run_;           ///< of the plan
  OwnLayerDecoder own_decoder_;
  LayerDecoder* decoder_;
  std::variant<std::monostate, StreamMasks, ArchiveMasks> source_;
  std::optional<MaskRenderer> masks_;
  std::optional<JournalFile> journal_file_;
  std::optional<Journal> journal_;
  std::span<ExposureLine> lines_;  ///< room for the report's exposures; once it has printed, those
  std::span<nanoseconds> scratch_;
  MachineRecord unkept_{machine_.tank_volume_ml};
};

}  // namespace plumbline::firmware
