#include "firmware/pictures/mask_deflate.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <vector>

#include "tests/slicer/support/pixels.hpp"

namespace plumbline {
namespace mask_deflate_test {

using testing::OwnedImage;

std::vector<std::uint8_t> deflated(const OwnedImage& mask, MaskDepth depth = MaskDepth::kBit) {
  std::vector<std::uint8_t> stream(deflated_mask_bound(mask.view().columns(), mask.view().rows(), depth));
  stream.resize(deflate_mask(mask.view(), depth, stream));
  return stream;
}

/// The lines as zlib inflates them, without their filters (PNG, 9.2); empty if zlib refuses the stream, its sum, or its length.
std::vector<std::uint8_t> inflated(const std::vector<std::uint8_t>& stream, std::uint32_t columns, std::uint32_t rows,
                                   MaskDepth depth) {
  const std::size_t width = 1 + line_bytes(columns, depth);
  std::vector<std::uint8_t> lines(width * rows + 1);
  auto size = static_cast<uLongf>(lines.size());
  auto read = static_cast<uLong>(stream.size());
  if (uncompress2(lines.data(), &size, stream.data(), &read) != Z_OK || size + 1 != lines.size() ||
      read != stream.size()) {
    return {};
  }
  for (std::size_t at = 0; at < size; at += width) {
    if (lines[at] != 0 && lines[at] != 2) return {};
    for (std::size_t i = 1; lines[at] == 2 && at > 0 && i < width; ++i) {
      lines[at + i] = static_cast<std::uint8_t>(lines[at + i] + lines[at + i - width]);
    }
    lines[at] = 0;
  }
  lines.pop_back();
  return lines;
}

std::vector<std::uint8_t> lines_of(const OwnedImage& mask, MaskDepth depth) {
  const std::size_t width = 1 + line_bytes(mask.view().columns(), depth);
  std::vector<std::uint8_t> lines(width * mask.view().rows());
  for (std::uint32_t r = 0; r < mask.view().rows(); ++r) {
    for (std::uint32_t c = 0; c < mask.view().columns(); ++c) {
      if (!mask.view().at(c, r)) continue;
      if (depth == MaskDepth::kByte) {
        lines[r * width + 1 + c] = 255;
      } else {
        lines[r * width + 1 + c / 8] |= static_cast<std::uint8_t>(0x80U >> (c % 8));
      }
    }
  }
  return lines;
}

void expect_round_trip(const OwnedImage& mask) {
  for (const MaskDepth depth : {MaskDepth::kBit, MaskDepth::kByte}) {
    const auto stream = deflated(mask, depth);
    EXPECT_EQ(inflated(stream, mask.view().columns(), mask.view().rows(), depth), lines_of(mask, depth));
  }
}

TEST(MaskDeflate, InflatesToTheSameLinesForEveryByteAndEveryLengthOfARun) {
  // Line r holds byte r, then bytes of 1 that are r % 600 blank bytes apart.
  OwnedImage mask(8 * 1400, 700);
  for (std::uint32_t r = 0; r < mask.view().rows(); ++r) {
    for (std::uint32_t bit = 0; bit < 8; ++bit) {
      if ((r >> bit & 1U) != 0) mask.view().set(7 - bit, r);
    }
    const std::uint32_t step = 1 + (r * 7) % 600;
    for (std::uint32_t byte = step; byte < 1400; byte += step) mask.view().set(8 * byte + 7, r);
  }
  expect_round_trip(mask);
}

TEST(MaskDeflate, InflatesToTheSameLinesWhateverTheMask) {
  std::mt19937_64 dice(11);
  for (int shape = 0; shape < 300; ++shape) {
    OwnedImage mask(1 + static_cast<std::uint32_t>(dice() % 400), 1 + static_cast<std::uint32_t>(dice() % 40));
    const auto noise = static_cast<std::uint32_t>(dice() % 64);
    const auto blank = dice() % 3;
    for (std::uint32_t r = 0; r < mask.view().rows(); ++r) {
      if (dice() % 3 < blank) continue;
      for (auto& word : mask.view().row(r)) word = noise == 0 ? ~std::uint64_t{0} : dice() << noise & dice();
      mask.view().row(r).back() &= mask.view().last_word_mask();
    }
    expect_round_trip(mask);
  }
}

TEST(MaskDeflate, WritesNoMoreThanItsBound) {
  OwnedImage mask(1440, 64);
  // Each byte differs from the one above by a number with the longest code.
  for (std::uint32_t r = 0; r < 64; ++r) {
    for (auto& word : mask.view().row(r)) word = 0x9292929292929292U * (r % 2);
    mask.view().row(r).back() &= mask.view().last_word_mask();
  }
  EXPECT_LE(deflated(mask).size(), deflated_mask_bound(1440, 64, MaskDepth::kBit));
  expect_round_trip(mask);
}

TEST(MaskDeflate, SpendsNextToNothingOnBlankLinesAndTwoBytesOnALineLikeTheOneAbove) {
  OwnedImage mask(1440, 2560);
  EXPECT_LT(deflated(mask).size(), 600U);
  for (std::uint32_t r = 1000; r < 1500; ++r) {
    for (std::uint32_t c = 500; c < 900; ++c) mask.view().set(c, r);
  }
  EXPECT_LT(deflated(mask).size(), 600U + 500U * 9 / 4 + 50U);
}

}  // namespace mask_deflate_test
}  // namespace plumbline
