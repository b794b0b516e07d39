#include "slicer/reader/formats/pcd/pcd_compressed.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <limits>

#include "slicer/reader/formats/pcd/lzf_stream.hpp"
#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

/// The block holds all values of the first field, then all of the second, and so on. The wanted columns are kept as they
/// are in the file. The last of them need not be kept: each of its values completes a point.
class ColumnReader {
 public:
  ColumnReader(ByteInput& input, const PcdHeader& header, PointBatch& batch, LzfStream& block)
      : input_(input), header_(header), batch_(batch), block_(block) {}

  /// @param last  the last wanted field
  Status read(const std::array<std::span<char>, kSlots>& kept, const PcdField& last) {
    kept_ = kept;
    for (const PcdField& field : header_.fields) {
      const std::uint64_t bytes = field.bytes() * header_.points;  // at most the block's size, which has 32 bits
      if (&field == &last) return deliver(field);
      PLUMBLINE_TRY(take(bytes, [&, to = field.slot < kSlots ? kept_[field.slot].data()
                                                             : nullptr](std::span<const char> piece) mutable {
        if (to == nullptr) return;
        std::memcpy(to, piece.data(), piece.size());
        to += piece.size();
      }));
    }
    return {};
  }

 private:
  /// Makes piece_ not empty.
  Status refill() {
    while (piece_.empty()) {
      const auto next = block_.next();
      if (!next && next.error().code() == ErrorCode::kTruncated) {
        return input_.fail(ErrorCode::kTruncated,
                           "the file ends at byte %llu, in its compressed block, with %llu of the %llu points that its "
                           "header declares;\tcopy or save it again",
                           static_cast<unsigned long long>(input_.bytes_read()),
                           static_cast<unsigned long long>(complete_), static_cast<unsigned long long>(header_.points));
      }
      PLUMBLINE_TRY(next);
      if (next->empty()) {
        return input_.fail(
            ErrorCode::kMalformed,
            "byte %llu: the compressed block is too short for the %llu points that the header declares;\t"
            "save the file again",
            static_cast<unsigned long long>(input_.offset()), static_cast<unsigned long long>(header_.points));
      }
      piece_ = *next;
    }
    return {};
  }

  template <class Use>
  Status take(std::uint64_t bytes, Use&& use) {
    while (bytes > 0) {
      PLUMBLINE_TRY(refill());
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, piece_.size()));
      use(piece_.first(count));
      piece_ = piece_.subspan(count);
      bytes -= count;
    }
    return {};
  }

  Status deliver(const PcdField& last) {
    SlotValues row = {};
    char value[8];
    for (; complete_ < header_.points; ++complete_) {
      if (piece_.size() >= last.size) {
        std::memcpy(value, piece_.data(), last.size);
        piece_ = piece_.subspan(last.size);
      } else {
        char* to = value;
        PLUMBLINE_TRY(take(last.size, [&](std::span<const char> piece) {
          std::memcpy(to, piece.data(), piece.size());
          to += piece.size();
        }));
      }
      row[last.slot] = load_scalar(last.type, value, std::endian::little);
      for (const PcdField& field : header_.fields) {
        if (field.slot >= kSlots || &field == &last) continue;
        row[field.slot] =
            load_scalar(field.type, kept_[field.slot].data() + complete_ * field.size, std::endian::little);
      }
      batch_.add(row);
      if (batch_.full()) PLUMBLINE_TRY(batch_.flush());
    }
    return {};
  }

  ByteInput& input_;
  const PcdHeader& header_;
  PointBatch& batch_;
  LzfStream& block_;
  std::array<std::span<char>, kSlots> kept_;
  std::span<const char> piece_;  ///< decompressed, not used yet
  std::uint64_t complete_ = 0;   ///< points
};

const PcdField* last_wanted(const PcdHeader& header) {
  const PcdField* last = nullptr;
  for (const PcdField& field : header.fields) {
    if (field.slot < kSlots) last = &field;
  }
  return last;
}

}  // namespace

std::uint64_t compressed_columns_bytes(const PcdHeader& header) {
  if (header.data != PcdData::kBinaryCompressed) return 0;
  const PcdField* last = last_wanted(header);
  std::uint64_t bytes = Arena::rounded(LzfStream::kWindow);
  for (const PcdField& field : header.fields) {
    if (field.slot >= kSlots || &field == last) continue;
    bytes = saturating_add(bytes, saturating_add(saturating_multiply(field.bytes(), header.points), Arena::kAlignment));
  }
  return bytes;
}

Status read_pcd_compressed(ByteInput& input, const PcdHeader& header, PointBatch& batch, Arena& memory) {
  constexpr std::size_t kSizes = 2 * sizeof(std::uint32_t);
  const auto ready = input.fill(kSizes);
  PLUMBLINE_TRY(ready);
  if (*ready < kSizes) {
    return input.fail(
        ErrorCode::kTruncated,
        "the file ends at byte %llu, before its compressed block, with 0 of %llu points;\tcopy or save it again",
        static_cast<unsigned long long>(input.bytes_read()), static_cast<unsigned long long>(header.points));
  }
  std::uint32_t sizes[2];
  std::memcpy(sizes, input.begin(), kSizes);
  if constexpr (std::endian::native == std::endian::big) {
    for (auto& size : sizes) size = __builtin_bswap32(size);
  }
  const std::uint64_t expected = saturating_multiply(header.layout.bytes(), header.points);
  if (sizes[1] != expected) {
    return input.fail(
        ErrorCode::kMalformed,
        "byte %llu: expected a compressed block of %llu bytes (%llu points of %llu), found one of %llu; save the "
        "file again",
        static_cast<unsigned long long>(input.offset() + sizeof(std::uint32_t)),
        static_cast<unsigned long long>(expected), static_cast<unsigned long long>(header.points),
        static_cast<unsigned long long>(header.layout.bytes()), static_cast<unsigned long long>(sizes[1]));
  }
  input.consume(kSizes);

  const PcdField* last = last_wanted(header);
  assert(last != nullptr && "a header without x, y and z has been refused");
  const std::uint64_t need = compressed_columns_bytes(header);
  if (need > memory.available()) {
    return input.fail(
        ErrorCode::kUnsupported,
        "binary_compressed stores its columns one after another; keeping those of %llu points takes %llu bytes, "
        "but %zu are free. Save the file as binary",
        static_cast<unsigned long long>(header.points), static_cast<unsigned long long>(need), memory.available());
  }
  const auto window = memory.take_bottom<char>(LzfStream::kWindow, "reading PCD");
  PLUMBLINE_TRY(window);
  std::array<std::span<char>, kSlots> kept;
  for (const PcdField& field : header.fields) {
    if (field.slot >= kSlots || &field == last) continue;
    const auto column =
        memory.take_bottom<char>(static_cast<std::size_t>(field.bytes() * header.points), "reading PCD");
    PLUMBLINE_TRY(column);
    kept[field.slot] = *column;
  }
  LzfStream block(input, *window, sizes[0]);
  return ColumnReader(input, header, batch, block).read(kept, *last);
}

}  // namespace plumbline::inline slicer
