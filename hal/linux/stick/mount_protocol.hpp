#pragma once
/// The messages between firmware and plumbline-mount, over a SOCK_SEQPACKET socket. One request a connection.
///
///   firmware -> plumbline-mount   name of a block device, such as "sda1"
///   plumbline-mount -> firmware   errno, an int; with 0 comes a descriptor of the mounted file system's top folder
///
/// The file system is mounted nowhere: only the descriptor leads to it, and it is unmounted when the last descriptor of it and of its
/// files is closed, however their process ends.

#include <cstddef>

namespace plumbline {

/// Where the service plumbline-mount listens.
inline constexpr const char* kMountSocket = "/run/plumbline-mount/socket";
/// Names of block devices are shorter.
inline constexpr std::size_t kDeviceNameBytes = 32;

}  // namespace plumbline
