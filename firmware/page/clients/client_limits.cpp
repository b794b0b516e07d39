#include "firmware/page/clients/client_limits.hpp"

#include <algorithm>
#include <tuple>

namespace plumbline::firmware::inline page {

const ClientLimits::Client* ClientLimits::find(const ClientAddress& address) const {
  const auto* const known = std::find_if(clients_.begin(), clients_.end(),
                                         [&](const Client& one) { return one.is_taken && one.address == address; });
  return known != clients_.end() ? known : nullptr;
}

/// Takes the place of the address that has asked nothing for longest, if there is no other; a paired one only if all are.
ClientLimits::Client& ClientLimits::client(const ClientAddress& address, HostClock::time_point now) {
  auto* const known = std::find_if(clients_.begin(), clients_.end(),
                                   [&](const Client& one) { return one.is_taken && one.address == address; });
  if (known != clients_.end()) {
    known->seen = now;
    return *known;
  }
  auto& place = *std::ranges::min_element(clients_, std::less<>(), [now](const Client& one) {
    return std::tuple(one.is_taken, is_paired(one, now), one.seen);
  });
  place = Client();
  place.address = address;
  place.is_taken = true;
  place.seen = now;
  return place;
}

void ClientLimits::showed_token(const ClientAddress& address, std::uint32_t browser, HostClock::time_point now) {
  Client& one = client(address, now);
  one.paired_at = now;
  one.browser = browser;
}

void ClientLimits::forget(std::uint32_t browser) {
  for (Client& one : clients_) {
    if (one.browser == browser) one.paired_at.reset();
  }
}

bool ClientLimits::is_paired(const Client& client, HostClock::time_point now) {
  return client.paired_at && now - *client.paired_at < kPairedTime;
}

bool ClientLimits::is_paired(const ClientAddress& address, HostClock::time_point now) const {
  const Client* const known = find(address);
  return known != nullptr && is_paired(*known, now);
}

bool ClientLimits::takes_request(const ClientAddress& address, HostClock::time_point now) {
  Client& one = client(address, now);
  if (is_paired(one, now)) return one.paired_requests.take(now);
  // Both, so that one address can't spend what all have together.
  return one.requests.take(now) && all_.take(now);
}

bool ClientLimits::takes_code(const ClientAddress& address, HostClock::time_point now) {
  return client(address, now).codes.take(now);
}

bool ClientLimits::is_flooding(const ClientAddress& address, HostClock::time_point now) const {
  const Client* const known = find(address);
  return known != nullptr && !is_paired(*known, now) && known->requests.in_debt(now);
}

}  // namespace plumbline::firmware::inline page
