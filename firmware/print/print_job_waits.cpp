#include "firmware/print/print_job.hpp"

namespace plumbline {

/// What means nothing in this state is not even a reason to stop waiting.
Waiting PrintJob::leave_for(PrintEvent event, bool& heard) {
  heard = heard || next(state_, event) != state_;
  return heard ? Waiting::kReturn : Waiting::kContinue;
}

Waiting PrintJob::hear(const Event& event) {
  switch (event.kind) {
    case EventKind::kStartPressed: resume_ = true; return Waiting::kContinue;
    case EventKind::kPausePressed: pause_ = true; return Waiting::kContinue;  // after the layer: half of one would show
    case EventKind::kCancelPressed: return leave_for(PrintEvent::kCancelAsked, cancel_);
    case EventKind::kCoverOpened: cover_closed_ = false; return leave_for(PrintEvent::kCoverOpened, cover_opened_);
    case EventKind::kCoverClosed: cover_closed_ = true; return Waiting::kContinue;
    case EventKind::kShutdownRequested: return leave_for(PrintEvent::kShutdown, shutdown_);
    case EventKind::kStickArrived:
    case EventKind::kStickDeparted:
    case EventKind::kExposureEnded:
    case EventKind::kMotionEnded: return Waiting::kContinue;
  }
  return Waiting::kContinue;
}

/// Turns what was heard into a change of state, the most urgent first. @returns true: the state has changed
bool PrintJob::heed() {
  const PrintState before = state_;
  if (shutdown_) {
    shutdown_ = false;
    apply(PrintEvent::kShutdown);
  } else if (cancel_) {
    cancel_ = false;
    apply(PrintEvent::kCancelAsked);
  } else if (cover_opened_) {
    cover_opened_ = false;
    apply(PrintEvent::kCoverOpened);
  } else if (pause_) {
    pause_ = false;
    apply(PrintEvent::kPauseAsked);
  }
  return state_ != before;
}

/// Lets time pass. @returns false: something came up
Expected<bool> PrintJob::pass(nanoseconds time) {
  const TimePoint until = machine_.clock.now() + time;
  while (!asked_to_stop() && machine_.clock.now() < until) {
    const auto event = machine_.events.next_event(until);
    if (!event) return tl::unexpected<Error>(event.error());
    if (*event) static_cast<void>(hear(**event));
  }
  return !asked_to_stop();
}

Expected<bool> PrintJob::finish(Motion motion) {
  const auto over = await(motion, machine_.events, machine_.clock, [this](const Event& event) { return hear(event); });
  if (!over) return tl::unexpected<Error>(over.error());
  if (!*over) PLUMBLINE_TRY(motion.stop());
  const auto report = motion.finish();
  PLUMBLINE_TRY(report);
  report_.steps_lost = report->steps_lost != Distance() ? report->steps_lost : report_.steps_lost;
  return report->arrived && !asked_to_stop();
}

/// @returns false: something came up, and the stage stands on its way
Expected<bool> PrintJob::move(const StageMove& to) {
  const auto at = machine_.stage.position();
  PLUMBLINE_TRY(at);
  // The stage rounds to its microsteps: where it would not move there is nothing to ask for.
  constexpr Distance kNoMove = Distance::nanometres(100);
  if (*at - to.target < kNoMove && to.target - *at < kNoMove) return !asked_to_stop();
  auto motion = machine_.stage.begin_move(to.target, to.speed);
  PLUMBLINE_TRY(motion);
  return finish(std::move(*motion));
}

void PrintJob::tell() {
  PrintStatus status;
  status.state = state_;
  status.layer = entry_.next_layer;
  status.layers = plan_.layers;
  status.height = height_of(plan_, entry_.next_layer < plan_.layers ? entry_.next_layer : plan_.layers - 1);
  status.now = machine_.clock.now();
  status.elapsed = before_ + (machine_.clock.now() - began_);
  status.remaining = remaining_time(plan_, entry_.next_layer);
  status.slack = slack_;
  status.resin_ml = used_ml();
  if (!observer_.update(status)) cancel_ = true;
}

}  // namespace plumbline
