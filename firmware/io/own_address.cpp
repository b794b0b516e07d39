#include "firmware/io/own_address.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <cstring>

namespace plumbline::firmware {
namespace {

bool is_on_network(unsigned flags) {
  const bool is_up = (flags & IFF_UP) != 0 && (flags & IFF_RUNNING) != 0;
  return is_up && (flags & (IFF_LOOPBACK | IFF_POINTOPOINT)) == 0;
}

bool is_link_local(in_addr address) { return ntohl(address.s_addr) >> 16U == 0xa9fe; }

}  // namespace

HostText reachable_host(const ifaddrs* interfaces, const char* name) {
  HostText text;
  bool any = false;
  for (const ifaddrs* at = interfaces; at != nullptr; at = at->ifa_next) {
    if (!is_on_network(at->ifa_flags)) continue;
    any = true;
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in four{};
    std::memcpy(&four, at->ifa_addr, sizeof four);
    std::array<char, INET_ADDRSTRLEN> numbers{};
    if (is_link_local(four.sin_addr)) continue;
    if (::inet_ntop(AF_INET, &four.sin_addr, numbers.data(), numbers.size()) == nullptr) continue;
    text.add("%s", numbers.data());
    return text;
  }
  const std::size_t length = std::strcspn(name, ".");
  if (any && length > 0) text.add("%.*s.local", static_cast<int>(length), name);
  return text;
}

HostText reachable_host() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) name[0] = '\0';
  ifaddrs* interfaces = nullptr;
  if (::getifaddrs(&interfaces) != 0) return {};
  const HostText host = reachable_host(interfaces, name.data());
  ::freeifaddrs(interfaces);
  return host;
}

}  // namespace plumbline::firmware
