#include "hal/linux/keeper/watchdog.hpp"

#include <fcntl.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace plumbline::inline hal::inline linux_board {
namespace {

constexpr std::string_view kFile = "file:";

}  // namespace

Expected<Watchdog> Watchdog::open(std::string_view device, std::chrono::seconds timeout) {
  const bool played = device.starts_with(kFile);
  const std::string path(played ? device.substr(kFile.size()) : device);
  Watchdog watchdog(::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
  if (watchdog.file_ < 0) {
    return fail(ErrorCode::kCannotOpen, "the watchdog, %s: %s%s", path.c_str(), std::strerror(errno),
                errno == EBUSY ? ": systemd holds it if RuntimeWatchdogSec is set" : "");
  }
  if (played) return watchdog;
  int seconds = static_cast<int>(timeout.count());
  // The driver rounds, and writes what it has set.
  const bool set = ::ioctl(watchdog.file_, WDIOC_SETTIMEOUT, &seconds) == 0 || errno == EOPNOTSUPP || errno == EINVAL;
  const int reason = errno;
  if (!set || ::ioctl(watchdog.file_, WDIOC_GETTIMEOUT, &seconds) != 0) {
    watchdog.disarm();
    return fail(ErrorCode::kCannotOpen, "the watchdog, %s: %s", path.c_str(), std::strerror(set ? errno : reason));
  }
  if (seconds > timeout.count()) {
    watchdog.disarm();
    return fail(ErrorCode::kBadSetting,
                "the watchdog, %s: it can only reset the board after %d s, not after %d s:\twrite "
                "timeout_s = %d in the board file",
                path.c_str(), seconds, static_cast<int>(timeout.count()), seconds);
  }
  return watchdog;
}

Watchdog::Watchdog(Watchdog&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

Watchdog::~Watchdog() {
  if (file_ >= 0) ::close(file_);
}

void Watchdog::feed() noexcept { static_cast<void>(::write(file_, "", 1)); }

void Watchdog::disarm() noexcept {
  static_cast<void>(::write(file_, "V", 1));
  ::close(std::exchange(file_, -1));
}

}  // namespace plumbline::inline hal::inline linux_board
