#pragma once
/// Watches for USB sticks. Only usb_sticks.cpp includes libusb.

#include <chrono>
#include <memory>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Reports arriving and departing USB mass storage, including what is plugged in at the start.
class UsbSticks {
 public:
  class Listener {
   public:
    virtual ~Listener() = default;
    /// @param place  name of its folder in /sys/bus/usb/devices
    virtual void on_arrived(const std::string& place) = 0;
    virtual void on_departed(const std::string& place) = 0;
  };

  /// @param listener  must outlive it; called for present sticks before this returns
  /// @retval ErrorCode::kCannotOpen  libusb's reason
  [[nodiscard]] static Expected<UsbSticks> open(Listener& listener);
  UsbSticks(UsbSticks&&) noexcept;
  UsbSticks& operator=(UsbSticks&&) = delete;
  UsbSticks(const UsbSticks&) = delete;
  UsbSticks& operator=(const UsbSticks&) = delete;
  ~UsbSticks();

  /// For poll(): readable when drain() has something to do.
  int descriptor() const;
  /// Notifies the listener. Never waits.
  void drain();

 private:
  class Context;
  explicit UsbSticks(std::unique_ptr<Context> context);
  std::unique_ptr<Context> context_;
};

}  // namespace plumbline::inline hal::inline linux_board
