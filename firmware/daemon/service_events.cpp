#include "firmware/daemon/service_events.hpp"

#include <algorithm>

namespace plumbline {
namespace {

/// Longest single wait. No command waits longer, and no watchdog of over a second is kept waiting: one second of a simulated machine may
/// take ten of the manager's.
constexpr nanoseconds kLongestWait = std::chrono::milliseconds(200);

}  // namespace

ServiceEvents::ServiceEvents(Events& events, const Clock& clock, ServiceManager& manager)
    : events_(events),
      clock_(clock),
      manager_(manager),
      longest_wait_(manager.watches() ? std::min(nanoseconds(manager.watchdog()) / 4, kLongestWait) : kLongestWait) {}

void ServiceEvents::serve(StateSocket& socket, const PrinterRecord& record, CommandTaker& taker) {
  socket_ = &socket;
  record_ = &record;
  taker_ = &taker;
}

Expected<std::optional<Event>> ServiceEvents::do_next_event(TimePoint deadline) {
  for (;;) {
    if (socket_ != nullptr) {
      if (const auto command = socket_->serve(*record_, *taker_)) return Event{clock_.now(), *command};
    }
    const TimePoint turn = std::min(deadline, clock_.now() + longest_wait_);
    const auto event = events_.next_event(turn);
    manager_.alive();
    if (event && *event && (*event)->kind == EventKind::kShutdownRequested) manager_.stopping();
    if (!event || *event || turn == deadline) return event;
  }
}

}  // namespace plumbline
