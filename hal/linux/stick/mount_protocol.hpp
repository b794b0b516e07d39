#pragma once
/// The messages between firmware and plumbline-mount, over a SOCK_SEQPACKET socket. One request a connection.
///
///   firmware -> plumbline-mount   name of a block device, such as "sda1"
///   plumbline-mount -> firmware   errno, an int; with 0 comes a descriptor of the mounted file system's top folder
///
/// Or, for a report that goes onto the stick:
///
///   firmware -> plumbline-mount   a ReportRequest, with a descriptor of the file that has the report
///   plumbline-mount -> firmware   errno, an int: that of copy_report(). The stick is mounted writable in between, for nobody else
///
/// The file system is mounted nowhere: only the descriptor leads to it, and it is unmounted when the last descriptor of it and of its
/// files is closed, however their process ends.

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/process/report_folder.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Where the service plumbline-mount listens.
inline constexpr const char* kMountSocket = "/run/plumbline-mount/socket";
/// Names of block devices are shorter.
inline constexpr std::size_t kDeviceNameBytes = 32;

struct ReportRequest {
  std::array<char, kDeviceNameBytes> device{};  ///< ends with 0, as do names
  std::array<char, kReportNameBytes> name{};    ///< of the file on the stick
  std::uint64_t from = 0, bytes = 0;            ///< of the descriptor's file
};

}  // namespace plumbline::inline hal::inline linux_board
