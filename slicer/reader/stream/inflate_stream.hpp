#pragma once
/// zlib: decompresses deflate (RFC 1951) as a stream.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/fixed_heap.hpp"

struct z_stream_s;  ///< of zlib

namespace plumbline::inline slicer {

/// The checksum of zip and gzip (ISO 3309).
/// @param before  of the bytes before these; 0 at the start
std::uint32_t crc32_of(std::span<const char> bytes, std::uint32_t before);

class InflateStream {
 public:
  enum class Wrapping : std::uint8_t {
    kGzip,  ///< RFC 1952: members one after another, each with a checksum of its own
    kNone,  ///< as in a zip archive
  };

  static constexpr std::size_t kWindow = std::size_t{32} * 1024;  ///< bytes that come at once
  static constexpr std::size_t kHeap = std::size_t{64} * 1024;    ///< bytes; zlib says that it takes about 44 KB
  static constexpr std::uint64_t kLargestRatio = 1032;            ///< deflate can't make a byte from less than 1/1032

  /// @param window  kWindow bytes
  /// @param heap    kHeap bytes
  InflateStream(ByteInput& input, Wrapping wrapping, std::span<char> window, std::span<std::byte> heap);
  InflateStream(const InflateStream&) = delete;
  InflateStream& operator=(const InflateStream&) = delete;
  ~InflateStream();

  /// Makes ready for another stream, which begins where the input stands.
  void restart();

  /// Decompresses up to `most` bytes, at least one.
  /// @returns valid until the next call; empty at the end of the stream
  /// @retval ErrorCode::kTruncated  the file ends before the stream does
  /// @retval ErrorCode::kMalformed  no such stream, or a damaged one
  [[nodiscard]] Expected<std::span<const char>> next(std::uint64_t most);

 private:
  ByteInput& input_;
  std::span<char> window_;
  FixedHeap heap_;
  z_stream_s* zlib_ = nullptr;  ///< in heap_; null: there is no room for it
  bool is_gzip_;
  bool ended_ = false;
};

}  // namespace plumbline::inline slicer
