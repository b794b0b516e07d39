#pragma once
/// The machine's events, and those of its ButtonSocket. Every look for one also sends a sign of life to the service manager.

#include "firmware/daemon/button_socket.hpp"
#include "firmware/daemon/service_manager.hpp"
#include "hal/events.hpp"

namespace plumbline {

/// The firmware waits only here, and looks here for buttons while it computes, so each call shows that it is alive. A separate
/// thread would keep reporting life after the work hung.
class ServiceEvents final : public Events {
 public:
  /// @param events, clock  the machine's; both must outlive this, as must the others
  ServiceEvents(Events& events, const Clock& clock, ButtonSocket& buttons, ServiceManager& manager);

 private:
  Expected<std::optional<Event>> do_next_event(TimePoint deadline) override;

  Events& events_;
  const Clock& clock_;
  ButtonSocket& buttons_;
  ServiceManager& manager_;
  nanoseconds longest_wait_;
};

}  // namespace plumbline
