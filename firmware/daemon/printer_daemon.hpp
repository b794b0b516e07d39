#pragma once
/// Runs the printer: waits for a stick and for somebody who wants its job printed, slices and prints it, reports, and waits until
/// somebody has emptied the plate; job after job in the same memory.

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "firmware/child/slicing_child.hpp"
#include "firmware/daemon/daemon_observer.hpp"
#include "firmware/daemon/scan_slicing.hpp"
#include "firmware/daemon/state_recorder.hpp"
#include "firmware/daemon/stick_job.hpp"
#include "firmware/print/print_job.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/print/store/job_store.hpp"
#include "firmware/print/store/plate_record.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/state/printer_record.hpp"
#include "firmware/state/state_socket.hpp"
#include "hal/machine.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/printable_text.hpp"

namespace plumbline {

struct DaemonSettings {
  BoardFile board;
  MachineFile machine;
  std::string board_path;  ///< the profiles are in profiles/ beside it
  std::uint32_t threads = 1;
  std::chrono::nanoseconds slicing_patience = kSlicingPatience;
};

class PrinterDaemon final : public CommandTaker {
 public:
  /// All must outlive the daemon.
  /// @param arena   over the child's arena_block()
  /// @param record  what the daemon does is written there
  PrinterDaemon(Machine& machine, const DaemonSettings& settings, SlicingChild& child, Arena& arena, JobStore& store,
                PlateRecord& plate, DaemonObserver& observer, PrinterRecord& record);

  /// Prints jobs until the system shuts down.
  /// @retval ErrorCode::kPowerLost
  /// @retval ErrorCode::kDeviceTimeout  no scan can be sliced any more: the daemon must be started anew
  [[nodiscard]] Status run();

  /// Called while the daemon waits for an event.
  Expected<std::optional<EventKind>> take(const ClientRequest& request) override;

  PrintState state() const { return state_; }  ///< between prints
  FaultCode fault() const { return fault_; }   ///< of the last job; kNone: none

 private:
  /// What is on the stick, and what of it would be printed.
  struct Offer {
    StickScans scans;
    StickJob job;
    std::size_t chosen = 0;  ///< of the scans, if there is no job file
    bool has_job_file() const { return !scans.job_file.view().empty(); }
    std::size_t choices() const { return has_job_file() ? 1 : scans.count; }
  };

  void apply(PrintEvent event);  ///< the one place that changes the state
  Status serve();
  Status settle();
  Expected<bool> has_interrupted();
  Status serve_idle();
  Status serve_interrupted();
  Status serve_plate();
  Status serve_fault();
  Status serve_stick();
  Expected<std::optional<StickJob>> choose(const StickMount& mount);
  Status make_offer(const StickMount& mount, Offer& offer);
  void show(const Offer& offer);
  void choose_scan(Offer& offer, std::size_t scan);
  Status set(Offer& offer, std::string_view key, std::string_view value);
  void record_scans(const StickScans& scans);
  void record_job(const Offer& offer);
  Expected<EventKind> ask(const std::function<void()>& on_next);
  Expected<bool> accept_issues(const StackFindings& findings, const PrintGrid& grid, const CheckPolicy& policy);
  Status print_scan();
  Status resume();
  void print(PrintSession& session, const PrintProfile& profile);
  Expected<PrintProfile> profile_of(const std::string& name) const;
  void refuse(const Error& error, FaultCode code);

  Machine& machine_;
  const DaemonSettings& settings_;
  SlicingChild& child_;
  Arena& arena_;
  JobStore& store_;
  PlateRecord& plate_;
  PrinterRecord& record_;
  StateRecorder observer_;
  ScanSlicing slicing_;
  Offer* offer_ = nullptr;   ///< that somebody is asked about
  bool by_command_ = false;  ///< the event that ask() gets is a command's, which names the question that it answers
  PrintState state_ = PrintState::kIdle;
  FaultCode fault_ = FaultCode::kNone;
  bool served_ = false;      ///< the stick in the port has been printed, refused or declined
  bool told_ready_ = false;  ///< since the printer has become idle
  bool ending_ = false;
};

}  // namespace plumbline
