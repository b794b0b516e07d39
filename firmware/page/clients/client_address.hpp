#pragma once
/// Who asks, as limits count it: an address.

#include <array>
#include <cstdint>

#include "firmware/io/text/fixed_text.hpp"

struct sockaddr;

namespace plumbline::firmware::inline page {

/// An IPv4 address as ::ffff:a.b.c.d. Of an IPv6 address the first 64 bits: whoever has one of a network's has as many as they like.
struct ClientAddress {
  std::array<std::uint8_t, 16> bytes{};
  bool operator==(const ClientAddress&) const = default;
};

/// @param address  of a TCP connection; of another family, or null: all bytes are 0
ClientAddress client_address(const sockaddr* address);

/// "192.168.1.7", "2001:db8:1:2::/64"
FixedText<52> text_of(const ClientAddress& address);

}  // namespace plumbline::firmware::inline page
