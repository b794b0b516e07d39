#pragma once
/// Lets one system call fail in the code under test, which is linked with --wrap (tests/CMakeLists.txt). Calls of libraries, and those on
/// the three standard streams, are left alone.

#include <cstddef>
#include <cstdint>

namespace plumbline::firmware {

enum class Calls : std::uint8_t {
  kReads,     ///< read, pread
  kWrites,    ///< write, pwrite
  kFiles,     ///< open and openat for writing, fsync, fdatasync, rename, renameat, close
  kRemovals,  ///< unlinkat
  kAll,
};

enum class Failure : std::uint8_t {
  kIoError,    ///< EIO; close() closes all the same
  kDiskFull,   ///< ENOSPC
  kShort,      ///< half of the bytes, or one if there is but one. A write that follows finds the disk full
  kCutInHalf,  ///< half of the bytes, and no failure
  kStaysFull,  ///< ENOSPC, for this call and all behind it
  kKilled,     ///< SIGKILL before the call, or halfway through a write. For a child of the test
  kPowerCut,   ///< the same, and all files that are not durable are left as zeros, under the names that they have
};

/// Files and folders that were changed since a FailingCall with kPowerCut began, and are not durable.
std::size_t not_durable();
/// Folders in which a file was made or removed since then, and which were not made durable since.
std::size_t names_not_durable();

/// From construction to destruction. One at a time.
class FailingCall {
 public:
  /// @param nth  from 1; 0: none fails, they are only counted
  FailingCall(Calls calls, std::uint32_t nth, Failure failure);
  ~FailingCall();
  FailingCall(const FailingCall&) = delete;
  FailingCall& operator=(const FailingCall&) = delete;

  /// Whether the n-th call has come.
  bool happened() const;
};

}  // namespace plumbline::firmware
