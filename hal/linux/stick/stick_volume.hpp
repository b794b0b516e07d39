#pragma once
/// From a USB device to its mounted file system, with sysfs and plumbline-mount.

#include <string>
#include <vector>

#include "hal/stick_port.hpp"

namespace plumbline::inline hal::inline linux_board {

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

/// Connects to plumbline-mount.
/// @returns a descriptor, the caller's; or -1 with errno set
[[nodiscard]] int connect_to_mount(const std::string& socket);

/// Has plumbline-mount mount all of `nodes` that are vfat or exfat, in their order: a medium only if none of its partitions is.
/// @param nodes   of block_devices()
/// @param socket  where it listens
/// @returns the caller's descriptors. When one and all files opened through it are closed, that partition is unmounted
/// @retval ErrorCode::kMountFailed  none can be mounted: the kernel's reason; or plumbline-mount does not answer
[[nodiscard]] Expected<StickParts> mount_stick(const std::vector<std::string>& nodes, const std::string& socket);

/// Has plumbline-mount copy a report onto the first of `nodes` that is vfat or exfat and has the folder for it.
/// @retval ErrorCode::kMountFailed  as mount_stick()
/// @retval ErrorCode::kCannotWrite  the stick is full or write-protected, or its file system is damaged
/// @returns false if it is there already
[[nodiscard]] Expected<bool> store_on_stick(const std::vector<std::string>& nodes, const StickReport& report,
                                            const std::string& socket);

}  // namespace plumbline::inline hal::inline linux_board
