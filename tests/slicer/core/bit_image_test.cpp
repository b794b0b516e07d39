#include "slicer/core/bit_image.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <bitset>
#include <vector>

namespace plumbline {
namespace {

TEST(BitImage, StoresEachPixelInItsOwnBit) {
  for (const std::uint32_t columns : {1U, 63U, 64U, 65U, 129U}) {
    constexpr std::uint32_t kRows = 5;
    std::vector<std::uint64_t> words(BitImage::words_needed(columns, kRows), 0);
    const BitImage image(words, columns, kRows);
    EXPECT_EQ(words.size(), std::size_t{(columns + 63) / 64} * kRows);
    std::uint64_t set = 0;
    for (std::uint32_t r = 0; r < kRows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        ASSERT_FALSE(image.at(c, r));
        image.set(c, r);
        ASSERT_TRUE(image.at(c, r));
        ASSERT_EQ(image.count(), ++set);
      }
    }
    image.clear();
    EXPECT_EQ(image.count(), 0U);
  }
}

TEST(BitImage, ClearWritesToNoBlankPage) {
  constexpr std::uint32_t kRows = 4096;
  const std::size_t size = BitImage::words_needed(64, kRows) * sizeof(std::uint64_t);
  void* const memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  BitImage({static_cast<std::uint64_t*>(memory), kRows}, 64, kRows).clear();  // a write would end the program
  ASSERT_EQ(::munmap(memory, size), 0);
}

TEST(BitImage, ClearBlackensEveryPixel) {
  for (const std::uint32_t rows : {1U, 511U, 512U, 513U, 1100U}) {
    std::vector<std::uint64_t> words(rows);
    const BitImage image(words, 64, rows);
    for (const std::uint32_t row : {0U, rows / 2, rows - 1}) {
      image.set(63, row);
      image.clear();
      EXPECT_EQ(image.count(), 0U) << row << " of " << rows;
    }
  }
}

TEST(BitImage, StoresPixelsInTheDocumentedOrder) {
  std::vector<std::uint64_t> words(BitImage::words_needed(130, 3), 0);
  const BitImage image(words, 130, 3);
  image.set(70, 2);
  EXPECT_EQ(image.stride(), 3U);
  EXPECT_EQ(words[2 * 3 + 1], std::uint64_t{1} << 6);
  EXPECT_EQ(image.row(2)[1], words[7]);
  const ConstBitImage view = image;
  EXPECT_TRUE(view.at(70, 2));
}

TEST(BitImage, LastWordMaskHasOneBitForEachOfItsPixels) {
  for (std::uint32_t columns = 1; columns <= 200; ++columns) {
    const BitImage image({}, columns, 0);
    const std::uint64_t mask = image.last_word_mask();
    const std::uint32_t wanted = (columns - 1) % 64 + 1;
    EXPECT_EQ(std::bitset<64>(mask).count(), wanted);
    EXPECT_EQ(mask & 1U, 1U);
    EXPECT_TRUE(wanted == 64 || mask >> wanted == 0);
  }
}

}  // namespace
}  // namespace plumbline
