#pragma once
/// Which sticks are plugged in. usb_sticks.cpp is the one file that knows libusb.

#include <chrono>
#include <memory>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Hears of USB mass storage that arrives and departs, also of what is there from the start.
class UsbSticks {
 public:
  class Listener {
   public:
    virtual ~Listener() = default;
    /// @param place  its folder's name in /sys/bus/usb/devices
    virtual void arrived(const std::string& place) = 0;
    virtual void departed(const std::string& place) = 0;
  };

  /// @param listener  hears of what is there already before this returns; must outlive it
  /// @retval ErrorCode::kCannotOpen  libusb's reason
  [[nodiscard]] static Expected<UsbSticks> open(Listener& listener);
  UsbSticks(UsbSticks&&) noexcept;
  UsbSticks& operator=(UsbSticks&&) = delete;
  UsbSticks(const UsbSticks&) = delete;
  UsbSticks& operator=(const UsbSticks&) = delete;
  ~UsbSticks();

  /// Readable when there is news.
  int descriptor() const;
  /// Tells the listener. Never waits.
  void drain();

 private:
  class Context;
  explicit UsbSticks(std::unique_ptr<Context> context);
  std::unique_ptr<Context> context_;
};

}  // namespace plumbline
