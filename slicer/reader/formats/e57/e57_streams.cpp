#include "slicer/reader/formats/e57/e57_streams.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

namespace plumbline::inline slicer {

E57Streams::E57Streams(const E57Scan& scan, std::span<char> memory)
    : scan_(scan), now_(memory.first(memory.size() / 2)), next_(memory.subspan(memory.size() / 2)) {}

void E57Streams::begin_packet() {
  std::swap(now_, next_);
  filled_ = 0;
}

std::optional<std::span<char>> E57Streams::begin_stream(std::size_t slot, std::size_t bytes) {
  Stream& stream = stream_[slot];
  const auto kept = static_cast<std::size_t>(stream.end - stream.begin);
  if (kept + bytes > now_.size() - filled_) return std::nullopt;
  char* const to = now_.data() + filled_;
  if (kept > 0) std::memcpy(to, stream.begin, kept);
  filled_ += kept + bytes;
  stream.begin = to;
  stream.end = to + kept + bytes;
  return std::span(to + kept, bytes);
}

std::uint64_t E57Streams::ready() const {
  std::uint64_t points = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t slot = 0; slot < kE57Slots; ++slot) {
    const unsigned bits = scan_.field[slot].bits;
    if (bits > 0) points = std::min(points, stream_[slot].bits() / bits);
  }
  return points;
}

/// The lowest bit of the first byte comes first.
/// @param count  1 to 64, at most stream.bits()
std::uint64_t E57Streams::take_bits(Stream& stream, unsigned count) {
  const unsigned used = stream.used;
  std::uint64_t value = 0;
  const unsigned bytes = (used + count + 7) / 8;  // up to 9
  if (stream.end - stream.begin >= 8) {
    std::memcpy(&value, stream.begin, 8);
    if constexpr (std::endian::native == std::endian::big) value = __builtin_bswap64(value);
  } else {
    for (unsigned i = 0; i < std::min(bytes, 8U); ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(stream.begin[i])} << (8 * i);
    }
  }
  value >>= used;
  if (bytes == 9) value |= std::uint64_t{static_cast<unsigned char>(stream.begin[8])} << (64 - used);
  if (count < 64) value &= (std::uint64_t{1} << count) - 1;
  stream.begin += (used + count) / 8;
  stream.used = (used + count) % 8;
  return value;
}

void E57Streams::take(std::array<double, kE57Slots>& values) {
  for (std::size_t slot = 0; slot < kE57Slots; ++slot) {
    const E57Field& field = scan_.field[slot];
    const std::uint64_t bits = field.bits > 0 ? take_bits(stream_[slot], field.bits) : 0;
    switch (field.kind) {
      case E57Field::Kind::kNone: values[slot] = 0; break;
      case E57Field::Kind::kFloat:
        values[slot] = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
        break;
      case E57Field::Kind::kDouble: values[slot] = std::bit_cast<double>(bits); break;
      case E57Field::Kind::kInteger: {
        const auto whole = static_cast<std::int64_t>(static_cast<std::uint64_t>(field.minimum) + bits);
        values[slot] = static_cast<double>(whole) * field.scale + field.offset;
        break;
      }
    }
  }
}

}  // namespace plumbline::inline slicer
