#include "firmware/daemon/answers.hpp"

#include <algorithm>

#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

/// How long the daemon waits for an event before its next turn. Shorter responds faster, longer spares the processor.
constexpr nanoseconds kAnswerLook = std::chrono::milliseconds(200);

/// The same between two steps of what is done meanwhile.
constexpr nanoseconds kStep = std::chrono::milliseconds(5);

/// Of the beep that says that a press was not taken.
constexpr nanoseconds kBeep = std::chrono::milliseconds(100);

}  // namespace

Expected<std::optional<Event>> Answers::look() {
  record_.waits = true;
  const TimePoint until = machine_.clock.now() + kAnswerLook;
  Expected<std::optional<Event>> event = std::nullopt;
  do {
    const bool works = background && background();
    event = machine_.events.next_event(works ? std::min(until, machine_.clock.now() + kStep) : until);
  } while (event && !*event && machine_.clock.now() < until);
  record_.waits = false;
  PLUMBLINE_TRY(event);
  recorder_.idle();
  surroundings_.look();
  if (*event && (*event)->kind == EventKind::kShutdownRequested) shutdown_ = true;
  return event;
}

Expected<EventKind> Answers::ask(const std::function<void()>& on_next) {
  for (;;) {
    const auto event = look();
    PLUMBLINE_TRY(event);
    if (!*event) continue;
    const EventKind kind = (*event)->kind;
    switch (kind) {
      case EventKind::kStartPressed:
      case EventKind::kCancelPressed:
        if ((*event)->named || (*event)->at >= record_.asked_at + kSettle) return kind;
        static_cast<void>(machine_.panel.beep(kBeep));
        recorder_.tell("a button was pressed within a second of the question, so nothing was done: press it again",
                       PrinterCode::kPressSoon);
        break;
      case EventKind::kShutdownRequested:
      case EventKind::kStickArrived:
      case EventKind::kStickDeparted: return kind;
      case EventKind::kPausePressed: on_next(); break;
      case EventKind::kCoverOpened:
      case EventKind::kCoverClosed:
      case EventKind::kExposureEnded:
      case EventKind::kMotionEnded: break;
    }
  }
}

}  // namespace plumbline::firmware
