#include "firmware/daemon/button_socket.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace plumbline {
namespace {

constexpr const char* kFile = "buttons";
constexpr mode_t kOwnerAndGroup = 0660;

/// Through the folder's descriptor: an address has room for 107 characters, a path may have more.
sockaddr_un address_in(const Descriptor& folder) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::snprintf(address.sun_path, sizeof address.sun_path, "/proc/self/fd/%d/%s", folder.get(), kFile);
  return address;
}

tl::unexpected<Error> cannot_open(const std::string& folder) {
  const int reason = errno;
  return fail(ErrorCode::kCannotOpen, "%s/%s: %s", folder.c_str(), kFile, std::strerror(reason));
}

}  // namespace

std::optional<EventKind> button_of(std::string_view word) {
  if (word == "start") return EventKind::kStartPressed;
  if (word == "pause") return EventKind::kPausePressed;
  if (word == "cancel") return EventKind::kCancelPressed;
  return std::nullopt;
}

Expected<ButtonSocket> ButtonSocket::open(const std::string& folder) {
  const Descriptor place(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!place.is_open()) return cannot_open(folder);
  // One that a killed daemon left.
  static_cast<void>(::unlinkat(place.get(), kFile, 0));
  ButtonSocket buttons;
  buttons.socket_ = Descriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const sockaddr_un address = address_in(place);
  if (!buttons.socket_.is_open() ||
      ::bind(buttons.socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::fchmodat(place.get(), kFile, kOwnerAndGroup, 0) != 0) {
    return cannot_open(folder);
  }
  return buttons;
}

std::optional<EventKind> ButtonSocket::next() {
  std::array<char, 16> word{};
  for (;;) {
    const ssize_t got = ::recv(socket_.get(), word.data(), word.size(), MSG_DONTWAIT | MSG_TRUNC);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    const auto size = static_cast<std::size_t>(got);
    if (size > word.size()) continue;
    if (const auto button = button_of({word.data(), size})) return button;
  }
}

Status press_button(const std::string& folder, std::string_view word) {
  const Descriptor place(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!place.is_open()) return cannot_open(folder);
  const Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.is_open()) return cannot_open(folder);
  const sockaddr_un address = address_in(place);
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno != ENOENT && errno != ECONNREFUSED) return cannot_open(folder);
    return fail(ErrorCode::kCannotOpen, "no plumblined runs with the state folder %s.\tStart it, or name its --state",
                folder.c_str());
  }
  if (::send(socket.get(), word.data(), word.size(), MSG_NOSIGNAL) < 0) {
    return fail(ErrorCode::kCannotWrite, "%s/%s: %s", folder.c_str(), kFile, std::strerror(errno));
  }
  return {};
}

}  // namespace plumbline
