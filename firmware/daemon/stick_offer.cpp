#include "firmware/daemon/stick_offer.hpp"

#include <optional>
#include <string>
#include <utility>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/daemon/stick/job_setting.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/told/printer_code.hpp"

namespace plumbline {

Expected<StickOffer> StickOffer::read(const StickMount& mount, ScanSlicing& slicing, const DaemonSettings& settings,
                                      StateRecorder& recorder, bool uploaded, const StickJob* printed) {
  const auto scans = list_scans(mount);
  PLUMBLINE_TRY(scans);
  StickOffer offer(settings, recorder);
  offer.scans_ = *scans;
  offer.uploaded_ = uploaded;
  const bool known = recorder.found(*scans, uploaded);
  if (offer.has_job_file()) {
    auto file = mount.open(scans->job_file.view());
    PLUMBLINE_TRY(file);
    auto job = slicing.read_job(mount, *file);
    PLUMBLINE_TRY(job);
    offer.job_ = std::move(*job);
    PLUMBLINE_TRY(find_files(offer.job_, mount));
  } else if (offer.choices() == 0 && scans->foreign) {
    return tl::unexpected<Error>(*scans->foreign);
  } else if (offer.choices() == 0) {
    return telling(Told(PrinterCode::kStickEmpty),
                   fail(ErrorCode::kNoPoints,
                        "there is no scan or mesh on the stick, nor a sliced archive:\tput an STL, OBJ, PLY, OFF, 3MF, "
                        "PCD, XYZ or .sl1 file in its top folder"));
  } else {
    offer.job_.scans = offer.files_of(0);
    for (std::size_t i = 0; known && printed != nullptr && i < offer.choices(); ++i) {
      if (offer.files_of(i) != printed->scans) continue;
      offer.chosen_ = i;
      offer.job_ = *printed;
    }
    if (scans->foreign) recorder.tell(scans->foreign->message(), scans->foreign->told());
  }
  offer.record();
  return offer;
}

Expected<EventKind> StickOffer::ask(Answers& answers, const std::function<bool()>& is_new) {
  show();
  while (!is_new()) {
    auto answer = answers.ask([this] { choose((chosen_ + 1) % choices()); });
    if (!answer) return answer;
    if (*answer == EventKind::kStickDeparted && uploaded_) continue;
    if (*answer == EventKind::kStickArrived && !uploaded_ && !is_new())
      continue;  // the one that is read has arrived, too
    return answer;
  }
  return EventKind::kStickArrived;
}

Status StickOffer::change(const ClientRequest& request) {
  if (request.command == Command::kSet) return set(request.key.view(), request.value.view());
  if (request.command == Command::kPropose) {
    if (is_archive_name(job_.scans[0])) {
      return fail(ErrorCode::kBadSetting, "%s: is sliced already, so it can't be turned", job_.title().c_str());
    }
    wishes_ = true;
    return {};
  }
  if (request.scan > choices()) {
    return telling(
        Told(PrinterCode::kNoSuchScan, {{Fact::kCount, request.scan}}),
        fail(ErrorCode::kBadSetting, "there is no scan %u on the stick: it has %zu", request.scan, choices()));
  }
  choose(request.scan - 1);
  return {};
}

void StickOffer::show() const {
  const bool several = choices() > 1;
  FixedText<400> text;
  if (several) text.add("scan %zu of %zu: ", chosen_ + 1, choices());
  if (has_job_file()) text.add("%s asks for ", scans_.job_file.c_str());
  if (job_.scans.size() > 1) text.add("%zu scans as one: ", job_.scans.size());
  text.add("%s. Press start to print it%s", job_.title().c_str(),
           several ? ", pause for the next one, cancel for none" : "");
  recorder_->say(text.view());
}

/// The files of a choice: those of a series come after the single scans.
std::vector<std::string> StickOffer::files_of(std::size_t choice) const {
  if (choice >= scans_.count) return scans_.series[choice - scans_.count].names;
  return {std::string(scans_.list[choice].name.view())};
}

/// @pre scan < choices()
void StickOffer::choose(std::size_t scan) {
  if (choices() == 1) return;
  if (chosen_ != scan) forget_proposals();
  chosen_ = scan;
  const bool was_archive = is_archive_name(job_.scans[0]);
  job_.scans = files_of(scan);
  const bool is_archive = is_archive_name(job_.scans[0]);
  JobSettings& settings = job_;
  if (is_archive && !was_archive) of_scans_ = std::exchange(settings, JobSettings());
  if (was_archive && !is_archive) settings = of_scans_;
  record();
  show();
}

void StickOffer::propose(const Proposals& proposals, const ProposalPictures& drawn) {
  proposals_ = proposals;
  recorder_->proposed(proposals, drawn);
}

void StickOffer::forget_proposals() {
  proposals_.reset();
  recorder_->forget_proposals();
}

Status StickOffer::set(std::string_view key, std::string_view value) {
  const JobSettings before = job_;
  if (key == "profile") {
    PLUMBLINE_TRY(settings_->profile(std::string(value)));
    job_.profile = value;
  } else if (key == "proposal") {
    PLUMBLINE_TRY(set_proposal(value));
  } else if (is_archive_name(job_.scans[0])) {
    return telling(
        Told(PrinterCode::kArchiveSettings, {}, job_.title()),
        fail(ErrorCode::kBadSetting, "%s: is sliced already, so only its profile can be set", job_.title().c_str()));
  } else {
    PLUMBLINE_TRY(set_job_setting(job_, key, value));
  }
  // Their figures are those of one size.
  const bool sized = job_.fit || job_.size;
  const bool same = before.units == job_.units && before.as == job_.as && before.scale == job_.scale &&
                    before.fit == job_.fit && before.size == job_.size &&
                    (before.rotate_z_deg == job_.rotate_z_deg || !sized);
  if (!same) forget_proposals();
  record();
  return {};
}

/// Turns the job as one of the proposals is turned.
Status StickOffer::set_proposal(std::string_view value) {
  if (!proposals_) {
    return fail(ErrorCode::kBadSetting,
                "proposal: the best orientations are not known.\tSend {\"do\": \"propose\"} first");
  }
  const std::size_t number = value.size() == 1 ? static_cast<std::size_t>(value[0] - '0') : kProposalCount;
  if (number >= kProposalCount) {
    return fail(ErrorCode::kBadSetting, "proposal: found '%.*s', allowed is 0 to %zu", static_cast<int>(value.size()),
                value.data(), kProposalCount - 1);
  }
  const auto& degrees = (*proposals_)[number].degrees;
  job_.rotate_x_deg = degrees[0];
  job_.rotate_y_deg = degrees[1];
  job_.orient = false;
  return {};
}

void StickOffer::record() const {
  recorder_->offered(job_, job_.profile.empty() ? settings_->machine.profile : job_.profile,
                     has_job_file() ? std::nullopt : std::optional(chosen_));
}

}  // namespace plumbline
