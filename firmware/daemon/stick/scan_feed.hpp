#pragma once
/// Hands a stick's file to the slicing child.

#include <array>
#include <cstddef>

#include "firmware/io/descriptor.hpp"
#include "hal/stick_port.hpp"

namespace plumbline {

/// On a board the child reads the file itself. In simulation reading takes virtual time, so the bytes go through a pipe.
class ScanFeed {
 public:
  /// @param file  must outlive the feed
  explicit ScanFeed(StickFile& file) : file_(file) {}
  ScanFeed(const ScanFeed&) = delete;
  ScanFeed& operator=(const ScanFeed&) = delete;

  /// The descriptor that the child reads.
  /// @retval ErrorCode::kCannotRead  no pipe
  [[nodiscard]] Expected<int> open();
  /// Call it when the child has its copy.
  void opened() { ours_ = Descriptor(); }

  /// Moves bytes into the pipe, as many as it takes now.
  /// @returns whether it moved any
  /// @retval the errors of StickFile::read()
  [[nodiscard]] Expected<bool> pump();

 private:
  StickFile& file_;
  Descriptor ours_;  ///< the pipe's end for the child, until it has a copy
  Descriptor into_;  ///< the pipe's other end; closed: all is in it, or there is none
  std::array<std::byte, 65536> bytes_{};
  std::size_t from_ = 0, to_ = 0;  ///< of bytes_: read from the file, not in the pipe yet
};

}  // namespace plumbline
