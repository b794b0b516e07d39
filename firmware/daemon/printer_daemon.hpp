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
#include "firmware/daemon/scan_slicing.hpp"
#include "firmware/daemon/stick_job.hpp"
#include "firmware/print/print_job.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/print/store/job_store.hpp"
#include "firmware/print/store/plate_record.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "hal/machine.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/printable_text.hpp"

namespace plumbline {

/// Follows the daemon: a log, or a test.
class DaemonObserver : public PrintObserver, public SlicingObserver {
 public:
  /// "ready", "reading bust.ply", ...
  virtual void say(const PrintableText& text) = 0;
  /// Called when a print has ended, for any reason.
  virtual void printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) = 0;
  /// Called several times a second while nothing is printed.
  virtual void idle() = 0;
};

struct DaemonSettings {
  BoardFile board;
  MachineFile machine;
  std::string board_path;  ///< the profiles are in profiles/ beside it
  std::uint32_t threads = 1;
  std::chrono::nanoseconds slicing_patience = kSlicingPatience;
};

class PrinterDaemon {
 public:
  /// All must outlive the daemon.
  /// @param arena  over the child's arena_block()
  PrinterDaemon(Machine& machine, const DaemonSettings& settings, SlicingChild& child, Arena& arena, JobStore& store,
                PlateRecord& plate, DaemonObserver& observer);

  /// Prints jobs until the system shuts down.
  /// @retval ErrorCode::kPowerLost
  /// @retval ErrorCode::kDeviceTimeout  no scan can be sliced any more: the daemon must be started anew
  [[nodiscard]] Status run();

  PrintState state() const { return state_; }  ///< between prints
  FaultCode fault() const { return fault_; }   ///< of the last job; kNone: none

 private:
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
  DaemonObserver& observer_;
  ScanSlicing slicing_;
  PrintState state_ = PrintState::kIdle;
  FaultCode fault_ = FaultCode::kNone;
  bool served_ = false;      ///< the stick in the port has been printed, refused or declined
  bool told_ready_ = false;  ///< since the printer has become idle
  bool ending_ = false;
};

}  // namespace plumbline
