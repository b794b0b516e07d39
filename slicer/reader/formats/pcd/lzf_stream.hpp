#pragma once
/// Decompresses LZF, the compression of PCD files, as a stream.

#include <cstdint>
#include <span>

#include "slicer/reader/stream/byte_input.hpp"

namespace plumbline::inline slicer {

/// A back reference reaches at most 8192 bytes, so a small window suffices for a block of any size.
///
/// A control byte below 32 is followed by control + 1 literal bytes. Any other starts a back reference: its length is
/// 2 + (control >> 5), plus the next byte if that is 2 + 7; its lower 5 bits are the upper 5 of the 13 bits of the
/// distance - 1. (liblzf, lzf_d.c)
class LzfStream {
 public:
  static constexpr std::size_t kReach = 8192;               ///< bytes, farthest back reference
  static constexpr std::size_t kLongestStep = 2 + 7 + 255;  ///< bytes that one control byte can make
  static constexpr std::size_t kWindow = 4 * kReach;        ///< bytes; a larger one moves the last kReach less often

  /// @param window      kWindow bytes
  /// @param compressed  bytes of the block in `input`
  LzfStream(ByteInput& input, std::span<char> window, std::uint64_t compressed)
      : input_(input), window_(window), compressed_left_(compressed) {}

  /// @returns the next decompressed bytes, valid until the next call; empty at the end of the block
  /// @retval ErrorCode::kTruncated  the file ends before the block does
  /// @retval ErrorCode::kMalformed  a reference reaches before the start, or the block ends within a step
  [[nodiscard]] Expected<std::span<const char>> next();

 private:
  /// Makes `bytes` bytes of the block available at input_.begin().
  Status need(std::size_t bytes);
  Status literals(std::size_t count);
  Status reference(unsigned control);

  ByteInput& input_;
  std::span<char> window_;
  std::uint64_t compressed_left_;
  std::size_t end_ = 0;  ///< of the decompressed bytes in window_
};

}  // namespace plumbline::inline slicer
