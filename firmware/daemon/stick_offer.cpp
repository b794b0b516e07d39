#include "firmware/daemon/stick_offer.hpp"

#include <optional>
#include <string>
#include <utility>

#include "firmware/daemon/stick/job_setting.hpp"
#include "firmware/io/fixed_text.hpp"

namespace plumbline {

Expected<StickOffer> StickOffer::read(const StickMount& mount, ScanSlicing& slicing, const DaemonSettings& settings,
                                      StateRecorder& recorder, bool uploaded) {
  const auto scans = list_scans(mount);
  PLUMBLINE_TRY(scans);
  StickOffer offer(settings, recorder);
  offer.scans_ = *scans;
  offer.uploaded_ = uploaded;
  recorder.found(*scans, uploaded);
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
    return fail(ErrorCode::kNoPoints,
                "there is no scan or mesh on the stick, nor a sliced archive:\tput an STL, OBJ, PLY, OFF, 3MF, "
                "PCD, XYZ or .sl1 file in its top folder");
  } else {
    offer.job_.scans = offer.files_of(0);
    if (scans->foreign) recorder.say(scans->foreign->message());
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
  if (request.scan > choices()) {
    return fail(ErrorCode::kBadSetting, "there is no scan %u on the stick: it has %zu", request.scan, choices());
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
  chosen_ = scan;
  job_.scans = files_of(scan);
  record();
  show();
}

Status StickOffer::set(std::string_view key, std::string_view value) {
  if (key == "profile") {
    PLUMBLINE_TRY(settings_->profile(std::string(value)));
    job_.profile = value;
  } else {
    PLUMBLINE_TRY(set_job_setting(job_, key, value));
  }
  record();
  return {};
}

void StickOffer::record() const {
  recorder_->offered(job_, job_.profile.empty() ? settings_->machine.profile : job_.profile,
                     has_job_file() ? std::nullopt : std::optional(chosen_));
}

}  // namespace plumbline
