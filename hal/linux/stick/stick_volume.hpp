#pragma once
/// From a USB device to a mounted file system, with sysfs and mount(2).

#include <optional>
#include <string>
#include <vector>

#include "hal/stick_port.hpp"

namespace plumbline {

/// Name of a USB device in sysfs, such as "1-1.4": the bus, then the ports from the root on.
std::string usb_place(unsigned bus, const std::uint8_t* ports, int count);

/// Reads a stick's identity from its folder in sysfs.
/// @param device  "/sys/bus/usb/devices/1-1.4"
StickIdentity read_identity(const std::string& device);

/// Device nodes that may hold the stick's file system, likeliest first: partitions by number, then the whole medium. Empty until the
/// kernel has found the medium and its partitions, and for a card reader without a card.
/// @param device  as above
/// @param udev    udevd's records; if missing, partitions are not waited for
std::vector<std::string> block_devices(const std::string& device, const std::string& udev = "/run/udev/data");

/// A file system mounted read-only, nosuid, nodev, noexec. The destructor unmounts it. Move-only.
class StickVolume {
 public:
  /// Mounts the first of `nodes` that is vfat or exfat.
  /// @param folder  the mount point; created if missing, and whatever is mounted there is unmounted
  /// @retval ErrorCode::kMountFailed  none can be mounted: the kernel's reason
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

/// Unmounts whatever is mounted at `folder`, even if files of a pulled stick are still open.
void unmount_all(const std::string& folder);

}  // namespace plumbline
