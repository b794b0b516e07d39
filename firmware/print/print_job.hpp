#pragma once
/// A print from the checks to the raised part: the loop of DESIGN section 5 on the devices of a Machine.
///
///     checks -> home -> [ down -> rest -> mask -> light -> dark -> journal -> rest -> lift ] for each layer -> up
///
/// The mask of layer k + 1 is made while layer k cures. Whatever ends an exposure, the lamp is dark before anything moves.

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/print/journal.hpp"
#include "firmware/print/mask_renderer.hpp"
#include "firmware/print/print_plan.hpp"
#include "firmware/print/print_report.hpp"
#include "firmware/print/print_state.hpp"
#include "hal/await.hpp"
#include "hal/machine.hpp"

namespace plumbline {

/// Limits of the printer and facts of the job that the print needs beside its plan.
struct PrintSettings {
  PrintPlan plan;
  Celsius lamp_resume, lamp_max;  ///< of the board file
  Celsius resin_min, resin_max;   ///< of the board file
  bool has_cover_switch = true;
  double tank_ml = 0;              ///< of a full tank; the print begins with one
  double pixel_ml = 0;             ///< resin in a pixel of a layer
  std::uint64_t cured_pixels = 0;  ///< of all masks together
  std::uint64_t first_layer_pixels = 0;
  Distance cure_depth;                               ///< under the light of a normal layer
  std::size_t memory_needed = 0, memory_budget = 0;  ///< of the arena, bytes
};

/// Where a print is, for whoever watches it.
struct PrintStatus {
  PrintState state = PrintState::kIdle;
  std::uint32_t layer = 0;  ///< at hand, from 0
  std::uint32_t layers = 0;
  ZPosition height;  ///< of that layer
  TimePoint now;
  nanoseconds elapsed{};
  nanoseconds remaining{};
  std::optional<nanoseconds> slack;  ///< of the last mask
  double resin_ml = 0;               ///< used
};

/// Hears of everything that a print comes to.
class PrintObserver {
 public:
  virtual ~PrintObserver() = default;
  /// After each layer, in each new state, and now and then while nothing happens.
  /// @returns false: cancel
  virtual bool update(const PrintStatus& status) = 0;
  /// A check is over.
  virtual void checked(Check check, const CheckResult& result) = 0;
};

/// One print, run once. Takes nothing from the heap.
class PrintJob {
 public:
  /// @param machine    all devices; outlives the job, as do the others
  /// @param masks      of the plan's layers
  /// @param journal    null: none is kept, and a power cut ends the print for good
  /// @param exposures  room for what the report tells of each; its size is what is told
  PrintJob(Machine& machine, const PrintSettings& settings, MaskRenderer& masks, Journal* journal,
           std::span<ExposureLine> exposures, PrintObserver& observer);

  /// Prints until a state at rest. The report has what came of it, errors too.
  /// @param from  the journal's last entry, or that of a print which has not begun
  const PrintReport& run(const JournalEntry& from);

 private:
  // print_job.cpp: the loop
  void apply(PrintEvent event);  ///< the one place that changes the state
  void fault(FaultCode code, const char* message);
  void fail_with(const Error& error);
  Status step();
  Status home();
  Status print_layer();
  Expected<bool> lower();
  Expected<bool> expose();
  Status write_journal();
  void note(const ExposureReport& exposure);
  Status draw(std::uint32_t layer);
  Expected<bool> raise(const StageMove& to);
  Status raise_to_end();
  Status raise_to_pause();
  Status wait_for_user();
  Status wait_for_cover();
  Status cool_down();
  void make_safe();

  // print_job_waits.cpp: waiting, and hearing of what happens meanwhile
  Waiting hear(const Event& event);
  Waiting leave_for(PrintEvent event, bool& heard);
  bool asked_to_stop() const { return shutdown_ || cancel_ || cover_opened_; }
  bool heed();
  Expected<bool> pass(nanoseconds time);
  Expected<bool> move(const StageMove& to);
  Expected<bool> finish(Motion motion);
  void tell();

  // print_checks.cpp
  Status run_checks();
  void check_job();
  void check_resin();
  Status check_devices();
  Status check_temperatures();
  CheckResult& result(Check check) { return report_.checks[static_cast<std::size_t>(check)]; }
  void conclude(Check check, CheckOutcome outcome, FaultCode code);
  Status look_after_temperatures();
  double used_ml() const { return static_cast<double>(entry_.cured_pixels) * settings_.pixel_ml; }

  Machine& machine_;
  const PrintSettings settings_;
  const PrintPlan& plan_ = settings_.plan;
  MaskRenderer& masks_;
  Journal* journal_;
  PrintObserver& observer_;
  std::span<ExposureLine> lines_;
  PrintReport report_;

  PrintState state_ = PrintState::kIdle;
  JournalEntry entry_;    ///< as it would be written now
  nanoseconds before_{};  ///< time of the print's former parts
  TimePoint began_;
  TimePoint layer_began_;
  std::optional<MaskBuffer> mask_;  ///< drawn, not presented yet
  std::uint32_t mask_layer_ = 0;    ///< whose it is
  MaskFacts mask_facts_;            ///< of it
  MaskFacts shown_facts_;           ///< of the mask on the panel
  std::optional<nanoseconds> slack_;
  double poured_ml_ = 0;  ///< used_ml() when the tank was full last

  FaultCode refused_ = FaultCode::kNone;  ///< of the first check that failed
  Check refused_by_ = Check::kMemory;

  // Heard, not yet heeded.
  bool shutdown_ = false;
  bool cancel_ = false;
  bool cover_opened_ = false;
  bool cover_closed_ = false;
  bool pause_ = false;
  bool resume_ = false;
};

}  // namespace plumbline
