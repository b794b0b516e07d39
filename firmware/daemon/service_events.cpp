#include "firmware/daemon/service_events.hpp"

#include <algorithm>

namespace plumbline {
namespace {

/// Longest single wait. A command to press a button waits no longer, and no watchdog of over a second is kept waiting: one second
/// of a simulated machine may take ten of the manager's.
constexpr nanoseconds kLongestWait = std::chrono::milliseconds(200);

}  // namespace

ServiceEvents::ServiceEvents(Events& events, const Clock& clock, ButtonSocket& buttons, ServiceManager& manager)
    : events_(events),
      clock_(clock),
      buttons_(buttons),
      manager_(manager),
      longest_wait_(manager.watches() ? std::min(nanoseconds(manager.watchdog()) / 4, kLongestWait) : kLongestWait) {}

Expected<std::optional<Event>> ServiceEvents::do_next_event(TimePoint deadline) {
  for (;;) {
    if (const auto button = buttons_.next()) return Event{clock_.now(), *button};
    const TimePoint turn = std::min(deadline, clock_.now() + longest_wait_);
    const auto event = events_.next_event(turn);
    manager_.alive();
    if (event && *event && (*event)->kind == EventKind::kShutdownRequested) manager_.stopping();
    if (!event || *event || turn == deadline) return event;
  }
}

}  // namespace plumbline
