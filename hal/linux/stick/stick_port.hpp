#pragma once
/// The stick in a board's USB port.

#include <optional>
#include <string>
#include <vector>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"
#include "hal/linux/stick/stick_volume.hpp"
#include "hal/linux/stick/usb_sticks.hpp"
#include "hal/wiring.hpp"

namespace plumbline::inline hal::inline linux_board {

class LinuxStickPort final : public StickPort, public EventSource, private UsbSticks::Listener {
 public:
  static constexpr nanoseconds kPollInterval =
      std::chrono::milliseconds(100);  ///< of looking for the block device; shorter costs CPU, longer delays an arrival
  static constexpr nanoseconds kMaxWait = std::chrono::seconds(
      10);  ///< after which a stick without a block device counts as arrived, so that mounting it can report the problem

  /// @param mount_socket  where plumbline-mount listens
  LinuxStickPort(StickSettings settings, std::string mount_socket, EventQueue& events, Interlock& interlock);

  /// Starts watching. Waits up to kMaxWait for a stick that is already plugged in, which causes no event.
  /// @retval the errors of UsbSticks::open()
  [[nodiscard]] Status open();

  int descriptor() const override { return sticks_ ? sticks_->descriptor() : -1; }
  std::optional<std::chrono::nanoseconds> due() const override { return poll_at_; }
  void drain(std::chrono::nanoseconds now) override;

 private:
  bool do_has_stick() const override { return present_; }
  Expected<StickIdentity> do_identity() const override;
  Expected<StickParts> do_mount() override;
  Expected<bool> do_store(const StickReport& report) override;
  Expected<std::size_t> do_read(int file, std::span<std::byte> buffer) override;
  Status do_check_mounted() const override;
  bool do_has_real_files() const override { return true; }

  void on_arrived(const std::string& place) override;
  void on_departed(const std::string& place) override;
  std::string folder() const { return "/sys/bus/usb/devices/" + place_; }
  /// Whether its device is still in sysfs: the kernel notices a pull before libusb reports it.
  bool attached() const;

  StickSettings settings_;
  std::string mount_socket_;
  EventQueue& events_;
  std::optional<UsbSticks> sticks_;
  std::string place_;                // of the stick that is here or arriving; empty: none
  std::vector<std::string> others_;  // sticks plugged in after that one, in order
  bool present_ = false;             // it has arrived, and its event was queued
  std::optional<nanoseconds> poll_at_;
  nanoseconds give_up_{};
  std::uint64_t arrivals_ = 0;
  std::uint64_t mounted_arrival_ = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
