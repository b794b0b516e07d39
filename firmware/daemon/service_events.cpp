#include "firmware/daemon/service_events.hpp"

#include <algorithm>

namespace plumbline {
namespace {

/// Longest single wait, however long the watchdog's time: one second of a simulated machine may take ten of the manager's.
constexpr nanoseconds kLongestWait = std::chrono::seconds(1);

}  // namespace

ServiceEvents::ServiceEvents(Events& events, const Clock& clock, ServiceManager& manager)
    : events_(events),
      clock_(clock),
      manager_(manager),
      longest_wait_(std::min(nanoseconds(manager.watchdog()) / 4, kLongestWait)) {}

Expected<std::optional<Event>> ServiceEvents::do_next_event(TimePoint deadline) {
  for (;;) {
    const TimePoint turn = manager_.watches() ? std::min(deadline, clock_.now() + longest_wait_) : deadline;
    const auto event = events_.next_event(turn);
    manager_.alive();
    if (event && *event && (*event)->kind == EventKind::kShutdownRequested) manager_.stopping();
    if (!event || *event || turn == deadline) return event;
  }
}

}  // namespace plumbline
