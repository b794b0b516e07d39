#pragma once
/// A file's bytes as a stream. The caller opens the files; the slicer never does.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline::inline slicer {

/// A stream of bytes, read from start to end: once for a scan, two or three times for a mesh.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  /// Reads up to buffer.size() bytes into `buffer`, which must not be empty.
  /// @returns bytes read, 1 or more; 0 at the end of the stream
  /// @retval ErrorCode::kCannotRead  the medium failed
  [[nodiscard]] virtual Expected<std::size_t> read(std::span<std::byte> buffer) = 0;

  /// File name such as "bust.ply": shown in messages, and decides the format where the bytes do not.
  virtual std::string_view name() const = 0;

  /// Bytes in the whole stream, if known. Used for progress, to bound the number of points, and to notice a stream that ends
  /// too early.
  virtual std::optional<std::uint64_t> size() const = 0;

  /// Goes back to the first byte.
  /// @retval ErrorCode::kUnsupported  the stream can be read only once, such as a pipe; nothing has changed
  [[nodiscard]] virtual Status rewind() { return fail(ErrorCode::kUnsupported, "can be read only once"); }
};

}  // namespace plumbline::inline slicer
