#include "firmware/daemon/service/service_manager.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::firmware {
namespace {

std::optional<std::int64_t> number(std::string_view text) {
  const auto value = to_number<std::int64_t>(text);
  return value > 0 ? value : std::nullopt;
}

/// An environment variable: a whole number above 0, or not set.
Expected<std::optional<std::int64_t>> number_of_environment(const char* name) {
  const char* const text = std::getenv(name);
  if (text == nullptr) return std::nullopt;
  const auto value = number(text);
  if (!value) {
    return fail(ErrorCode::kBadSetting, "%s: found '%s', allowed is a whole number above 0: let systemd set it", name,
                text);
  }
  return value;
}

}  // namespace

Expected<ServiceManager> ServiceManager::of_environment() {
  const char* const address = std::getenv("NOTIFY_SOCKET");
  if (address == nullptr) return ServiceManager();
  const auto watchdog = number_of_environment("WATCHDOG_USEC");
  PLUMBLINE_TRY(watchdog);
  const auto watched = number_of_environment("WATCHDOG_PID");
  PLUMBLINE_TRY(watched);
  const bool watches = *watchdog && (!*watched || **watched == ::getpid());
  return at(address, std::chrono::microseconds(watches ? **watchdog : 0));
}

Expected<ServiceManager> ServiceManager::at(std::string_view address, std::chrono::microseconds watchdog) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  const bool abstract = address.starts_with('@');
  if ((!abstract && !address.starts_with('/')) || address.size() < 2 || address.size() >= sizeof to.sun_path) {
    return fail(ErrorCode::kBadSetting,
                "NOTIFY_SOCKET: found '%.*s', allowed is a path, or @ and a name: let systemd set it",
                static_cast<int>(address.size()), address.data());
  }
  std::copy(address.begin(), address.end(), to.sun_path);
  if (abstract) to.sun_path[0] = '\0';
  // A path is terminated by 0, an abstract name by its length.
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size() + (abstract ? 0 : 1));

  ServiceManager manager;
  manager.socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  // A manager that does not read delays the daemon by 1 s at most.
  timeval bound{};
  bound.tv_sec = 1;
  if (manager.socket_ < 0 || ::setsockopt(manager.socket_, SOL_SOCKET, SO_SNDTIMEO, &bound, sizeof bound) != 0 ||
      ::connect(manager.socket_, reinterpret_cast<const sockaddr*>(&to), length) != 0) {
    return fail(ErrorCode::kCannotOpen, "NOTIFY_SOCKET %.*s: %s: is systemd there?", static_cast<int>(address.size()),
                address.data(), std::strerror(errno));
  }
  manager.watchdog_ = watchdog;
  return manager;
}

ServiceManager::ServiceManager(ServiceManager&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      watchdog_(std::exchange(other.watchdog_, {})),
      alive_at_(other.alive_at_),
      status_(other.status_) {}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

bool ServiceManager::send(std::string_view message, Urgency urgency) {
  if (socket_ < 0) return true;
  const int flags = MSG_NOSIGNAL | (urgency == Urgency::kMayBeLost ? MSG_DONTWAIT : 0);
  for (;;) {
    if (::send(socket_, message.data(), message.size(), flags) >= 0) return true;
    if (errno != EINTR) return false;
  }
}

Status ServiceManager::ready() {
  if (send("READY=1", Urgency::kMustArrive)) return {};
  return fail(ErrorCode::kCannotWrite, "systemd can't be told that the daemon is ready: %s", std::strerror(errno));
}

void ServiceManager::status(const PrintableText& text) {
  // Cut between two characters: systemd drops a status that is not UTF-8.
  constexpr std::size_t kLongest = 240;
  FixedText<256> message;
  message.add("STATUS=%s", PrintableText(text.view(), kLongest).c_str());
  if (message.view() == status_.view()) return;
  if (send(message.view(), Urgency::kMayBeLost)) status_ = message;
}

void ServiceManager::alive() {
  if (!watches()) return;
  const auto now = HostClock::now();
  if (alive_at_ && now - *alive_at_ < std::chrono::nanoseconds(watchdog_) / 2) return;
  // If it is lost, the next call tries again.
  if (send("WATCHDOG=1", Urgency::kMayBeLost)) alive_at_ = now;
}

void ServiceManager::stopping() { static_cast<void>(send("STOPPING=1", Urgency::kMustArrive)); }

}  // namespace plumbline::firmware
