#pragma once
/// The machine's events, with the service manager told meanwhile that the work goes round.

#include "firmware/daemon/service_manager.hpp"
#include "hal/events.hpp"

namespace plumbline {

/// All that the firmware waits for it waits for here, and while it computes it looks here now and then for the buttons: who comes
/// by here is alive. No thread of its own says so, which would go on when the work hangs.
class ServiceEvents final : public Events {
 public:
  /// @param events, clock  the machine's; both outlive this, as does the manager
  ServiceEvents(Events& events, const Clock& clock, ServiceManager& manager);

 private:
  Expected<std::optional<Event>> do_next_event(TimePoint deadline) override;

  Events& events_;
  const Clock& clock_;
  ServiceManager& manager_;
  nanoseconds longest_wait_;
};

}  // namespace plumbline
