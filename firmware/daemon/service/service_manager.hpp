#pragma once
/// Notifies the service manager (systemd) that started the daemon: sd_notify(3), one datagram a message.

#include <chrono>
#include <optional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {

/// Takes nothing from the heap once it is made. Move-only.
class ServiceManager {
 public:
  using HostClock = std::chrono::steady_clock;

  /// No manager: every message is dropped.
  ServiceManager() = default;
  /// From NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID; no manager if they are not set for this process.
  /// @retval ErrorCode::kBadSetting  one of them breaks sd_notify(3) or sd_watchdog_enabled(3)
  /// @retval ErrorCode::kCannotOpen  the socket can't be opened or connected
  [[nodiscard]] static Expected<ServiceManager> of_environment();
  /// @param address   of the datagram socket: a path, or @ and a name in the abstract namespace
  /// @param watchdog  the manager kills a daemon that is silent for this long; 0: no watchdog
  /// @retval as above
  [[nodiscard]] static Expected<ServiceManager> at(std::string_view address, std::chrono::microseconds watchdog);
  ServiceManager(ServiceManager&& other) noexcept;
  ServiceManager& operator=(ServiceManager&&) = delete;
  ~ServiceManager();

  bool watches() const { return watchdog_ > std::chrono::microseconds::zero(); }
  std::chrono::microseconds watchdog() const { return watchdog_; }

  /// READY=1: the devices are open and the memory is taken.
  /// @retval ErrorCode::kCannotWrite  the manager would wait in vain and then kill the daemon
  [[nodiscard]] Status ready();
  /// STATUS=: what the daemon is doing, one line, for `systemctl status`. Repeats are not sent.
  void status(const PrintableText& text);
  /// WATCHDOG=1: the daemon lives. Sent once half of watchdog() has passed since the last one.
  void alive();
  /// STOPPING=1.
  void stopping();

 private:
  enum class Urgency : std::uint8_t { kMustArrive, kMayBeLost };
  bool send(std::string_view message, Urgency urgency);

  int socket_ = -1;  ///< connected; -1: no manager
  std::chrono::microseconds watchdog_{};
  std::optional<HostClock::time_point> alive_at_;
  FixedText<256> status_;  ///< the last one sent
};

}  // namespace plumbline::firmware
