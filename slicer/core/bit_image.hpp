#pragma once
/// Images of one bit a pixel, 64 pixels a word: masks and sets of rays.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

namespace plumbline::inline slicer {

/// Bit 63 to 0: a word of an image has its first pixel in the low bit, PNG in the high one.
constexpr std::uint64_t reversed_bits(std::uint64_t word) {
  word = ((word >> 1) & 0x5555555555555555U) | ((word & 0x5555555555555555U) << 1);
  word = ((word >> 2) & 0x3333333333333333U) | ((word & 0x3333333333333333U) << 2);
  word = ((word >> 4) & 0x0F0F0F0F0F0F0F0FU) | ((word & 0x0F0F0F0F0F0F0F0FU) << 4);
  return __builtin_bswap64(word);
}

/// As std::popcount(), but inline: on x86-64 that one calls libgcc, which takes twice the instructions.
constexpr std::uint32_t count_ones(std::uint64_t word) {
  word -= (word >> 1) & 0x5555555555555555U;
  word = (word & 0x3333333333333333U) + ((word >> 2) & 0x3333333333333333U);
  word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<std::uint32_t>((word * 0x0101010101010101U) >> 56);
}

/// Whether all pixels of a row are black. Most of a panel is: one look at a row spares the rest of the work on it.
inline bool is_blank(std::span<const std::uint64_t> row) {
  std::uint64_t any = 0;
  for (const std::uint64_t word : row) any |= word;
  return any == 0;
}

/// A view of `rows` rows of `columns` pixels. Pixel (column, row) is bit column % 64 of word
/// row * stride() + column / 64. Bits past the last column are always zero.
template <class Word>
class BasicBitImage {
 public:
  BasicBitImage() = default;
  /// @param words  words_needed(columns, rows) words, owned by the caller
  BasicBitImage(std::span<Word> words, std::uint32_t columns, std::uint32_t rows)
      : words_(words), columns_(columns), rows_(rows), stride_((columns + 63) / 64) {}
  template <class Other>
  BasicBitImage(const BasicBitImage<Other>& other)  // NOLINT(google-explicit-constructor): to a const view
      : words_(other.words()), columns_(other.columns()), rows_(other.rows()), stride_(other.stride()) {}

  static constexpr std::size_t words_needed(std::uint32_t columns, std::uint32_t rows) {
    return std::size_t{(columns + 63) / 64} * rows;
  }

  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  std::uint32_t stride() const { return stride_; }  ///< words a row
  std::span<Word> words() const { return words_; }
  std::span<Word> row(std::uint32_t r) const { return words_.subspan(std::size_t{r} * stride_, stride_); }

  bool at(std::uint32_t column, std::uint32_t row) const {
    return (words_[std::size_t{row} * stride_ + column / 64] >> (column % 64)) & 1U;
  }
  void set(std::uint32_t column, std::uint32_t row) const {
    words_[std::size_t{row} * stride_ + column / 64] |= std::uint64_t{1} << (column % 64);
  }
  /// Writes to no page that is blank already: on fresh memory these take no room. Most of a panel stays blank.
  void clear() const {
    constexpr std::size_t kBlock = 512;  // words: a page
    for (std::size_t at = 0; at < words_.size(); at += kBlock) {
      const auto block = words_.subspan(at, std::min(kBlock, words_.size() - at));
      if (!is_blank(block)) std::ranges::fill(block, Word{0});
    }
  }
  std::uint64_t count() const {
    std::uint64_t sum = 0;
    for (const auto word : words_) sum += count_ones(word);
    return sum;
  }
  /// Ones for the valid pixels of a row's last word.
  std::uint64_t last_word_mask() const {
    return columns_ % 64 == 0 ? ~std::uint64_t{0} : (std::uint64_t{1} << (columns_ % 64)) - 1;
  }

 private:
  std::span<Word> words_;
  std::uint32_t columns_ = 0;
  std::uint32_t rows_ = 0;
  std::uint32_t stride_ = 0;
};
using BitImage = BasicBitImage<std::uint64_t>;
using ConstBitImage = BasicBitImage<const std::uint64_t>;

}  // namespace plumbline::inline slicer
