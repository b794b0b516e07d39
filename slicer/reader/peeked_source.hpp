#pragma once
/// Reads the header of a stream ahead of its turn.

#include <cstddef>
#include <optional>
#include <span>

#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::inline slicer {

/// Keeps the first bytes of a stream, so that its header can be read before the stream itself is.
class PeekedSource final : public ByteSource {
 public:
  /// Bytes kept of each waiting file: nearly every header, and the first rows of files without one. Where a header is
  /// longer, memory is planned by the file's size.
  static constexpr std::size_t kBytes = 4096;

  /// @param source  outlives this
  /// @param room    kBytes bytes
  PeekedSource(ByteSource& source, std::span<std::byte> room) : source_(source), room_(room) {}

  [[nodiscard]] Status rewind() override;

  /// Reads the header from the first kBytes bytes. A damaged header is no error here: read_scan() reports it.
  /// @param workspace  as for read_scan(); free again when this returns
  /// @returns the header; nothing if it is longer than kBytes or not that of a scan
  /// @retval ErrorCode::kCannotRead  the source failed
  [[nodiscard]] Expected<std::optional<ScanHeader>> peek(std::span<std::byte> workspace);

  /// Whether the file begins with these bytes. Call it after peek().
  bool begins_with(std::string_view signature) const {
    return std::string_view(reinterpret_cast<const char*>(room_.data()), kept_).starts_with(signature);
  }

  [[nodiscard]] Expected<std::size_t> read(std::span<std::byte> buffer) override;
  std::string_view name() const override { return source_.name(); }
  std::optional<std::uint64_t> size() const override { return peeking_ ? kept_ : source_.size(); }

 private:
  ByteSource& source_;
  std::span<std::byte> room_;
  std::size_t kept_ = 0;
  std::size_t at_ = 0;
  bool peeking_ = false;  ///< the kept bytes stand for the whole stream
};

}  // namespace plumbline::inline slicer
