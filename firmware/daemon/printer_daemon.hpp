#pragma once
/// Runs the printer: waits for a stick and for somebody who wants its job printed, slices and prints it, reports, and waits until
/// somebody has emptied the plate; job after job in the same memory.

#include <optional>

#include "firmware/child/child_layer_decoder.hpp"
#include "firmware/child/slicing_child.hpp"
#include "firmware/daemon/answers.hpp"
#include "firmware/daemon/daemon_commands.hpp"
#include "firmware/daemon/daemon_observer.hpp"
#include "firmware/daemon/daemon_settings.hpp"
#include "firmware/daemon/offered_masks.hpp"
#include "firmware/daemon/state_recorder.hpp"
#include "firmware/daemon/stick/scan_slicing.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/daemon/stick_offer.hpp"
#include "firmware/daemon/upload/uploads.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/print/store/job_store.hpp"
#include "firmware/print/store/machine_record.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/state/printer_record.hpp"
#include "firmware/state/state_socket.hpp"
#include "hal/machine.hpp"
#include "slicer/core/arena.hpp"

namespace plumbline {

class PrinterDaemon {
 public:
  /// All must outlive the daemon.
  /// @param arena   over the child's arena_block()
  /// @param record  what the daemon does is written there
  /// @param machine_record  what the printer remembers
  /// @param uploads  null: none are taken
  PrinterDaemon(Machine& machine, const DaemonSettings& settings, SlicingChild& child, Arena& arena, JobStore& store,
                MachineRecord& machine_record, DaemonObserver& observer, PrinterRecord& record,
                Uploads* uploads = nullptr);

  /// Prints jobs until the system shuts down.
  /// @retval ErrorCode::kPowerLost
  /// @retval ErrorCode::kDeviceTimeout  no scan can be sliced any more: the daemon must be started anew
  [[nodiscard]] Status run();

  CommandTaker& commands() { return commands_; }
  FaultCode fault() const { return fault_; }  ///< of the last job; kNone: none

 private:
  /// A job as read from its stick, which may be pulled now.
  struct ReadJob {
    ScanRequest request;
    PrintProfile profile;
    std::optional<CheckedAnswer> scan;          ///< sliced; or
    std::optional<JobStore::Received> archive;  ///< copied
    std::optional<StickJob> offered;            ///< none: it came from a job file
    PrintValues by_person{};                    ///< what the job says of the print's values
  };

  void apply(PrintEvent event);  ///< the one place that changes the state between prints
  bool has_report() const;       ///< that of the last print is there
  bool ending() const;           ///< the system shuts down
  Status serve();
  Status settle();
  Status serve_idle();
  Status serve_interrupted();
  Status serve_plate();
  Status serve_fault();
  void show_unseen_fault();
  bool has_new_upload() const;
  void scans_came();
  Status serve_upload();
  /// @param port  the stick's, or that of the uploads
  Status serve_scans(StickPort& port, bool uploaded);
  Status read_job(const StickMount& mount, const StickJob& job, std::optional<ReadJob>& read);
  Status print_job(PrintSession& session, ReadJob& job);
  Expected<std::optional<StickJob>> choose(const StickMount& mount, bool uploaded);
  /// Finds the best ways up of what is offered.
  Status propose(const StickMount& mount, StickOffer& offer);
  /// Tells what the checks found, then refuses the job, asks a person or goes on, as the policy and the board file say.
  /// @param masks  to look at meanwhile; may be null
  /// @returns whether to go on
  Expected<bool> accept(const PrintGrid& grid, const StackFindings& findings, OfferedContract& offered,
                        const CheckPolicy& policy, OfferedMasks* masks);
  /// Prepares a session to print what was read, if somebody wants it.
  Expected<bool> prepare_scan(PrintSession& session, ReadJob& job);
  /// The same for an archive that was copied; a child checks it first. The job's profile gets the archive's exposures.
  Expected<bool> prepare_archive(PrintSession& session, ReadJob& job);
  /// Writes reports onto the stick if it asks for them. What goes wrong is only said.
  /// @returns whether it asks
  bool store_reports();
  Status resume();
  void print(PrintSession& session, const PrintProfile& profile);
  void keep_fault(FaultCode code, std::string_view finding);
  void refuse(const Error& error, FaultCode code);

  Machine& machine_;
  const DaemonSettings& settings_;
  SlicingChild& child_;
  Arena& arena_;
  JobStore& store_;
  MachineRecord& machine_record_;
  PrinterRecord& record_;  ///< holds the state
  StateRecorder observer_;
  ScanSlicing slicing_;
  ChildLayerDecoder decoder_;
  Answers answers_;
  FaultCode fault_ = FaultCode::kNone;
  Uploads* uploads_;
  std::optional<StickJob> printed_;  ///< the last job; none: it came from a job file, or there was none
  DaemonCommands commands_;          ///< knows what is offered, and whether the last job was that of an upload
  bool upload_served_ = true;        ///< the uploaded scan is offered when it comes, and when somebody asks
  bool served_ = false;              ///< the stick in the port has been printed, refused or declined
  bool told_ready_ = false;          ///< since the printer has become idle
};

}  // namespace plumbline
