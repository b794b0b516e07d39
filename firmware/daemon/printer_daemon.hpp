#pragma once
/// Runs the printer: waits for a stick and for somebody who wants its job printed, slices and prints it, reports, and waits until
/// somebody has emptied the plate; job after job in the same memory.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <variant>

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
#include "firmware/print/job/job_store.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/settings/print_profile.hpp"
#include "firmware/state/printer_record.hpp"
#include "firmware/state/state_socket.hpp"
#include "hal/machine.hpp"
#include "slicer/core/arena.hpp"

namespace plumbline::firmware {

class PrinterDaemon {
 public:
  /// All must outlive the daemon.
  /// @param arena   over the child's arena_block()
  /// @param record  what the daemon does is written there
  /// @param machine_record  what the printer remembers
  PrinterDaemon(Machine& machine, const DaemonSettings& settings, SlicingChild& child, Arena& arena, JobStore& store,
                MachineRecord& machine_record, DaemonObserver& observer, PrinterRecord& record, Uploads& uploads);

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
    PrintProfile untouched;  ///< the same without what a person has said
    StickJob job;
    std::variant<SlicedScan, JobStore::Received> scan;  ///< sliced, or an archive that was copied
  };
  /// Whether the scans in a port are offered unasked.
  enum class PortState : std::uint8_t {
    kNew,     ///< yes, as soon as the printer is idle
    kServed,  ///< no, they were printed, refused or declined: only when somebody asks
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
  void scans_came();
  /// @param uploaded  those in the port of the uploads, not the stick's
  Status serve_scans(bool uploaded);
  Expected<ReadJob> read_job(const StickMount& mount, const StickJob& job);
  Status print_job(PrintSession& session, ReadJob job);
  Expected<std::optional<StickJob>> choose(const StickMount& mount, bool uploaded);
  /// Finds the best ways up of what is offered.
  Status propose(const StickMount& mount, StickOffer& offer);
  using MakeContract = std::function<Expected<Contract>(const PrintProfile& profile)>;
  using MakeMasks = std::function<Expected<std::unique_ptr<OfferedMasks>>(const Contract&)>;
  /// Tells what will be done and what the checks found, then refuses the job, asks a person or goes on, as profile and board file say.
  /// @param job    its profile gets what the person changes
  /// @param masks  to look at meanwhile
  /// @returns the contract to carry out; none: nobody wants that, and the state says why
  Expected<std::optional<Contract>> agree(ReadJob& job, const PrintGrid& grid, const StackFindings& findings,
                                          const MakeContract& make, const MakeMasks& masks);
  /// @returns what to print of a job; none: nobody wants it
  Expected<std::optional<Printable>> prepare(ReadJob& job, const SlicedScan& sliced);
  /// The same of an archive that was copied; a child checks it first. The job's profile gets the archive's exposures.
  Expected<std::optional<Printable>> prepare(ReadJob& job, JobStore::Received& archive);
  /// Writes reports onto the stick if it asks for them. What goes wrong is only said.
  /// @returns whether it asks
  bool store_reports();
  /// The profile of a job with its values.
  Expected<PrintProfile> profile_for(const StickJob& job) const;
  /// Takes a job that was sliced back to its settings, or changes one, for the next turn: see DaemonCommands::again.
  Expected<bool> again(const ReadJob& job, const ClientRequest& request);
  Status resume();
  void print(PrintSession& session, const PrintProfile& profile);
  void keep_fault(FaultCode code, std::string_view finding);
  void refuse(const Error& error, FaultCode code);
  StickPort& port() { return commands_.of_upload ? uploads_.port() : machine_.stick; }  ///< of the last job
  PortState& last_port() { return commands_.of_upload ? upload_ : stick_; }             ///< of the last job

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
  Surroundings surroundings_;
  Answers answers_;
  FaultCode fault_ = FaultCode::kNone;
  Uploads& uploads_;
  /// A job that was sliced, and is offered again.
  struct Again {
    StickJob job;
    bool at_once;  ///< it is sliced without a question
  };
  std::optional<Again> again_;
  DaemonCommands commands_;  ///< knows what is offered, and whether the last job was that of an upload
  PortState stick_ = PortState::kNew;
  PortState upload_ = PortState::kServed;  ///< a scan that comes is offered first: Uploads::is_new()
};

}  // namespace plumbline::firmware
