#pragma once
/// Writes down what the daemon does, for the state socket.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/daemon/daemon_observer.hpp"
#include "firmware/daemon/stick/kept_jobs.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/daemon/stick/stick_scans.hpp"
#include "firmware/io/random_id.hpp"
#include "firmware/io/whole_progress.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/stick_port.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Stands between the daemon and its observer.
class StateRecorder final : public DaemonObserver {
 public:
  /// Twice as long as a person needs to read a code and type it.
  static constexpr std::chrono::minutes kCodeTime{2};

  /// All must outlive it.
  /// @param id_seed  see RandomIds
  StateRecorder(PrinterRecord& record, const StickPort& stick, DaemonObserver& observer, std::uint64_t id_seed);

  void say(const PrintableText& text) override;
  bool update(const PrintStatus& status) override;
  void checked(Check check, const CheckResult& result) override;
  void slicing(Stage stage, double fraction) override;
  void begins(const Contract& contract) override;
  void printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) override;
  void plate_emptied() override { observer_.plate_emptied(); }
  void idle() override;
  void mask_made(std::uint32_t layer, ConstBitImage mask) override;

  /// A question is put at `now`.
  void ask(TimePoint now) { record_.ask(ids_.next(), now); }
  /// The question that is put is about something else than before, such as another scan: answers to what it was don't count.
  void ask_about_other() { record_.asks = ids_.next(); }
  /// Forgets the job of before. The next one has another id.
  void begin_job();
  /// Keeps the pictures of what has been sliced. Those with impossible sizes are left out.
  void previewed(const SlicedPictures& drawn);

  /// Keeps the picture of a scan that is listed, if its size is possible.
  void glanced(std::size_t scan, const ScanPicture& drawn);

  /// From now on slicing() is that of proposals, until they are there or given up.
  void proposing();
  /// Keeps ways up, and their pictures if all sizes are possible.
  void proposed(const Proposals& found, const ProposalPictures& drawn);
  /// Forgets them: they are not those of the job any more.
  void forget_proposals();

  /// The uploaded scan is gone, or another one has come.
  void forget_upload();
  /// The folder of the stick that was listed last; empty: its top folder, or another stick's.
  const std::string& folder() const { return folder_; }
  /// The scans of a stick. What was wrong with one of them is remembered as long as the stick is in.
  /// @param uploaded  they are those of the printer's store
  void found(const StickScans& scans, bool uploaded);
  /// What was set for the scans of the stick that is in, and for the uploaded one.
  KeptJobs& kept() { return kept_; }
  /// What would be printed.
  /// @param profile  the job's, or the printer's
  /// @param chosen   index of its scan among those of the stick; none: a job file names it
  void offered(const StickJob& job, std::string_view profile, std::optional<std::size_t> chosen);
  /// What the print will do. Forgets what was doubtful about another one.
  void contracted(const Contract& contract);
  /// A print that goes on.
  void resumed(const PrintSession& session);
  /// Says that supports set by hand do not hold any more.
  void supports_cleared();
  /// Says what the state alone does not.
  void tell(const PrintableText& text, const Told& told);
  /// Says something that whoever prints should know.
  void warn(std::string_view sentence, const Told& told, const Remedies& remedies = {}, const IssuePlaces& places = {});
  /// Says why a job can't be printed and what to do, for somebody who has buttons and a stick.
  void refused(FaultCode code, const Error& error);
  /// Shows a code on the printer's screen, for kCodeTime. @param code  empty: no longer
  void show_code(std::string_view code);

 private:
  void forget_scans();
  /// The stick, and a code whose time is over.
  void look_around();
  void show_layer(std::uint32_t layer);
  void tell_left_out(const StickScans& scans);

  PrinterRecord& record_;
  const StickPort& stick_;
  DaemonObserver& observer_;
  RandomIds ids_;
  std::unique_ptr<JobPictures> pictures_;
  std::unique_ptr<ScanPictures> scan_pictures_;
  std::uint32_t scan_picture_number_;
  KeptJobs kept_;
  WholeProgress whole_;  ///< of what is sliced
  std::string folder_;   ///< as StickScans::folder
  std::chrono::steady_clock::time_point code_until_{};
  std::uint32_t next_layer_ = 0;  ///< of the picture that waits
};

}  // namespace plumbline::firmware
