#include "firmware/page/listening_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace plumbline::firmware::inline page {
namespace {

/// Somebody who floods the port must not fill it between two turns.
constexpr int kBacklog = 128;

Descriptor listen_on(const sockaddr* address, socklen_t size) {
  Descriptor socket(::socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.is_open()) return socket;
  const int on = 1, off = 0;
  static_cast<void>(::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on));
  if (address->sa_family == AF_INET6) {
    static_cast<void>(::setsockopt(socket.get(), IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off));
  }
  if (::bind(socket.get(), address, size) == 0 && ::listen(socket.get(), kBacklog) == 0) return socket;
  const int reason = errno;
  { Descriptor closed(std::move(socket)); }
  errno = reason;
  return {};
}

}  // namespace

Expected<Descriptor> listen_at(const std::string& address, std::uint16_t port) {
  sockaddr_in four{};
  four.sin_family = AF_INET;
  four.sin_port = htons(port);
  sockaddr_in6 six{};
  six.sin6_family = AF_INET6;
  six.sin6_port = htons(port);
  const bool is_four = ::inet_pton(AF_INET, address.c_str(), &four.sin_addr) == 1;
  if (!is_four && !address.empty() && ::inet_pton(AF_INET6, address.c_str(), &six.sin6_addr) != 1) {
    return fail(ErrorCode::kBadSetting, "--listen: '%s' is not an address.\tWrite numbers, such as 127.0.0.1 or ::1",
                address.c_str());
  }
  Descriptor socket;
  if (!is_four) socket = listen_on(reinterpret_cast<const sockaddr*>(&six), sizeof six);
  // A kernel without IPv6 has the old addresses.
  if (is_four || (!socket.is_open() && address.empty() && errno == EAFNOSUPPORT)) {
    socket = listen_on(reinterpret_cast<const sockaddr*>(&four), sizeof four);
  }
  if (socket.is_open()) return socket;
  return fail(ErrorCode::kCannotOpen, "port %u: %s.\tEnd the program that uses it, or set [printer] page_port", port,
              std::strerror(errno));
}

}  // namespace plumbline::firmware::inline page
