#include "firmware/daemon/stick/scan_slicing.hpp"

#include <sys/wait.h>

#include <algorithm>

#include "firmware/daemon/stick/scan_feed.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

/// How long the firmware waits for the child before it looks at the buttons again.
constexpr auto kChildLook = 10ms;

/// A child whose progress does not rise is killed after this many times the patience with a silent one: some steps can't say how far
/// they are.
constexpr int kPatiences = 10;

/// "reading it failed (signal 11)"
FixedText<60> numbered(const char* before, long number, const char* after) {
  FixedText<60> text;
  text.add("%s%ld%s", before, number, after);
  return text;
}

/// The error of a child that crashed or hung.
tl::unexpected<Error> broke(const ScanRequest& request, const FixedText<60>& how) {
  const char* const name = request.name.c_str();
  if (request.archive.ask != ArchiveRequest::Ask::kNothing) {
    return telling(
        Told(PrinterCode::kReadingBroke),
        fail(ErrorCode::kMalformed, "%s: %s.\tExport it again, and report this file to plumbline's maintainers", name,
             how.c_str()));
  }
  if (!request.is_job_file)
    return telling(Told(PrinterCode::kReadingBroke),
                   fail(ErrorCode::kMalformed, "%s: %s.\t%s", name, how.c_str(), kExportAgain));
  return fail(ErrorCode::kBadSetting, "%s: %s.\tWrite it anew, or remove it", name, how.c_str());
}

}  // namespace

Expected<CheckedAnswer> ScanSlicing::run(const StickMount& mount, std::span<StickFile> scan,
                                         const ScanRequest& request) {
  const auto answer = work(mount, scan, request);
  PLUMBLINE_TRY(answer);
  auto checked = check_answer(*answer, request, arena_);
  if (!checked) return tl::unexpected<Error>(child_said(*answer, checked.error(), mount, request));
  return checked;
}

Expected<Proposals> ScanSlicing::propose(const StickMount& mount, std::span<StickFile> scan,
                                         const ScanRequest& request) {
  const auto answer = work(mount, scan, request);
  PLUMBLINE_TRY(answer);
  auto checked = check_proposals(*answer);
  if (!checked) return tl::unexpected<Error>(child_said(*answer, checked.error(), mount, request));
  return checked;
}

Expected<StickJob> ScanSlicing::read_job(const StickMount& mount, StickFile& file) {
  ScanRequest request;
  request.is_job_file = true;
  request.name.add("%.*s", static_cast<int>(file.name().size()), file.name().data());
  request.add_file(file.name(), file.size());
  const auto answer = work(mount, std::span(&file, 1), request);
  PLUMBLINE_TRY(answer);
  auto job = check_job_answer(*answer);
  if (!job) return tl::unexpected<Error>(child_said(*answer, job.error(), mount, request));
  return job;
}

Expected<JobStore::Received> ScanSlicing::copy(const StickMount& mount, StickFile& archive, JobStore& store) {
  const auto advance = [&](double fraction) -> Status {
    PLUMBLINE_TRY(look_at_buttons());
    observer_.slicing(Stage::kRead, fraction);
    return mount.check();
  };
  auto received = store.receive(archive, advance);
  if (!received && received.error().code() == ErrorCode::kCannotRead) {
    return tl::unexpected<Error>(pulled_or_bad(mount, received.error()));
  }
  return received;
}

Expected<SlicedArchive> ScanSlicing::check(int file, const ScanRequest& request) {
  PLUMBLINE_TRY(child_.start(request, file));
  const auto answer = follow(nullptr, nullptr, request);
  PLUMBLINE_TRY(answer);
  auto checked = check_archive_answer(*answer, request, arena_);
  if (checked || answer->kind == ScanAnswer::kRefused) return checked;
  return tl::unexpected<Error>(checked.error().with_prefix(request.name.view()));
}

/// Runs a child on files until it ends, or until something ends it.
Expected<ScanAnswer> ScanSlicing::work(const StickMount& mount, std::span<StickFile> files,
                                       const ScanRequest& request) {
  ScanFeed feed(files);
  const auto descriptors = feed.open();
  PLUMBLINE_TRY(descriptors);
  PLUMBLINE_TRY(child_.start(request, *descriptors));
  feed.opened();
  return follow(&mount, &feed, request);
}

