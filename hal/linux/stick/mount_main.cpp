/// The program `plumbline-mount`: mounts sticks for the firmware. Of all processes only this one has CAP_SYS_ADMIN, so it does nothing
/// else. It mounts storage on the USB bus, vfat or exfat, read-only, nosuid, nodev, noexec.
///
///   plumbline-mount SOCKET       listens there, for processes of its own user; mount_protocol.hpp has the messages

#include <linux/mount.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "hal/linux/stick/mount_protocol.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline {
namespace {

/// Whether sysfs has the block device below a USB device: .../usb1/1-1/1-1:1.0/host0/target0:0:0/0:0:0:0/block/sda/sda1.
bool is_on_usb(std::string_view name) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) != 0; };
  if (name.empty() || name.size() >= kDeviceNameBytes || !std::all_of(name.begin(), name.end(), plain)) return false;
  std::array<char, 64> link{};
  std::snprintf(link.data(), link.size(), "/sys/class/block/%.*s", static_cast<int>(name.size()), name.data());
  std::array<char, 4096> target{};
  const ssize_t length = ::readlink(link.data(), target.data(), target.size());
  if (length < 0) return false;
  const std::string_view path(target.data(), static_cast<std::size_t>(length));
  const auto usb = path.find("/usb");
  return usb != std::string_view::npos && usb + 4 < path.size() &&
         std::isdigit(static_cast<unsigned char>(path[usb + 4])) != 0;
}

struct Kind {
  const char* name;
  std::array<std::array<const char*, 2>, 4> options;
};
/// Everybody may read, nobody may write or execute; names are UTF-8. errors=continue: a read-only mount has nothing to lose.
constexpr std::array kKinds = {
    Kind{"vfat", {{{"utf8", "1"}, {"fmask", "0333"}, {"dmask", "0222"}, {"errors", "continue"}}}},
    Kind{"exfat", {{{"iocharset", "utf8"}, {"fmask", "0333"}, {"dmask", "0222"}, {"errors", "continue"}}}}};

// By number: C libraries older than 2.36 lack these functions.
long configure(long context, unsigned command, const char* key, const char* value) {
  return ::syscall(SYS_fsconfig, context, command, key, value, 0);
}

/// @returns a descriptor of the top folder, or -1 with errno set
int mount(const char* device, const Kind& kind) {
  const long context = ::syscall(SYS_fsopen, kind.name, FSOPEN_CLOEXEC);
  if (context < 0) return -1;
  long result = configure(context, FSCONFIG_SET_STRING, "source", device);
  if (result == 0) result = configure(context, FSCONFIG_SET_FLAG, "ro", nullptr);
  for (const auto& [key, value] : kind.options) {
    if (result == 0) result = configure(context, FSCONFIG_SET_STRING, key, value);
  }
  if (result == 0) result = configure(context, FSCONFIG_CMD_CREATE, nullptr, nullptr);
  constexpr unsigned kSafe = MOUNT_ATTR_RDONLY | MOUNT_ATTR_NOSUID | MOUNT_ATTR_NODEV | MOUNT_ATTR_NOEXEC;
  if (result == 0) result = ::syscall(SYS_fsmount, context, FSMOUNT_CLOEXEC, kSafe);
  const int reason = errno;
  ::close(static_cast<int>(context));
  errno = reason;
  return static_cast<int>(result);
}

void serve(int client) {
  std::array<char, kDeviceNameBytes> name{};
  const auto request = receive_message(client, std::as_writable_bytes(std::span(name)));
  if (!request) return;
  request->close_descriptors();
  int folder = -1;
  int reason = EACCES;
  if (is_on_usb({name.data(), request->bytes})) {
    reason = 0;
    std::array<char, 64> device{};
    std::snprintf(device.data(), device.size(), "/dev/%.*s", static_cast<int>(request->bytes), name.data());
    for (const Kind& kind : kKinds) {
      folder = mount(device.data(), kind);
      if (folder >= 0) break;
      // EINVAL means another file system, ENODEV an unknown one. Any other error says more.
      if (reason == 0 || (errno != EINVAL && errno != ENODEV)) reason = errno;
    }
    if (folder >= 0) reason = 0;
  }
  // A client that has gone needs no answer.
  static_cast<void>(send_message(client, std::as_bytes(std::span(&reason, 1)), {&folder, folder >= 0 ? 1U : 0U}));
  if (folder >= 0) ::close(folder);
}

int run(std::string_view path) {
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof at.sun_path) return 2;
  std::copy(path.begin(), path.end(), at.sun_path);
  const int listener = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  ::umask(0177);  // for this user alone
  ::unlink(at.sun_path);
  if (listener < 0 || ::bind(listener, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
      ::listen(listener, 4) != 0) {
    std::fprintf(stderr, "plumbline-mount: %s: %s\n", at.sun_path, std::strerror(errno));
    return 1;
  }
  for (;;) {
    const int client = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0 && (errno == EINTR || errno == ECONNABORTED)) continue;
    if (client < 0) return 1;
    timeval patience{};
    patience.tv_sec = 1;  // a client that says nothing must not block the next
    ::setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    serve(client);
    ::close(client);
  }
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  if (argc == 2) return plumbline::run(argv[1]);
  std::fputs("plumbline-mount: a service of plumblined's: plumbline-mount SOCKET\n", stderr);
  return 2;
}
