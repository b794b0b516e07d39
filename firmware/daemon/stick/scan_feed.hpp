#pragma once
/// Hands a stick's files to the slicing child.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "firmware/io/descriptor.hpp"
#include "hal/stick_port.hpp"

namespace plumbline::firmware {

/// On a board the child reads the files itself. In simulation reading takes virtual time, so the bytes go through a pipe.
class ScanFeed {
 public:
  /// @param files  1 to kMostScans; must outlive the feed
  explicit ScanFeed(std::span<StickFile> files);
  ScanFeed(const ScanFeed&) = delete;
  ScanFeed& operator=(const ScanFeed&) = delete;

  /// The descriptors that the child reads, in the files' order.
  /// @retval ErrorCode::kCannotRead  no pipe
  [[nodiscard]] Expected<std::vector<int>> open();
  /// Call it when the child has its copies.
  void opened();

  /// Moves bytes into each pipe, as many as it takes now: the child looks at the beginning of every file before it reads one.
  /// @returns whether it moved any
  /// @retval the errors of StickFile::read()
  [[nodiscard]] Expected<bool> pump();

 private:
  struct Pipe {
    StickFile* file = nullptr;
    std::span<std::byte> room;     ///< its share of bytes_
    Descriptor ours;               ///< the end for the child, until it has a copy
    Descriptor into;               ///< the other end; closed: all is in it, or there is none
    std::size_t from = 0, to = 0;  ///< of its room: read from the file, not in the pipe yet
  };
  [[nodiscard]] static Expected<bool> pump(Pipe& pipe);

  std::vector<Pipe> pipes_;
  std::array<std::byte, 65536> bytes_{};
};

}  // namespace plumbline::firmware
