#pragma once
/// The head of a stream, looked at before its turn comes.

#include <cstddef>
#include <optional>
#include <span>

#include "slicer/core/byte_source.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// Keeps the first bytes of a stream, which may be read once as a stream of their own before all of it is read.
class PeekedSource final : public ByteSource {
 public:
  /// The head of nearly every scan, and the first rows of those that have none.
  static constexpr std::size_t kBytes = 4096;

  /// @param source  outlives this
  /// @param room    kBytes
  PeekedSource(ByteSource& source, std::span<std::byte> room) : source_(source), room_(room) {}

  /// What the head says, as far as the kept bytes tell; nothing where they end too soon or are no scan, which will be told
  /// when the stream is read.
  /// @param workspace  as for read_scan(), free again when it returns
  /// @retval ErrorCode::kCannotRead  of the stream
  [[nodiscard]] Expected<std::optional<ScanHeader>> peek(std::span<std::byte> workspace);

  [[nodiscard]] Expected<std::size_t> read(std::span<std::byte> buffer) override;
  std::string_view name() const override { return source_.name(); }
  std::optional<std::uint64_t> size() const override { return source_.size(); }

 private:
  ByteSource& source_;
  std::span<std::byte> room_;
  std::size_t kept_ = 0;
  std::size_t at_ = 0;
  bool peeking_ = false;  ///< what is kept is the whole stream
};

}  // namespace plumbline
