/// The program `plumbline-mount`: mounts sticks for the firmware. Of all processes only this one has CAP_SYS_ADMIN, so it does nothing
/// else. It mounts storage on the USB bus, vfat or exfat, read-only, nosuid, nodev, noexec; and writable for as long as it copies a report
/// into the stick's own folder for them.
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

namespace plumbline::inline hal::inline linux_board {
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

enum class Access : std::uint8_t { kRead, kWrite };

struct Kind {
  const char* name;
  std::array<std::array<const char*, 2>, 2> options;
};
/// Names are UTF-8. errors=continue: a read-only mount has nothing to lose.
constexpr std::array kKinds = {Kind{"vfat", {{{"utf8", "1"}, {"errors", "continue"}}}},
                               Kind{"exfat", {{{"iocharset", "utf8"}, {"errors", "continue"}}}}};

// By number: C libraries older than 2.36 lack these functions.
long configure(long context, unsigned command, const char* key, const char* value) {
  return ::syscall(SYS_fsconfig, context, command, key, value, 0);
}

/// @returns a descriptor of the top folder, or -1 with errno set
int mount(const char* device, const Kind& kind, Access access) {
  const bool reads = access == Access::kRead;
  const long context = ::syscall(SYS_fsopen, kind.name, FSOPEN_CLOEXEC);
  if (context < 0) return -1;
  long result = configure(context, FSCONFIG_SET_STRING, "source", device);
  if (result == 0) result = configure(context, FSCONFIG_SET_FLAG, reads ? "ro" : "rw", nullptr);
  for (const auto& [key, value] : kind.options) {
    if (result == 0) result = configure(context, FSCONFIG_SET_STRING, key, value);
  }
  // Everybody may read and nobody may write; or this process alone may do both. Nobody may execute.
  std::array<char, 16> user{};
  std::snprintf(user.data(), user.size(), "%u", static_cast<unsigned>(::geteuid()));
  if (result == 0) result = configure(context, FSCONFIG_SET_STRING, "fmask", reads ? "0333" : "0177");
  if (result == 0) result = configure(context, FSCONFIG_SET_STRING, "dmask", reads ? "0222" : "0077");
  if (result == 0 && !reads) result = configure(context, FSCONFIG_SET_STRING, "uid", user.data());
  if (result == 0) result = configure(context, FSCONFIG_CMD_CREATE, nullptr, nullptr);
  constexpr unsigned kSafe = MOUNT_ATTR_NOSUID | MOUNT_ATTR_NODEV | MOUNT_ATTR_NOEXEC;
  if (result == 0) {
    result = ::syscall(SYS_fsmount, context, FSMOUNT_CLOEXEC, reads ? kSafe | MOUNT_ATTR_RDONLY : kSafe);
  }
  const int reason = errno;
  ::close(static_cast<int>(context));
  errno = reason;
  return static_cast<int>(result);
}

/// Mounts storage whose name is that of a block device.
/// @returns a descriptor of the top folder; or -1, and `reason` is errno
int mount_device(std::string_view name, Access access, int& reason) {
  reason = EACCES;
  if (!is_on_usb(name)) return -1;
  reason = 0;
  std::array<char, 64> device{};
  std::snprintf(device.data(), device.size(), "/dev/%.*s", static_cast<int>(name.size()), name.data());
  for (const Kind& kind : kKinds) {
    const int folder = mount(device.data(), kind, access);
    if (folder >= 0) {
      reason = 0;
      return folder;
    }
    // EINVAL means another file system, ENODEV an unknown one. Any other error says more.
    if (reason == 0 || (errno != EINVAL && errno != ENODEV)) reason = errno;
  }
  return -1;
}

/// @returns errno
int store(const ReportRequest& request, std::span<const int> files) {
  if (files.size() != 1 || request.device.back() != '\0' || request.name.back() != '\0') return EACCES;
  int reason = 0;
  const int folder = mount_device(request.device.data(), Access::kWrite, reason);
  if (folder < 0) return reason;
  reason = copy_report(folder, request.name.data(), files[0], request.from, request.bytes);
  ::close(folder);
  return reason;
}

void serve(int client) {
  ReportRequest request;
  const auto bytes = std::as_writable_bytes(std::span(&request, 1));
  const auto got = receive_message(client, bytes);
  if (!got) return;
  int folder = -1;
  int reason = EACCES;
  if (got->bytes == bytes.size()) {
    reason = store(request, got->descriptors());
  } else if (got->bytes < kDeviceNameBytes) {
    folder = mount_device({request.device.data(), got->bytes}, Access::kRead, reason);
  }
  got->close_descriptors();
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
}  // namespace plumbline::inline hal::inline linux_board

int main(int argc, char** argv) {
  if (argc == 2) return plumbline::run(argv[1]);
  std::fputs("plumbline-mount: a service of plumblined's: plumbline-mount SOCKET\n", stderr);
  return 2;
}
