#include "firmware/daemon/stick_offer.hpp"

#include <optional>
#include <string>
#include <utility>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/daemon/stick/job_setting.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/printer_code.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {
namespace {

tl::unexpected<Error> nothing_on(const StickScans& scans) {
  FixedText<120> unseen;
  Told told(PrinterCode::kStickEmpty);
  if (const std::size_t count = scans.partitions_left_out; count > 0) {
    unseen.add(" (%zu partition%s can't be read)", count, plural_s(count));
    told.add(static_cast<Fact>(PrinterFact::kPartitions), static_cast<double>(count));
  }
  if (const std::size_t count = scans.folders_left_out; count > 0) {
    unseen.add(" (%zu folder%s not looked into)", count, count == 1 ? " was" : "s were");
    told.add(static_cast<Fact>(PrinterFact::kFolders), static_cast<double>(count));
  }
  return telling(told, fail(ErrorCode::kNoPoints,
                            "there is no scan or mesh on the stick, nor a sliced archive%s:\tput an STL, OBJ, PLY, "
                            "OFF, 3MF, PCD, XYZ or .sl1 file on a stick with FAT32 or exFAT",
                            unseen.c_str()));
}

/// The settings of a job that decide where its object lies on the plate.
JobSettings placing(JobSettings job) {
  job.layer_height = 0;
  job.values = {};
  job.supports = {};
  return job;
}

/// @retval ErrorCode::kBadSetting  they are off, too
Expected<SupportSettings> supports_of(const StickJob& job, const DaemonSettings& daemon) {
  const auto profile = daemon.profile(job.profile);
  PLUMBLINE_TRY(profile);
  const auto supports = job.supports.over(profile->supports_enable, profile->supports);
  PLUMBLINE_TRY(supports);
  if (!*supports) return fail(ErrorCode::kBadSetting, "supports are off");
  return **supports;
}

}  // namespace

Expected<StickOffer> StickOffer::read(const StickMount& mount, ScanSlicing& slicing, const DaemonSettings& settings,
                                      StateRecorder& recorder, bool uploaded, const std::optional<StickJob>& printed) {
  const auto look = [&] { return slicing.look(mount); };
  // After a print the folder from which it came is still open.
  auto scans = list_scans(mount, uploaded ? std::string() : recorder.folder(), look);
  const bool lost = scans ? scans->list.empty() : scans.error().code() == ErrorCode::kCannotRead;
  if (lost && !uploaded && !recorder.folder().empty()) scans = list_scans(mount, {}, look);
  PLUMBLINE_TRY(scans);
  StickOffer offer(settings, recorder);
  offer.scans_ = std::move(*scans);
  offer.uploaded_ = uploaded;
  const bool known = recorder.found(offer.scans_, uploaded);
  if (offer.has_job_file()) {
    const std::string_view job_file = offer.scans_.job_file.view();
    auto file = mount.open(job_file);
    PLUMBLINE_TRY(file);
    auto job = slicing.read_job(mount, *file);
    PLUMBLINE_TRY(job);
    offer.job_ = std::move(*job);
    for (std::string& scan : offer.job_.scans) scan = mount.name_beside(job_file, scan);
    PLUMBLINE_TRY(find_files(offer.job_, mount));
  } else if (offer.choices() == 0 && offer.scans_.foreign) {
    return tl::unexpected<Error>(*offer.scans_.foreign);
  } else if (offer.choices() == 0) {
    return nothing_on(offer.scans_);
  } else {
    offer.job_.scans = offer.files_of(0);
    for (std::size_t i = 0; known && printed && i < offer.choices(); ++i) {
      if (offer.files_of(i) != printed->scans) continue;
      offer.chosen_ = i;
      offer.job_ = *printed;
    }
    if (offer.scans_.foreign) recorder.tell(offer.scans_.foreign->message(), offer.scans_.foreign->told());
  }
  offer.record();
  return offer;
}

