#pragma once
/// The machine's events, and those that commands become. Every look for one also serves the state socket and the screen, and
/// sends a sign of life to the service manager. A scan that is being uploaded comes in here, too.

#include <functional>

#include "firmware/daemon/service/service_manager.hpp"
#include "firmware/daemon/upload/uploads.hpp"
#include "firmware/screen/screen_server.hpp"
#include "firmware/state/state_socket.hpp"
#include "hal/events.hpp"

namespace plumbline::firmware {

/// The firmware waits only here, and looks here for buttons while it computes, so each call shows that it is alive. A separate
/// thread would keep reporting life after the work hung.
class ServiceEvents final : public Events {
 public:
  /// @param events, clock  the machine's; both must outlive this, as must the manager
  ServiceEvents(Events& events, const Clock& clock, ServiceManager& manager);

  /// Called at each look for an event, also while the lamp is lit. Must not wait. Empty: nothing is.
  std::function<void()> at_each_look;

  /// From now on serves a socket, and a screen and uploads if there are any. All must outlive this. An upload that has become whole is
  /// EventKind::kStickArrived: there are scans to offer.
  void serve(StateSocket& socket, const PrinterRecord& record, CommandTaker& taker, ScreenServer* screen = nullptr,
             Uploads* uploads = nullptr);

 private:
  Expected<std::optional<Event>> do_next_event(TimePoint deadline) override;

  Events& events_;
  const Clock& clock_;
  ServiceManager& manager_;
  nanoseconds longest_wait_;
  StateSocket* socket_ = nullptr;
  const PrinterRecord* record_ = nullptr;
  CommandTaker* taker_ = nullptr;
  ScreenServer* screen_ = nullptr;
  Uploads* uploads_ = nullptr;
};

}  // namespace plumbline::firmware