/// Waits until the child has ended.
/// @param mount, feed  null: its file is not on the stick
Expected<ScanAnswer> ScanSlicing::follow(const StickMount* mount, ScanFeed* feed, const ScanRequest& request) {
  beats_ = 0;
  reached_ = 0;
  beaten_at_ = risen_at_ = HostClock::now();
  bool fed = false;
  for (;;) {
    const auto ended = child_.wait(fed ? 0ms : kChildLook);
    PLUMBLINE_TRY(ended);
    if (*ended) {
      if (WIFSIGNALED(**ended)) return broke(request, numbered("reading it failed (signal ", WTERMSIG(**ended), ")"));
      if (**ended != 0) return broke(request, numbered("reading it failed (status ", WEXITSTATUS(**ended), ")"));
      return child_.answer();
    }
    const auto moved = feed != nullptr ? feed->pump() : Expected<bool>(false);
    fed = moved && *moved;
    const Status status = moved ? watch(mount, request, fed) : Status(tl::unexpected<Error>(moved.error()));
    if (status) continue;
    PLUMBLINE_TRY(kill_and_wait());
    return tl::unexpected<Error>(status.error());
  }
}

/// The error for a child's answer that was refused.
Error ScanSlicing::child_said(const ScanAnswer& answer, const Error& error, const StickMount& mount,
                              const ScanRequest& request) {
  if (error.code() == ErrorCode::kCannotRead) return pulled_or_bad(mount, error);
  // The child names its file in errors of its own.
  return answer.kind == ScanAnswer::kRefused ? error : error.with_prefix(request.name.view());
}

/// What may end the slicing before the child does.
Status ScanSlicing::watch(const StickMount* mount, const ScanRequest& request, bool fed) {
  PLUMBLINE_TRY(look_at_buttons());
  const ChildProgress& progress = child_.progress();
  const std::uint32_t stage = std::min<std::uint32_t>(progress.stage, kStageCount - 1);
  const std::uint32_t permille = std::min<std::uint32_t>(progress.permille, 1000);
  observer_.slicing(static_cast<Stage>(stage), permille / 1000.0);
  if (mount != nullptr && static_cast<Stage>(stage) == Stage::kRead) PLUMBLINE_TRY(mount->check());
  const auto now = HostClock::now();
  if (const std::uint32_t beats = progress.beats; fed || beats != beats_) {
    beats_ = beats;
    beaten_at_ = now;
  }
  // A runaway child may keep beating, but its progress can't rise forever.
  if (const std::uint32_t reached = 1001 * stage + permille; fed || reached > reached_) {
    reached_ = std::max(reached_, reached);
    risen_at_ = now;
  }
  if (now - beaten_at_ < patience_ && now - risen_at_ < kPatiences * patience_) return {};
  const auto waited = std::chrono::ceil<std::chrono::seconds>(now - risen_at_).count();
  return broke(request, numbered("reading it made no progress for ", static_cast<long>(waited), " s"));
}

Status ScanSlicing::look(const StickMount& mount) {
  PLUMBLINE_TRY(look_at_buttons());
  return mount.check();
}

Status ScanSlicing::look_at_buttons() {
  bool cancelled = false;
  for (;;) {
    const auto event = machine_.events.next_event(machine_.clock.now());
    PLUMBLINE_TRY(event);
    if (!*event) break;
    if ((*event)->kind == EventKind::kCancelPressed) cancelled = true;
    if ((*event)->kind == EventKind::kShutdownRequested) shutdown_ = true;
  }
  if (cancelled || shutdown_) return fail(ErrorCode::kCancelled, "stopped while the scan was sliced");
  return {};
}

/// The child may be waiting for a stick that does not answer: then this takes until the kernel gives up, or the system asks to end.
Expected<int> ScanSlicing::kill_and_wait() {
  for (;;) {
    child_.kill(shutdown_ || interrupted() ? 5s : SlicingChild::kEndPatience);
    const auto ended = child_.wait(kChildLook);
    PLUMBLINE_TRY(ended);
    if (*ended) return **ended;
    // What is pressed now changes nothing, but the request to shut down must not be lost.
    static_cast<void>(look_at_buttons());
  }
}

/// Reads of a pulled stick fail shortly before its device disappears. Waiting longer only delays the report of a bad sector.
Error ScanSlicing::pulled_or_bad(const StickMount& mount, const Error& error) {
  for (const auto until = HostClock::now() + 1s; HostClock::now() < until;) {
    if (const auto there = mount.check(); !there) return there.error();
    static_cast<void>(machine_.clock.sleep_until(machine_.clock.now() + 10ms));
  }
  return error;
}

}  // namespace plumbline::firmware
