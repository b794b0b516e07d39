#include "firmware/daemon/stick_offer.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/daemon/job_change.hpp"
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

}  // namespace

Expected<StickOffer> StickOffer::read(const StickMount& mount, ScanSlicing& slicing, const DaemonSettings& settings,
                                      StateRecorder& recorder, bool uploaded) {
  const auto look = [&] { return slicing.look(mount); };
  // After a print the folder from which it came is still open.
  auto scans = list_scans(mount, uploaded ? std::string() : recorder.folder(), look);
  const bool lost = scans ? scans->list.empty() : scans.error().code() == ErrorCode::kCannotRead;
  if (lost && !uploaded && !recorder.folder().empty()) scans = list_scans(mount, {}, look);
  PLUMBLINE_TRY(scans);
  StickOffer offer(settings, recorder);
  offer.scans_ = std::move(*scans);
  offer.uploaded_ = uploaded;
  recorder.found(offer.scans_, uploaded);
  if (offer.has_job_file()) {
    const std::string_view job_file = offer.scans_.job_file.view();
    auto file = mount.open(job_file);
    PLUMBLINE_TRY(file);
    auto job = slicing.read_job(mount, *file);
    PLUMBLINE_TRY(job);
    for (std::string& scan : job->scans) scan = mount.name_beside(job_file, scan);
    PLUMBLINE_TRY(find_files(*job, mount));
    offer.job_ = recorder.kept().take({.names = job->scans}, uploaded, *job);
    offer.record();
  } else if (offer.choices() == 0 && offer.scans_.foreign) {
    return tl::unexpected<Error>(*offer.scans_.foreign);
  } else if (offer.choices() == 0) {
    return nothing_on(offer.scans_);
  } else {
    const auto at_hand = [&](const StickEntry& scan) { return recorder.kept().at_hand(scan, uploaded); };
    const auto found = std::ranges::find_if(offer.scans_.list, at_hand);
    offer.take(found == offer.scans_.list.end() ? 0 : static_cast<std::size_t>(found - offer.scans_.list.begin()));
    if (offer.scans_.foreign) recorder.tell(offer.scans_.foreign->message(), offer.scans_.foreign->told());
  }
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
    take(0);
    show();
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
  take(scan);
  show();
}

void StickOffer::take(std::size_t scan) {
  chosen_ = scan;
  StickJob plain;
  plain.scans = files_of(scan);
  job_ = recorder_->kept().take(scans_.list[scan], uploaded_, plain);
  record();
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

Status StickOffer::set(std::string_view key, std::string_view value) {
  StickJob changed = job_;
  if (key == "proposal") {
    PLUMBLINE_TRY(set_proposal(changed, value));
  } else {
    PLUMBLINE_TRY(change_job(changed, key, value, recorder_->kept().plain(), *settings_));
  }
  if (changed == job_) return {};
  if (clear_stale_supports(changed, job_, *settings_)) recorder_->supports_cleared();
  const StickJob before = std::exchange(job_, std::move(changed));
  // Their figures hold for one size, layer height and choice of supports.
  const bool same = before.units == job_.units && before.as == job_.as && before.scale == job_.scale &&
                    before.fit == job_.fit && before.size == job_.size && before.keep_clean == job_.keep_clean &&
                    before.supports == job_.supports && before.layer_height == job_.layer_height &&
                    before.profile == job_.profile && (before.rotate_z_deg == job_.rotate_z_deg || !job_.fit);
  if (!same) forget_proposals();
  recorder_->kept().keep(job_);
  record();
  return {};
}

/// Turns a job as one of the proposals is turned.
Status StickOffer::set_proposal(StickJob& job, std::string_view value) const {
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
  job.rotate_x_deg = degrees[0];
  job.rotate_y_deg = degrees[1];
  job.orient = false;
  return {};
}

void StickOffer::record() const {
  recorder_->offered(job_, job_.profile.empty() ? settings_->machine.profile : job_.profile,
                     has_job_file() ? std::nullopt : std::optional(chosen_));
}

}  // namespace plumbline::firmware
