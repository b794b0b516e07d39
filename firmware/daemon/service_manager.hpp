#pragma once
/// What the daemon tells the service manager (systemd) that started it: the protocol of sd_notify(3), a datagram a message.

#include <chrono>
#include <string_view>

#include "firmware/io/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// The manager's ear. Takes nothing from the heap once it is made. Move-only.
class ServiceManager {
 public:
  using HostClock = std::chrono::steady_clock;

  /// Nobody: what is said is heard by no one.
  ServiceManager() = default;
  /// As NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID say; nobody where no manager wants to hear from this process.
  /// @retval ErrorCode::kBadSetting  one of them is not as sd_notify(3) and sd_watchdog_enabled(3) have it
  /// @retval ErrorCode::kCannotOpen  there is no socket to be had
  [[nodiscard]] static Expected<ServiceManager> of_environment();
  /// @param address   of its datagram socket: a path, or @ and a name in the abstract name space
  /// @param watchdog  it ends a daemon that it does not hear for that long; 0: it does not watch
  /// @retval as above
  [[nodiscard]] static Expected<ServiceManager> at(std::string_view address, std::chrono::microseconds watchdog);
  ServiceManager(ServiceManager&& other) noexcept;
  ServiceManager& operator=(ServiceManager&&) = delete;
  ~ServiceManager();

  bool watches() const { return watchdog_ > std::chrono::microseconds::zero(); }
  std::chrono::microseconds watchdog() const { return watchdog_; }

  /// The devices are open and the memory is taken: jobs may come.
  /// @retval ErrorCode::kCannotWrite  the manager would wait for it in vain, and then end the daemon
  [[nodiscard]] Status ready();
  /// What the daemon does now, in a line, for `systemctl status`. What has been said is not said again.
  void tell(std::string_view text);
  /// The work goes round. Said where half of watchdog() has passed since it was said.
  void alive();
  /// The end has begun.
  void stopping();

 private:
  enum class Urgency : std::uint8_t { kMustArrive, kMayBeLost };
  bool send(std::string_view message, Urgency urgency);

  int socket_ = -1;  ///< connected; -1: nobody hears
  std::chrono::microseconds watchdog_{};
  HostClock::time_point alive_said_;
  FixedText<256> told_;
};

}  // namespace plumbline
