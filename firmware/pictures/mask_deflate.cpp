#include "firmware/pictures/mask_deflate.hpp"

#include <array>
#include <bit>
#include <cassert>

namespace plumbline {
namespace {

// Filters of a PNG's line.
constexpr unsigned kNoFilter = 0, kUpFilter = 2;

// Symbols of deflate: literals 0 to 255, the end, then lengths of copies.
constexpr std::size_t kEnd = 256, kFirstLength = 257, kSymbols = 286;
constexpr std::size_t kShortestCopy = 3, kLongestCopy = 258;

/// Bits of a stream, the first in the low bit of a byte.
struct Bits {
  std::uint32_t bits = 0;
  unsigned count = 0;
};
constexpr Bits operator+(Bits first, Bits second) {
  return {first.bits | second.bits << first.count, first.count + second.count};
}

/// Huffman code of RFC 1951, 3.2.2, for symbols with `lengths` bits.
template <std::size_t Count>
constexpr std::array<Bits, Count> huffman_code(const std::array<std::uint8_t, Count>& lengths) {
  std::array<Bits, Count> codes{};
  unsigned next = 0;
  for (unsigned length = 1; length < 16; ++length, next <<= 1U) {
    for (std::size_t symbol = 0; symbol < Count; ++symbol) {
      if (lengths[symbol] != length) continue;
      for (unsigned bit = 0; bit < length; ++bit) codes[symbol].bits |= (next >> (length - 1 - bit) & 1U) << bit;
      codes[symbol].count = length;
      ++next;
    }
  }
  return codes;
}

/// Bits of each symbol. An edge that moves by k pixels from line to line changes a byte by k ones in a row, or by minus that; the fewer
/// pixels, the likelier. The bits of each group are those with which the masks of meshes and scans become smallest.
constexpr std::array<std::uint8_t, kSymbols> make_lengths() {
  std::array<std::uint8_t, kSymbols> lengths{};
  for (auto& length : lengths) length = 14;
  constexpr std::array<std::uint8_t, 7> kMoved = {7, 9, 10, 10, 13, 13, 13};
  for (unsigned k = 7; k > 0; --k) {
    for (unsigned shift = 0; shift + k <= 8; ++shift) {
      const unsigned ones = ((1U << k) - 1) << shift;
      lengths[ones] = lengths[256 - ones] = kMoved[k - 1];
    }
  }
  lengths[0] = 3;
  lengths[kUpFilter] = 4;
  lengths[kEnd] = 13;
  for (std::size_t symbol = kFirstLength; symbol < kSymbols; ++symbol) lengths[symbol] = symbol < 269 ? 9 : 7;
  lengths[kSymbols - 1] = 1;  // 258 bytes
  return lengths;
}
constexpr auto kLengths = make_lengths();
constexpr auto kCode = huffman_code(kLengths);

constexpr bool is_complete() {
  unsigned sum = 0;
  for (const auto length : kLengths) sum += 1U << (14U - length);
  return sum == 1U << 14U;
}
static_assert(is_complete(), "inflate refuses other codes");

/// A copy of 3 to 258 bytes at distance 1: length and distance with their bits.
constexpr std::array<Bits, kLongestCopy + 1> make_copies() {
  constexpr Bits kDistance{0, 1};
  std::array<Bits, kLongestCopy + 1> copies{};
  std::size_t bytes = kShortestCopy;
  for (std::size_t symbol = kFirstLength; symbol + 1 < kSymbols; ++symbol) {
    // Two symbols a power of two, then four; the rest of the length is in the bits after the symbol.
    const auto more = symbol < 265 ? 0U : static_cast<unsigned>((symbol - 261) / 4);
    for (std::uint32_t rest = 0; rest < 1U << more && bytes < kLongestCopy; ++rest, ++bytes) {
      copies[bytes] = kCode[symbol] + Bits{rest, more} + kDistance;
    }
  }
  copies[kLongestCopy] = kCode[kSymbols - 1] + kDistance;
  return copies;
}
constexpr auto kCopies = make_copies();
static_assert(kCopies[kLongestCopy].bits == 0 && kCopies[kLongestCopy].count == 2, "BitWriter::zeros() relies on it");

class BitWriter {
 public:
  explicit BitWriter(std::span<std::uint8_t> out) : out_(out) {}

  void put(Bits bits) {
    word_ |= std::uint64_t{bits.bits} << count_;
    count_ += bits.count;
    for (; count_ >= 8; count_ -= 8, word_ >>= 8U) out_[size_++] = static_cast<std::uint8_t>(word_);
  }
  void zeros(std::size_t count) {
    for (; count > 32; count -= 32) put({0, 32});
    put({0, static_cast<unsigned>(count)});
  }
  /// A number from its high byte on, at the next whole byte.
  void put_whole(std::uint32_t number) {
    if (count_ > 0) put({0, 8 - count_});
    put({__builtin_bswap32(number), 32});
  }
  std::size_t size() const { return size_; }

 private:
  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
  std::uint64_t word_ = 0;  ///< bits that don't fill a byte yet
  unsigned count_ = 0;
};

/// Takes the bytes of the lines, with runs of zeros at once.
class LineWriter {
 public:
  explicit LineWriter(std::span<std::uint8_t> out) : bits_(out) {
    bits_.put({0x0178, 16});  // zlib: deflate with a window of 32 KiB, fastest
    put_code();
  }

