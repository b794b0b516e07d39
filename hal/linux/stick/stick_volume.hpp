#pragma once
/// From a USB device to a file system that is mounted: what the kernel's sysfs and mount(2) do for a stick.

#include <optional>
#include <string>
#include <vector>

#include "hal/stick_port.hpp"

namespace plumbline {

/// A USB device by its place: bus, then ports from the root on, as sysfs names it: "1-1.4".
std::string usb_place(unsigned bus, const std::uint8_t* ports, int count);

/// Identity from the device's folder in sysfs: what the kernel read when it came.
/// @param device  "/sys/bus/usb/devices/1-1.4"
StickIdentity read_identity(const std::string& device);

/// Device nodes that may hold the stick's file system, the likeliest first: partitions by number, then the whole medium. Empty
/// while the kernel has not found it or not yet looked for its partitions, and for a card reader without a card.
/// @param device  as above
/// @param udev    where udevd writes down what it has been told of; where it is missing nobody waits for that
std::vector<std::string> block_devices(const std::string& device, const std::string& udev = "/run/udev/data");

/// A file system, mounted read-only, nosuid, nodev, noexec. Unmounts when it ends. Move-only.
class StickVolume {
 public:
  /// Mounts the first of `nodes` that is vfat or exfat.
  /// @param folder  the mount point: made where it is missing, and what is mounted there is unmounted
  /// @retval ErrorCode::kMountFailed  none can be mounted: what the kernel said
  [[nodiscard]] static Expected<StickVolume> mount(const std::vector<std::string>& nodes, const std::string& folder);
  StickVolume(StickVolume&& other) noexcept;
  StickVolume& operator=(StickVolume&&) = delete;
  StickVolume(const StickVolume&) = delete;
  StickVolume& operator=(const StickVolume&) = delete;
  ~StickVolume();

  const std::string& folder() const { return folder_; }

 private:
  explicit StickVolume(std::string folder) : folder_(std::move(folder)) {}
  std::string folder_;
};

/// Unmounts whatever is mounted there, even if a pulled stick's files are still open.
void unmount_all(const std::string& folder);

}  // namespace plumbline
