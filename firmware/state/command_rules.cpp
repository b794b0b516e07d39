#include "firmware/state/command_rules.hpp"

#include <utility>

#include "firmware/archive/layer_archive.hpp"

namespace plumbline::firmware::inline state {
namespace {

/// A state at rest must also wait for an answer: else the command would be lost.
bool takes_in(PrintState state, Command command) {
  if (command == Command::kRemove) return at_rest(state);
  // Not while a layer is printed: writing it down could make a mask late.
  if (command == Command::kFilled) return at_rest(state) || waits_for_start(state);
  switch (state) {
    case PrintState::kIdle: return command == Command::kOffer;
    case PrintState::kOffered:
      return command == Command::kStart || command == Command::kCancel || command == Command::kChoose ||
             command == Command::kSet || command == Command::kPropose || command == Command::kOpen ||
             command == Command::kSettings;
    case PrintState::kInterrupted: return command == Command::kResume || command == Command::kCancel;
    case PrintState::kPlateInUse: return command == Command::kPlateEmpty;
    case PrintState::kFault: return command == Command::kSeen;
    case PrintState::kSlicing:
    case PrintState::kPausing:
    case PrintState::kCoverOpen: return command == Command::kCancel;
    // A pause takes effect when the layer at hand is done, or before the first.
    case PrintState::kChecks:
    case PrintState::kHoming:
    case PrintState::kPrinting:
    case PrintState::kCoolingDown: return command == Command::kPause || command == Command::kCancel;
    case PrintState::kPaused:
    case PrintState::kFeedMe: return command == Command::kResume || command == Command::kCancel;
    case PrintState::kCancelling:
    case PrintState::kFinishing:
    case PrintState::kFinished:
    case PrintState::kCancelled:
    case PrintState::kSuspended: return false;
  }
  return false;
}

}  // namespace

std::string_view to_string(Command command) {
  switch (command) {
    case Command::kStart: return "start";
    case Command::kPause: return "pause";
    case Command::kResume: return "resume";
    case Command::kCancel: return "cancel";
    case Command::kPlateEmpty: return "plate-empty";
    case Command::kSeen: return "seen";
    case Command::kOffer: return "offer";
    case Command::kChoose: return "choose";
    case Command::kSet: return "set";
    case Command::kRemove: return "remove";
    case Command::kPropose: return "propose";
    case Command::kOpen: return "open";
    case Command::kSettings: return "settings";
    case Command::kPicture: return "picture";
    case Command::kMask: return "mask";
    case Command::kReport: return "report";
    case Command::kCode: return "code";
    case Command::kUpload: return "upload";
    case Command::kFilled: return "filled";
  }
  return "unknown command";
}

std::optional<Command> command_of(std::string_view word) {
  for (std::size_t i = 0; i < kRequestCount; ++i) {
    if (word == to_string(static_cast<Command>(i))) return static_cast<Command>(i);
  }
  return std::nullopt;
}

bool takes(const PrinterRecord& record, Command command) {
  if (is_question(command) || command == Command::kCode || command == Command::kUpload) return true;
  if (at_rest(record.state) && !record.waits) return false;
  if (command == Command::kOffer && !record.has_stick && !record.stored) return false;
  if (command == Command::kRemove && !record.stored) return false;
  if (command == Command::kFilled && record.machine == nullptr) return false;
  if (command == Command::kChoose && (record.has_job_file || record.scan_count < 2)) return false;
  const bool has_folders = record.folder_count > 0 || !record.folder.view().empty();
  if (command == Command::kOpen && (record.has_job_file || record.sliced || !has_folders)) return false;
  if (command == Command::kPause && record.note == PrintNote::kPauseTaken) return false;
  if (command == Command::kChoose && record.sliced) return false;
  if (command == Command::kSettings && !(record.sliced && scan_is_there(record))) return false;
  // An archive stands as it was sliced.
  if (command == Command::kPropose && (record.sliced || !record.job || is_archive_name(record.job->files[0].view()))) {
    return false;
  }
  return takes_in(record.state, command);
}

bool scan_is_there(const PrinterRecord& record) {
  if (!record.scans_uploaded) return record.has_stick;
  const ScanRecord& scan = record.scans[0];
  return record.stored && record.scan_count == 1 && record.stored->name.view() == scan.name.view() &&
         record.stored->bytes == scan.bytes;
}

bool is_meant(const PrinterRecord& record, Command command, std::uint64_t about) {
  if (about == 0 || about == record.question_id()) return true;
  return about == record.job_id &&
         (command == Command::kPause || command == Command::kCancel || command == Command::kSet ||
          command == Command::kSettings || command == Command::kPropose);
}

bool answers_question(const PrinterRecord& record, Command command) {
  if (record.question_id() == 0) return false;
  if (command == Command::kCancel) return at_rest(record.state);  // a print can be ended at any time
  return command != Command::kPause && button_of(command).has_value();
}

bool takes_upload(const PrinterRecord& record) {
  const bool is_coming = record.upload && record.upload->stage == UploadRecord::Stage::kComing;
  return record.most_upload_bytes > 0 && at_rest(record.state) && !is_coming;
}

FixedText<200> what_it_takes(const PrinterRecord& record) {
  const auto state = to_string(record.state);
  FixedText<200> text;
  text.add("the printer's state is '%.*s'.", static_cast<int>(state.size()), state.data());
  bool any = false;
  for (std::size_t i = 0; i < kCommandCount; ++i) {
    const auto command = static_cast<Command>(i);
    if (!takes(record, command)) continue;
    const auto word = to_string(command);
    text.add("%s%.*s", std::exchange(any, true) ? ", " : " It takes ", static_cast<int>(word.size()), word.data());
  }
  if (!any) text.add(" It takes no command now");
  return text;
}

std::optional<EventKind> button_of(Command command) {
  switch (command) {
    case Command::kStart:
    case Command::kResume:
    case Command::kPlateEmpty:
    case Command::kSeen:
    case Command::kOffer: return EventKind::kStartPressed;
    case Command::kPause: return EventKind::kPausePressed;
    case Command::kCancel: return EventKind::kCancelPressed;
    case Command::kChoose:
    case Command::kSet:
    case Command::kRemove:
    case Command::kPropose:
    case Command::kOpen:
    case Command::kSettings:
    case Command::kPicture:
    case Command::kMask:
    case Command::kReport:
    case Command::kCode:
    case Command::kUpload:
    case Command::kFilled: return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace plumbline::firmware::inline state
