#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/daemon/answers.hpp"
#include "firmware/daemon/daemon_settings.hpp"
#include "firmware/daemon/state_recorder.hpp"
#include "firmware/daemon/stick/scan_slicing.hpp"
#include "firmware/daemon/stick/stick_job.hpp"
#include "firmware/daemon/stick/stick_scans.hpp"
#include "firmware/state/client_request.hpp"
#include "hal/events.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// What is on a stick, and what of it would be printed if somebody pressed start. Each change is recorded.
class StickOffer {
 public:
  /// Reads what a stick or the store of uploads has, and offers the scan that was at hand, else the first. Each has the settings that were
  /// kept. Both settings and recorder must outlive the offer.
  /// @param uploaded  it is the store
  /// @retval the errors of list_scans(), of ScanSlicing::read_job() and of find_files()
  /// @retval ErrorCode::kNoPoints  there is no scan
  [[nodiscard]] static Expected<StickOffer> read(const StickMount& mount, ScanSlicing& slicing,
                                                 const DaemonSettings& settings, StateRecorder& recorder,
                                                 bool uploaded);

  const StickJob& job() const { return job_; }
  /// Scans and series to choose from; 1 if a job file says what is printed.
  std::size_t choices() const { return has_job_file() ? 1 : scans_.list.size(); }
  /// The names of a choice's files. @pre choice < choices(), and there is no job file
  const std::vector<std::string>& files_of(std::size_t choice) const { return scans_.list[choice].names; }
  /// Whether nobody has to choose: a job file, or one scan in the top folder and nothing else. That scans are parts of one is only a guess.
  bool is_certain() const {
    const bool in_folder = job_.scans[0].find('/') != std::string::npos;
    return has_job_file() || (choices() == 1 && scans_.folders.empty() && job_.scans.size() == 1 && !in_folder);
  }

  /// Says what would be printed, and waits for what people make of it. Pause chooses the next scan.
  /// @param is_new  whether a scan has been uploaded since, which is then offered instead
  /// @returns start: job() is wanted; otherwise cancel, the stick's departure, the arrival of another stick or of an upload, or a shutdown
  [[nodiscard]] Expected<EventKind> ask(Answers& answers, const std::function<bool()>& is_new);
  /// Whether somebody wants to see the best ways up, since the last call. Then ask() has returned start.
  bool take_wish() { return std::exchange(wishes_, false); }
  /// Opens the folder that somebody wants to see, since the last call. Then ask() has returned start.
  /// @returns whether somebody does. One in which there is nothing stays closed
  /// @retval the errors of list_scans() but those of the folder
  [[nodiscard]] Expected<bool> open_folder(const StickMount& mount, ScanSlicing& slicing);
  /// They are there: one can be chosen.
  /// @param drawn  their pictures
  void propose(const Proposals& proposals, const ProposalPictures& drawn);
  /// Chooses a scan, changes a setting, or wishes for proposals or a folder, as a client asks.
  /// @param request  choose, set, propose or open
  /// @retval ErrorCode::kBadSetting  no such scan or folder, or the errors of change_job(); nothing has changed
  [[nodiscard]] Status change(const ClientRequest& request);

 private:
  StickOffer(const DaemonSettings& settings, StateRecorder& recorder) : settings_(&settings), recorder_(&recorder) {}
  bool has_job_file() const { return !scans_.job_file.view().empty(); }
  void show() const;
  void choose(std::size_t scan);
  void take(std::size_t scan);
  Status wish_folder(std::uint32_t number);
  Status set(std::string_view key, std::string_view value);
  void forget_proposals();
  Status set_proposal(StickJob& job, std::string_view value) const;
  void record() const;

  const DaemonSettings* settings_;
  StateRecorder* recorder_;
  StickScans scans_;
  StickJob job_;
  std::optional<Proposals> proposals_;  ///< for the job as it is
  bool uploaded_ = false;
  bool wishes_ = false;
  std::optional<std::string> folder_wish_;
  std::size_t chosen_ = 0;  ///< of the scans and series, if there is no job file
};

}  // namespace plumbline::firmware
