#include "firmware/daemon/daemon_commands.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/io/descriptor.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {

Expected<std::optional<EventKind>> DaemonCommands::take(const ClientRequest& request) {
  if (request.about == 0 && answers_question(record_, request.command) && answers_.is_new()) {
    return telling(
        Told(PrinterCode::kAnswerSoon),
        fail(ErrorCode::kBadSetting,
             "the printer has asked that for less than a second, so nothing was done.\tLook at what it asks, "
             "then send it again, or name the question with \"for\""));
  }
  if (const auto button = button_of(request.command)) return button;
  if (request.command == Command::kCode) {
    observer_.show_code(request.code.view());
    return std::nullopt;
  }
  if (request.command == Command::kFilled) return fill_tank(request.ml);
  if (request.command == Command::kRemove) return remove_upload(request.name.view());
  if (contract != nullptr && (request.command == Command::kSet || request.command == Command::kSettings)) {
    const auto over = change_sliced(request);
    PLUMBLINE_TRY(over);
    return *over ? std::optional(EventKind::kCancelPressed) : std::nullopt;  // of this print
  }
  if (offer == nullptr)
    return telling(Told(PrinterCode::kCommandNotNow), fail(ErrorCode::kBadSetting, "nothing is offered"));
  PLUMBLINE_TRY(offer->change(request));
  if (request.command != Command::kPropose && request.command != Command::kOpen) return std::nullopt;
  // The offer remembers that this start is none.
  return EventKind::kStartPressed;
}

/// @returns whether the question is over
Expected<bool> DaemonCommands::change_sliced(const ClientRequest& request) {
  if (request.command == Command::kSet && contract->takes(request.key.view())) {
    const auto shapes_layers = contract->set(request.key.view(), request.value.view());
    PLUMBLINE_TRY(shapes_layers);
    // Without its scan, the print keeps the layers that it has.
    if (!*shapes_layers || !scan_is_there(record_)) return false;
  }
  return again(request);
}

/// @returns start, if a print has asked for resin: that answers it
Expected<std::optional<EventKind>> DaemonCommands::fill_tank(std::optional<double> ml) {
  const double tank_ml = machine_.tank_ml();
  if (ml && !(*ml <= tank_ml)) {
    return telling(Told(PrinterCode::kTankSmaller, {{PrinterFact::kTankMl, tank_ml}}),
                   fail(ErrorCode::kBadSetting, "a full tank holds %.0f ml", tank_ml));
  }
  PLUMBLINE_TRY(machine_.fill(ml.value_or(tank_ml)));
  FixedText<80> text;
  text.add("the tank was filled: it holds %.1f ml", machine_.filled_ml());
  observer_.tell(text.view(), {PrinterCode::kTankFilled, {{PrinterFact::kLeftMl, machine_.filled_ml()}}});
  if (record_.state != PrintState::kFeedMe) return std::nullopt;
  return EventKind::kStartPressed;
}

/// @returns cancel, if the scan is offered: that takes the offer back
Expected<std::optional<EventKind>> DaemonCommands::remove_upload(std::string_view name) {
  const auto removed = uploads_.remove(name);
  if (record_.stored) return tl::unexpected<Error>(removed.error());
  observer_.forget_upload();
  if (!removed) observer_.tell(removed.error().message(), removed.error().told());
  if (record_.state != PrintState::kOffered || !of_upload) return std::nullopt;
  return EventKind::kCancelPressed;
}

Expected<std::uint32_t> DaemonCommands::take_upload(const ClientRequest& upload, Descriptor from) {
  return uploads_.begin(upload, std::move(from));
}

Expected<bool> DaemonCommands::draw_mask(std::uint32_t layer, const MaskWindow& window, MaskPicture& picture) {
  if (masks == nullptr) {
    return fail(ErrorCode::kBadSetting, "there are no masks now.\tAsk again while what has been sliced is offered");
  }
  return masks->draw(layer, window, picture);
}

Expected<CommandTaker::ReportPart> DaemonCommands::read_report(std::uint64_t from, std::span<std::byte> out) {
  const Descriptor file(::open(report_path_.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts {};
  if (!file.is_open() || ::fstat(file.get(), &facts) != 0) {
    return fail(ErrorCode::kBadSetting, "there is no report of a print");
  }
  const ssize_t got = ::pread(file.get(), out.data(), out.size(), static_cast<off_t>(from));
  if (got < 0) return fail(ErrorCode::kCannotRead, "the report can't be read: %s", std::strerror(errno));
  return ReportPart{static_cast<std::size_t>(got), static_cast<std::uint64_t>(facts.st_size)};
}

}  // namespace plumbline::firmware
