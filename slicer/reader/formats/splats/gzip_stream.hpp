#pragma once
/// Decompresses gzip (RFC 1952) as a stream, by zlib.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/fixed_heap.hpp"

struct z_stream_s;  ///< of zlib

namespace plumbline {

class GzipStream {
 public:
  static constexpr std::size_t kWindow = std::size_t{32} * 1024;  ///< bytes that come at once
  static constexpr std::size_t kHeap = std::size_t{64} * 1024;    ///< bytes; zlib says that it takes about 44 KB
  static constexpr std::uint64_t kLargestRatio = 1032;            ///< deflate can't make a byte from less than 1/1032

  /// @param window  kWindow bytes
  /// @param heap    kHeap bytes
  GzipStream(ByteInput& input, std::span<char> window, std::span<std::byte> heap);
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;
  ~GzipStream();

  /// Decompresses up to `most` bytes, at least one.
  /// @returns valid until the next call; empty at the end of the stream
  /// @retval ErrorCode::kTruncated  the file ends before the stream does
  /// @retval ErrorCode::kMalformed  not gzip, or damaged
  [[nodiscard]] Expected<std::span<const char>> next(std::uint64_t most);

 private:
  ByteInput& input_;
  std::span<char> window_;
  FixedHeap heap_;
  z_stream_s* zlib_ = nullptr;  ///< in heap_; null: there is no room for it
  bool ended_ = false;
};

}  // namespace plumbline
