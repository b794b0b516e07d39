#pragma once
/// LZF, the compression of PCD files, undone as a stream.

#include <cstdint>
#include <span>

#include "slicer/reader/stream/byte_input.hpp"

namespace plumbline {

/// A back reference reaches at most 8192 bytes, so a window of little more is all the memory that it takes, however
/// large the block is.
///
/// A control byte below 32 stands before control + 1 literal bytes; any other holds a length of 2 + (control >> 5),
/// where 2 + 7 is lengthened by the next byte, and the upper 5 of the 13 bits of a distance less one. (liblzf, lzf_d.c)
class LzfStream {
 public:
  static constexpr std::size_t kReach = 8192;               ///< bytes, farthest back reference
  static constexpr std::size_t kLongestStep = 2 + 7 + 255;  ///< bytes that one control byte can make
  static constexpr std::size_t kWindow = 4 * kReach;        ///< bytes of memory

  /// @param window      kWindow bytes
  /// @param compressed  bytes that the block takes in `input`
  LzfStream(ByteInput& input, std::span<char> window, std::uint64_t compressed)
      : input_(input), window_(window), compressed_left_(compressed) {}

  /// @returns the next bytes, valid until the next call; empty at the end of the block
  /// @retval ErrorCode::kTruncated  the file ends before the block does
  /// @retval ErrorCode::kMalformed  a reference to before the start, or a block that ends in the middle of a step
  [[nodiscard]] Expected<std::span<const char>> next();

 private:
  /// Has `bytes` bytes of the block ready at input_.begin().
  Status need(std::size_t bytes);
  Status literals(std::size_t count);
  Status reference(unsigned control);

  ByteInput& input_;
  std::span<char> window_;
  std::uint64_t compressed_left_;
  std::size_t end_ = 0;  ///< of what has been decoded, in window_
};

}  // namespace plumbline
