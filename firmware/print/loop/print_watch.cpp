#include "firmware/print/loop/print_watch.hpp"

namespace plumbline::firmware {

void PrintWatch::request_if_it_matters(PrintEvent event, Request request) {
  if (next(state_, event) != state_) this->request(request);
}

Waiting PrintWatch::on_event(const Event& event) {
  switch (event.kind) {
    case EventKind::kStartPressed:
      if (!waits_for_start(state_)) break;
      if (event.named || event.at >= asked_at_ + kSettle) {
        request(Request::kResume);
      } else {
        static_cast<void>(machine_.panel.beep(std::chrono::milliseconds(100)));
      }
      break;
    case EventKind::kPausePressed:
      // Don't ask next(): a pause requested while homing takes effect at the first layer.
      if (waits_for_start(state_) || pending_ >= Request::kPause) break;
      request(Request::kPause);
      pause_came_();
      break;
    case EventKind::kCancelPressed: request_if_it_matters(PrintEvent::kCancelAsked, Request::kCancel); break;
    case EventKind::kCoverOpened:
      // The final raise stops, too, and goes on when the cover is closed.
      if (is_raise_to_end(state_)) request(Request::kCoverOpened);
      request_if_it_matters(PrintEvent::kCoverOpened, Request::kCoverOpened);
      break;
    case EventKind::kShutdownRequested: request_if_it_matters(PrintEvent::kShutdown, Request::kShutdown); break;
    case EventKind::kCoverClosed:  // the print reads the switch itself
    case EventKind::kStickArrived:
    case EventKind::kStickDeparted:
    case EventKind::kExposureEnded:
    case EventKind::kMotionEnded: break;
  }
  return interrupted() ? Waiting::kReturn : Waiting::kContinue;
}

Expected<bool> PrintWatch::wait(nanoseconds time) {
  const TimePoint until = machine_.clock.now() + time;
  while (!interrupted() && machine_.clock.now() < until) {
    const auto event = machine_.events.next_event(until);
    PLUMBLINE_TRY(event);
    if (*event) static_cast<void>(on_event(**event));
  }
  return !interrupted();
}

}  // namespace plumbline::firmware