Expected<bool> StickOffer::open_folder(const StickMount& mount, ScanSlicing& slicing) {
  const auto wish = std::exchange(folder_wish_, std::nullopt);
  if (!wish) return false;
  auto scans = list_scans(mount, *wish, [&] { return slicing.look(mount); });
  if (!scans && scans.error().code() != ErrorCode::kCannotRead) return tl::unexpected<Error>(scans.error());
  if (!scans) {
    recorder_->tell(scans.error().message(), {});
  } else if (!scans->list.empty()) {
    scans_ = std::move(*scans);
    recorder_->found(scans_, uploaded_);
    forget_proposals();
    clear_supports();
    take(0);
  }
  return true;
}

Expected<EventKind> StickOffer::ask(Answers& answers, const std::function<bool()>& is_new) {
  answers.put();
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
  if (request.command == Command::kOpen) return wish_folder(request.folder);
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

/// @pre scan < choices()
void StickOffer::choose(std::size_t scan) {
  if (choices() == 1) return;
  if (chosen_ != scan) forget_proposals();
  if (chosen_ != scan) clear_supports();
  take(scan);
}

void StickOffer::take(std::size_t scan) {
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

/// @param number  of the folders in the list, from 1; 0: the folder above
Status StickOffer::wish_folder(std::uint32_t number) {
  if (number > scans_.folders.size() || (number == 0 && scans_.folder.empty())) {
    return telling(Told(PrinterCode::kNoSuchFolder, {{Fact::kCount, number}}),
                   fail(ErrorCode::kBadSetting, "there is no folder %u here: there are %zu%s", number,
                        scans_.folders.size(), scans_.folder.empty() ? "" : ", and 0, the one above"));
  }
  folder_wish_ = number == 0 ? std::string(parent_of(scans_.folder)) : scans_.folders[number - 1].name;
  return {};
}

void StickOffer::propose(const Proposals& proposals, const ProposalPictures& drawn) {
  proposals_ = proposals;
  recorder_->proposed(proposals, drawn);
}

void StickOffer::forget_proposals() {
  proposals_.reset();
  recorder_->forget_proposals();
}

bool StickOffer::renew(const StickJob& job) {
  if (job_.scans != job.scans) return false;
  job_ = job;
  record();
  return true;
}

/// Clears supports set by hand, which hold for one object in one size, orientation and height above the plate.
void StickOffer::clear_supports() {
  if (!job_.supports.has_places()) return;
  job_.supports.places = {};
  recorder_->tell(
      "supports set by hand were cleared, because the object, its size, its orientation or its height above the plate "
      "has changed. Set them again once it is sliced",
      PrinterCode::kSupportsCleared);
}

Status StickOffer::set(std::string_view key, std::string_view value) {
  const StickJob before = job_;
  if (key == "profile") {
    PLUMBLINE_TRY(settings_->profile(std::string(value)));
    job_.profile = value;
  } else if (key == "proposal") {
    PLUMBLINE_TRY(set_proposal(value));
  } else if (is_archive_name(job_.scans[0]) && find_print_field(key) == nullptr) {
    return telling(Told(PrinterCode::kArchiveSettings, {}, job_.title()),
                   fail(ErrorCode::kBadSetting,
                        "%s: is sliced already, so only its profile, exposures, lifts and waits can be set",
                        job_.title().c_str()));
  } else {
    PLUMBLINE_TRY(set_job_setting(job_, key, value));
  }
  const auto supports = supports_of(job_, *settings_);
  if (!supports && job_.supports.has_places() && before.supports.places != job_.supports.places) {
    job_ = before;
    return tl::unexpected<Error>(supports.error());
  }
  // Their figures hold for one size, layer height and choice of supports.
  const bool same = before.units == job_.units && before.as == job_.as && before.scale == job_.scale &&
                    before.fit == job_.fit && before.size == job_.size && before.keep_clean == job_.keep_clean &&
                    before.supports == job_.supports && before.layer_height == job_.layer_height && key != "profile" &&
                    (before.rotate_z_deg == job_.rotate_z_deg || !job_.fit);
  if (!same) forget_proposals();
  if (job_.supports.has_places()) {
    const auto was = supports_of(before, *settings_);
    const bool as_high = supports && was && supports->stand == was->stand && lift_mm(*supports) == lift_mm(*was);
    if (!as_high || placing(before) != placing(job_)) clear_supports();
  }
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

}  // namespace plumbline::firmware
