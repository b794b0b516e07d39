#include "firmware/daemon/surroundings.hpp"

#include "firmware/io/own_address.hpp"

namespace plumbline::firmware {

Surroundings::Surroundings(Machine& machine, const MachineFile& settings, MachineRecord& machine_record,
                           PrinterRecord& record)
    : machine_(machine), settings_(settings), machine_record_(machine_record), record_(record) {
  look();
}

void Surroundings::look() {
  const TimePoint now = machine_.clock.now();
  if (looked_at_ && now < *looked_at_ + kTurn) return;
  looked_at_ = now;
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    const auto site = static_cast<TemperatureSite>(i);
    const auto read = machine_.thermals.temperature(site);
    machine_record_.feels(site, read ? std::optional(*read) : std::nullopt);
  }
  if (settings_.page != PageChoice::kNetwork) return;
  record_.address.clear();
  const HostText host = reachable_host();
  if (!host.view().empty()) record_.address.add("http://%s:%u", host.c_str(), settings_.page_port);
}

}  // namespace plumbline::firmware
