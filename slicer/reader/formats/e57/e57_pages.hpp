#pragma once
/// The pages of an E57 file: 1020 bytes each, with a checksum.

#include <cstdint>
#include <optional>
#include <span>

#include "slicer/reader/stream/byte_input.hpp"

namespace plumbline::inline slicer {

/// CRC-32C (Castagnoli), as in iSCSI (RFC 3720, appendix B.4).
std::uint32_t crc32c(std::span<const char> bytes);

/// The file without its checksums. Offsets of this stream are "logical", those of the file "physical" (ASTM E2807, 5.2).
class E57Pages {
 public:
  static constexpr std::size_t kPage = 1024;     ///< bytes
  static constexpr std::size_t kPayload = 1020;  ///< bytes of a page before its checksum

  /// @param input  at its first byte
  explicit E57Pages(ByteInput& input) : input_(input) {}

  /// @returns nothing if the offset is that of a checksum
  static std::optional<std::uint64_t> logical(std::uint64_t physical) {
    if (physical % kPage >= kPayload) return std::nullopt;
    return physical / kPage * kPayload + physical % kPage;
  }

  std::uint64_t offset() const { return page_ * kPayload + used_; }    ///< logical, of the next byte
  std::uint64_t file_offset() const { return page_ * kPage + used_; }  ///< physical, of the next byte
  ByteInput& input() const { return input_; }

  /// Goes to a logical offset that is not before offset(). Pages between are not checked.
  [[nodiscard]] Status seek(std::uint64_t offset);
  /// Goes back to the first byte.
  [[nodiscard]] Status rewind();

  /// Takes the next bytes that lie together, at most `most` and at least one.
  /// @returns valid until the next call
  /// @retval ErrorCode::kTruncated  the file ends before them
  /// @retval ErrorCode::kMalformed  the page's checksum is wrong
  [[nodiscard]] Expected<std::span<const char>> next(std::uint64_t most);
  /// Fills `to`. Errors as above.
  [[nodiscard]] Status read(std::span<char> to);

 private:
  ByteInput& input_;  ///< at the start of the current page
  std::uint64_t page_ = 0;
  std::size_t used_ = 0;  ///< bytes of the page, below kPayload
  bool checked_ = false;  ///< the page is in the window, and its checksum is right
};

}  // namespace plumbline::inline slicer
