#pragma once
/// The stick in a board's USB port.

#include <optional>
#include <string>
#include <vector>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"
#include "hal/linux/stick/stick_volume.hpp"
#include "hal/linux/stick/usb_sticks.hpp"

namespace plumbline {

/// Where sticks are looked for and mounted: as the board file has it.
struct StickSettings {
  std::string port;         ///< "1-1.2": only what is plugged in there; empty: any port
  std::string mount_point;  ///< "/run/plumbline/stick"
};

class LinuxStickPort final : public StickPort, public EventSource, private UsbSticks::Listener {
 public:
  static constexpr nanoseconds kLook = std::chrono::milliseconds(100);  ///< for the kernel's block device
  static constexpr nanoseconds kLongest = std::chrono::seconds(10);     ///< then a stick without one counts as come

  LinuxStickPort(StickSettings settings, EventQueue& events, Interlock& interlock);

  /// Starts to listen. A stick that is there is waited for, kLongest at most, and is no event.
  /// @retval those of UsbSticks::open()
  [[nodiscard]] Status open();

  int descriptor() const override { return sticks_ ? sticks_->descriptor() : -1; }
  std::optional<std::chrono::nanoseconds> due() const override { return look_at_; }
  void drain(std::chrono::nanoseconds now) override;

 private:
  bool do_present() const override { return present_; }
  Expected<StickIdentity> do_identity() const override;
  Status do_mount(std::span<char> path) override;
  void do_unmount() override;
  Expected<std::size_t> do_read(int file, std::span<std::byte> buffer) override;
  Status do_check_mounted() const override;

  void arrived(const std::string& place) override;
  void departed(const std::string& place) override;
  std::string folder() const { return "/sys/bus/usb/devices/" + place_; }
  /// Its device is in sysfs still: the kernel knows of a pull before libusb tells.
  bool there() const;

  StickSettings settings_;
  EventQueue& events_;
  std::optional<UsbSticks> sticks_;
  std::string place_;                // of the stick, come or coming; empty: none
  std::vector<std::string> others_;  // plugged in while that one was there, in order
  bool present_ = false;             // it has come: its event was told
  std::optional<nanoseconds> look_at_;
  nanoseconds give_up_{};
  std::uint64_t arrivals_ = 0;
  std::uint64_t mounted_arrival_ = 0;
  std::optional<StickVolume> volume_;
};

}  // namespace plumbline
