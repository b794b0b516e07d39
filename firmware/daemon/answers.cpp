#include "firmware/daemon/answers.hpp"

#include <algorithm>

namespace plumbline {
namespace {

/// How long the daemon waits for an event before its next turn. Shorter responds faster, longer spares the processor.
constexpr nanoseconds kAnswerLook = std::chrono::milliseconds(200);

/// The same between two steps of what is done meanwhile.
constexpr nanoseconds kStep = std::chrono::milliseconds(5);

/// A press this soon after a question answers the one before it: whoever presses start twice must not print onto a full plate.
constexpr nanoseconds kSettle = std::chrono::seconds(1);

}  // namespace

Expected<std::optional<Event>> Answers::look() {
  by_command_ = false;
  record_.waits = true;
  const TimePoint until = machine_.clock.now() + kAnswerLook;
  Expected<std::optional<Event>> event = std::nullopt;
  do {
    const bool works = background && background();
    event = machine_.events.next_event(works ? std::min(until, machine_.clock.now() + kStep) : until);
  } while (event && !*event && machine_.clock.now() < until);
  record_.waits = false;
  PLUMBLINE_TRY(event);
  observer_.idle();
  if (*event && (*event)->kind == EventKind::kShutdownRequested) shutdown_ = true;
  return event;
}

Expected<EventKind> Answers::ask(const std::function<void()>& on_next) {
  const TimePoint asked = machine_.clock.now();
  for (;;) {
    const auto event = look();
    PLUMBLINE_TRY(event);
    if (!*event) continue;
    const EventKind kind = (*event)->kind;
    switch (kind) {
      case EventKind::kStartPressed:
      case EventKind::kCancelPressed:
        if (!by_command_ && (*event)->at < asked + kSettle) break;
        return kind;
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

}  // namespace plumbline
