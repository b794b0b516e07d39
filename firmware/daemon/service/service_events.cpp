#include "firmware/daemon/service/service_events.hpp"

#include <algorithm>

namespace plumbline::firmware {
namespace {

/// Longest single wait. No command waits longer, and no watchdog of over a second is kept waiting: one second of a simulated machine may
/// take ten of the manager's.
constexpr nanoseconds kLongestWait = std::chrono::milliseconds(200);
/// While a scan is uploaded: what a socket holds, some 200 kB, comes in some 5 ms on a fast network.
constexpr nanoseconds kUploadWait = std::chrono::milliseconds(5);

}  // namespace

ServiceEvents::ServiceEvents(Events& events, const Clock& clock, ServiceManager& manager)
    : events_(events),
      clock_(clock),
      manager_(manager),
      longest_wait_(manager.watches() ? std::min(nanoseconds(manager.watchdog()) / 4, kLongestWait) : kLongestWait) {}

void ServiceEvents::serve(StateSocket& socket, const PrinterRecord& record, CommandTaker& taker, ScreenServer* screen,
                          Uploads* uploads) {
  socket_ = &socket;
  record_ = &record;
  taker_ = &taker;
  screen_ = screen;
  uploads_ = uploads;
}

Expected<std::optional<Event>> ServiceEvents::do_next_event(TimePoint deadline) {
  for (;;) {
    if (at_each_look) at_each_look();
    if (socket_ != nullptr) {
      if (const auto command = socket_->serve(*record_, *taker_)) return Event{clock_.now(), *command, true};
    }
    if (uploads_ != nullptr && uploads_->receive()) return Event{clock_.now(), EventKind::kStickArrived};
    if (screen_ != nullptr) {
      if (const auto touch = screen_->touched(*record_, *taker_)) return touch;
      screen_->show(*record_, deadline - clock_.now());
    }
    const bool hurries = uploads_ != nullptr && uploads_->is_coming();
    const TimePoint turn = std::min(deadline, clock_.now() + (hurries ? kUploadWait : longest_wait_));
    const auto event = events_.next_event(turn);
    manager_.alive();
    if (event && *event && (*event)->kind == EventKind::kShutdownRequested) manager_.stopping();
    if (event && *event && screen_ != nullptr) {
      const auto passed = screen_->filter(**event, *record_, *taker_);
      if (passed) return passed;
      continue;
    }
    if (!event || *event || turn == deadline) return event;
  }
}

}  // namespace plumbline::firmware
