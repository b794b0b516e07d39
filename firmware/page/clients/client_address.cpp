#include "firmware/page/clients/client_address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

namespace plumbline::firmware::inline page {
namespace {

/// What stands before an IPv4 address.
constexpr std::array<std::uint8_t, 12> kFour = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
/// Bytes of an IPv6 address that name its network.
constexpr std::size_t kNetwork = 8;

bool is_four(const std::array<std::uint8_t, 16>& bytes) {
  return std::equal(kFour.begin(), kFour.end(), bytes.begin());
}

}  // namespace

ClientAddress client_address(const sockaddr* address) {
  ClientAddress client;
  if (address == nullptr) return client;
  if (address->sa_family == AF_INET) {
    sockaddr_in four{};
    std::memcpy(&four, address, sizeof four);
    std::copy(kFour.begin(), kFour.end(), client.bytes.begin());
    std::memcpy(client.bytes.data() + kFour.size(), &four.sin_addr, sizeof four.sin_addr);
  } else if (address->sa_family == AF_INET6) {
    sockaddr_in6 six{};
    std::memcpy(&six, address, sizeof six);
    std::memcpy(client.bytes.data(), &six.sin6_addr, client.bytes.size());
    const bool is_loopback = IN6_IS_ADDR_LOOPBACK(&six.sin6_addr) != 0;
    if (!is_four(client.bytes) && !is_loopback) {
      std::fill(client.bytes.begin() + kNetwork, client.bytes.end(), std::uint8_t{0});
    }
  }
  return client;
}

FixedText<52> text_of(const ClientAddress& address) {
  const bool four = is_four(address.bytes);
  const std::size_t from = four ? kFour.size() : 0;
  char text[INET6_ADDRSTRLEN] = {};
  static_cast<void>(::inet_ntop(four ? AF_INET : AF_INET6, address.bytes.data() + from, text, sizeof text));
  FixedText<52> out;
  const bool is_network = !four && std::all_of(address.bytes.begin() + kNetwork, address.bytes.end(),
                                               [](std::uint8_t byte) { return byte == 0; });
  out.add("%s%s", text, is_network ? "/64" : "");
  return out;
}

}  // namespace plumbline::firmware::inline page