  void zeros(std::size_t count) { zeros_ += count; }
  void literal(unsigned byte) {
    if (zeros_ > 0) put_zeros();
    bits_.put(kCode[byte]);
    sum_ += byte;
    if (sum_ >= kAdler) sum_ -= kAdler;
    sum_of_sums_ += sum_;
  }
  std::size_t end() {
    put_zeros();
    bits_.put(kCode[kEnd]);
    bits_.put_whole(static_cast<std::uint32_t>(sum_of_sums_ % kAdler << 16U | sum_));
    return bits_.size();
  }

 private:
  static constexpr std::uint32_t kAdler = 65521;  // RFC 1950, 8.2

  /// The header of a block with codes of its own (RFC 1951, 3.2.7).
  void put_code() {
    constexpr std::array<std::uint8_t, 15> kBits = {0, 5, 0, 5, 5, 0, 0, 3, 0, 3, 3, 0, 0, 5, 1};
    constexpr auto kCodeOfLengths = huffman_code(kBits);
    constexpr std::array<std::uint8_t, 19> kOrder = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
    bits_.put({1, 1});  // the last block
    bits_.put({2, 2});
    bits_.put({kSymbols - 257, 5});
    bits_.put({1, 5});  // two distances
    bits_.put({kOrder.size() - 4, 4});
    for (const auto length : kOrder) bits_.put({length < kBits.size() ? kBits[length] : 0U, 3});
    for (const auto length : kLengths) bits_.put(kCodeOfLengths[length]);
    for (int distance = 0; distance < 2; ++distance) bits_.put(kCodeOfLengths[1]);
  }

  void put_zeros() {
    if (zeros_ == 0) return;
    sum_of_sums_ += zeros_ * sum_;
    std::size_t copied = zeros_ - 1;
    bits_.put(kCode[0]);
    bits_.zeros(copied / kLongestCopy * kCopies[kLongestCopy].count);
    copied %= kLongestCopy;
    if (copied >= kShortestCopy) {
      bits_.put(kCopies[copied]);
    } else {
      for (; copied > 0; --copied) bits_.put(kCode[0]);
    }
    zeros_ = 0;
  }

  BitWriter bits_;
  std::size_t zeros_ = 0;  ///< taken, not yet written
  std::uint32_t sum_ = 1;
  std::uint64_t sum_of_sums_ = 0;  ///< 64 bits are enough for the largest mask
};

/// a - b in each of eight bytes.
constexpr std::uint64_t byte_differences(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kHigh = 0x8080808080808080U;
  return ((a | kHigh) - (b & ~kHigh)) ^ ((a ^ ~b) & kHigh);
}

/// The pixels of a word less those above it, as bits of whole bytes.
void put_bits(LineWriter& lines, std::uint64_t word, std::uint64_t above, std::uint32_t pixels) {
  const std::size_t bytes = (pixels + std::size_t{7}) / 8;
  const std::uint64_t change = byte_differences(reversed_bits(word), reversed_bits(above));
  for (std::size_t i = 0; i < bytes; ++i) {
    const auto byte = static_cast<unsigned>(change >> (56 - 8 * i) & 0xFFU);
    byte == 0 ? lines.zeros(1) : lines.literal(byte);
  }
}

/// The pixels of a word less those above it, as bytes of 0 or 255.
void put_bytes(LineWriter& lines, std::uint64_t word, std::uint64_t above, std::uint32_t pixels) {
  std::uint32_t done = 0;
  for (std::uint64_t changed = word ^ above; changed != 0; changed &= changed - 1) {
    const auto at = static_cast<std::uint32_t>(std::countr_zero(changed));
    lines.zeros(at - done);
    lines.literal((word >> at & 1U) != 0 ? 255 : 1);
    done = at + 1;
  }
  lines.zeros(pixels - done);
}

}  // namespace

std::size_t deflate_mask(ConstBitImage mask, MaskDepth depth, std::span<std::uint8_t> out) {
  assert(mask.columns() > 0 && mask.rows() > 0);
  assert(out.size() >= deflated_mask_bound(mask.columns(), mask.rows(), depth));
  LineWriter lines(out);
  const auto bytes_of = [depth](std::uint32_t pixels) { return line_bytes(pixels, depth); };
  const std::size_t last = mask.stride() - std::size_t{1};
  const std::uint64_t valid = mask.last_word_mask();
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    const auto row = mask.row(r);
    std::uint64_t any = row[last] & valid;
    for (std::size_t w = 0; w < last; ++w) any |= row[w];
    if (any == 0) {
      static_assert(kNoFilter == 0);
      lines.zeros(1 + bytes_of(mask.columns()));
      continue;
    }
    lines.literal(kUpFilter);
    for (std::size_t w = 0; w <= last; ++w) {
      const std::uint64_t kept = w == last ? valid : ~std::uint64_t{0};
      const std::uint64_t word = row[w] & kept;
      const std::uint64_t above = r > 0 ? mask.row(r - 1)[w] & kept : 0U;
      const std::uint32_t pixels = w == last ? mask.columns() - static_cast<std::uint32_t>(64 * last) : 64;
      if (word == above) {
        lines.zeros(bytes_of(pixels));
      } else {
        (depth == MaskDepth::kBit ? put_bits : put_bytes)(lines, word, above, pixels);
      }
    }
  }
  return lines.end();
}

}  // namespace plumbline
