#pragma once
/// The parts of a zip archive, one after another.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/inflate_stream.hpp"

namespace plumbline::inline slicer {

/// Follows the headers in front of the parts (APPNOTE.TXT 4.3.7), so the archive is read as a stream. The directory at its end, which
/// minizip needs first, is not used. Sizes and checksums are those of the headers, or follow the data.
class ZipParts {
 public:
  static constexpr std::size_t kLongestName = 256;  ///< bytes; parts with longer names have no name here
  /// Bytes of all parts that have to be unpacked: some forty million triangles of a 3MF. Packed blanks must not take hours.
  static constexpr std::uint64_t kMostUnpacked = std::uint64_t{4} << 30U;

  /// @param inflate  Wrapping::kNone, over the same input
  ZipParts(ByteInput& input, InflateStream& inflate) : input_(input), inflate_(inflate) {}

  /// Goes to the next part, past what is left of the current one.
  /// @returns false after the last one
  /// @retval ErrorCode::kTruncated    the file ends before the archive does
  /// @retval ErrorCode::kMalformed    no zip archive, or a damaged one
  /// @retval ErrorCode::kUnsupported  the end of the part can't be found without knowing how it is packed
  [[nodiscard]] Expected<bool> next();

  /// Path of the part as it is written; valid until next().
  std::string_view name() const { return {name_.data(), name_size_}; }

  /// Takes the next bytes of the part.
  /// @returns valid until the next call; empty at the end of the part
  /// @retval ErrorCode::kUnsupported  encrypted, packed other than by deflate, or more than kMostUnpacked
  /// @retval ErrorCode::kMalformed    damaged; the checksum is tested at the end of the part
  [[nodiscard]] Expected<std::span<const char>> read();

 private:
  [[nodiscard]] Status read_head();
  [[nodiscard]] Expected<std::span<const char>> piece();
  [[nodiscard]] Status finish_part();
  [[nodiscard]] Status take_descriptor();
  [[nodiscard]] Status need(std::size_t bytes);
  [[nodiscard]] Status find_long_size(std::size_t bytes);
  std::uint64_t load(std::size_t at, std::size_t bytes) const;

  ByteInput& input_;
  InflateStream& inflate_;
  std::array<char, kLongestName> name_ = {};
  std::size_t name_size_ = 0;
  bool open_ = false;     ///< a part has bytes left, or its descriptor
  bool touched_ = false;  ///< some of it was read
  bool encrypted_ = false;
  bool sizes_follow_ = false;
  unsigned method_ = 0;
  std::uint64_t left_ = 0;      ///< packed bytes, unless sizes_follow_
  std::uint32_t checksum_ = 0;  ///< of the header
  std::uint32_t sum_ = 0;       ///< of what was read
  std::uint64_t unpacked_ = 0;  ///< of all parts so far
};

}  // namespace plumbline::inline slicer
