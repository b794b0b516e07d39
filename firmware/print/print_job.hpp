#pragma once
/// A print from the checks to the raised part, on the devices of a Machine:
///
///     checks -> home -> [ lower -> rest -> show mask -> expose -> blank -> journal -> rest -> lift ] for each layer -> raise
///
/// The mask of layer k + 1 is rendered while layer k cures. Whatever ends an exposure, the lamp is dark before anything moves.

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/print/layer_checks.hpp"
#include "firmware/print/mask_renderer.hpp"
#include "firmware/print/plan/print_settings.hpp"
#include "firmware/print/plate_moves.hpp"
#include "firmware/print/print_checks.hpp"
#include "firmware/print/print_watch.hpp"
#include "firmware/print/status/print_observer.hpp"
#include "firmware/print/status/print_report.hpp"
#include "firmware/print/status/print_state.hpp"
#include "firmware/print/store/journal.hpp"
#include "firmware/print/store/machine_record.hpp"
#include "hal/machine.hpp"

namespace plumbline {

/// One print, run once. Takes nothing from the heap.
class PrintJob {
 public:
  /// @param machine    all devices; must outlive the job, as must the others
  /// @param masks      of the plan's layers
  /// @param journal    null: none is kept, and a power cut ends the print for good
  /// @param record     has the resin in the tank; its plate is taken when the checks have passed
  /// @param exposures  room for the report's exposures; those beyond it are only counted
  PrintJob(Machine& machine, const PrintSettings& settings, MaskRenderer& masks, Journal* journal,
           MachineRecord& record, std::span<ExposureLine> exposures, PrintObserver& observer);
  PrintJob(const PrintJob&) = delete;
  PrintJob& operator=(const PrintJob&) = delete;

  /// Prints until a state at rest. Errors become the report's fault.
  const PrintReport& run() { return print({}); }
  /// The same after an interruption. If the stage is not found where the journal says, the print asks the user to measure the part
  /// before it lowers the plate.
  /// @param from  the journal's last entry
  const PrintReport& resume(const JournalEntry& from);

 private:
  /// Whether the journal that is resumed from may lack layers.
  enum class Doubt : std::uint8_t {
    kNone,       ///< the stage or the user has confirmed it, or nothing is resumed
    kUnchecked,  ///< the stage is not homed yet
    kAsked,      ///< the user is to answer by start or cancel
  };

  const PrintReport& print(const JournalEntry& from);
  void apply(PrintEvent event);  ///< the one place that changes the state
  bool apply_pending();
  void go_on();
  void notify();
  void fault(FaultCode code, std::string_view finding, const Told& told = {});
  void fail_with(const Error& error);

  Status step();
  Status run_checks();
  Status home();
  void confirm_journal();
  Status print_layer();
  Status render(std::uint32_t layer);
  bool needs_resin() const;
  void ask_for_resin();
  void note_use();
  Expected<LayerFinding> look_at_machine(bool waits);
  Expected<bool> expose();
  Status layer_cured();
  void record(const ExposureReport& exposure);
  Status write_journal();
  Status write_spare();
  Status note_stand();
  Expected<bool> raise_for_pause();
  Status raise_to_pause();
  Status raise_to_end();
  Status wait_to_raise();
  Status wait_for_start();
  Status wait_for_cover();
  Status cool_down();
  void make_safe();

  double used_ml() const {
    return static_cast<double>(entry_.cured_pixels) * settings_.pixel_ml +
           (entry_.next_layer > 0 ? settings_.first_layer_more_ml : 0);
  }
  /// Of the layer whose mask is rendered.
  double layer_ml() const { return static_cast<double>(mask_facts_.pixels) * settings_.pixel_ml; }
  double left_to_print_ml() const { return settings_.needed_ml() - used_ml(); }
  /// The next layer to cure, or the last one if all are cured.
  std::uint32_t layer_at_hand() const {
    return entry_.next_layer < plan_.layers ? entry_.next_layer : plan_.layers - 1;
  }
  /// From now on the print has `left` to go, of which `after` follows what it does next.
  void expect(nanoseconds left, nanoseconds after);
  nanoseconds time_left();
  nanoseconds elapsed() const { return before_ + (machine_.clock.now() - began_); }

  Machine& machine_;
  const PrintSettings settings_;
  const PrintPlan& plan_ = settings_.plan;
  MaskRenderer& masks_;
  Journal* journal_;
  MachineRecord& record_;
  PrintObserver& observer_;
  PrintReport report_;

  PrintState state_ = PrintState::kIdle;
  PrintWatch watch_{machine_, state_, [this] { notify(); }};
  PlateMoves plate_{machine_.stage, plan_, watch_};
  PrintChecks checks_{machine_, settings_, report_.checks, observer_};
  Doubt doubt_ = Doubt::kNone;
  JournalEntry entry_;    ///< the next entry for the journal, as of now
  nanoseconds before_{};  ///< printing time of earlier runs
  TimePoint began_;
  TimePoint expected_at_;  ///< expect() was called
  nanoseconds left_{}, left_after_{};
  nanoseconds told_left_ = nanoseconds::max();  ///< by time_left()
  std::optional<MaskBuffer> mask_;              ///< rendered, not presented yet
  std::uint32_t mask_layer_ = 0;                ///< the layer of mask_
  MaskFacts mask_facts_;                        ///< of mask_
  MaskFacts shown_facts_;                       ///< of the mask on the panel
  std::optional<nanoseconds> slack_;
  bool at_hand_lit_ = false;        ///< the layer at hand may have had light
  bool tank_is_looked_at_ = false;  ///< since the print began or went on
  double fill_ml_ = 0;              ///< that the tank is to hold when start is pressed
  std::uint32_t fills_before_ = 0;  ///< MachineRecord::fills() when the print asked for it
  LayerFinding hindrance_;          ///< what the print waits for in kCoolingDown
  bool waited_long_ = false;        ///< so long that a person is asked
};

}  // namespace plumbline
