#pragma once
/// Where a scan's bytes come from. The slicer opens no files: its caller does.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline {

/// A stream of bytes, read once from start to end.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  /// Fills the start of `buffer`, which is not empty.
  /// @returns bytes written, 1 or more; 0 at the end of the stream
  /// @retval ErrorCode::kCannotRead  the medium failed
  [[nodiscard]] virtual Expected<std::size_t> read(std::span<std::byte> buffer) = 0;

  /// For messages, and for the format where the bytes do not tell it: "bust.ply".
  virtual std::string_view name() const = 0;

  /// Bytes in the whole stream where that is known, for progress.
  virtual std::optional<std::uint64_t> size() const = 0;
};

}  // namespace plumbline
