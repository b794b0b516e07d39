#include "firmware/pictures/mask_decoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lodepng.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "firmware/pictures/png.hpp"
#include "tests/firmware/pictures/noise_png.hpp"

namespace plumbline::firmware {
namespace mask_decoder_test {

using ::testing::HasSubstr;

constexpr std::uint32_t kColumns = 131, kRows = 37;

/// An image of any size with the memory that it is in.
struct Mask {
  Mask(std::uint32_t columns, std::uint32_t rows)
      : words(BitImage::words_needed(columns, rows), ~std::uint64_t{0}), image(words, columns, rows) {}
  std::vector<std::uint64_t> words;
  BitImage image;
};

std::vector<unsigned char> noise(LodePNGColorType colour, unsigned depth, std::uint32_t columns = kColumns,
                                 std::uint32_t rows = kRows, bool interlaced = false) {
  return testing::NoisePng(colour, depth, columns, rows, interlaced).file;
}

/// @param step  bytes handed out at once
Status decode(std::span<const unsigned char> file, const MaskTurn& turn, BitImage out, std::size_t step = 1000,
              std::uint64_t most = UINT64_MAX, GreyShare* grey = nullptr, GreyRuns* greys = nullptr) {
  std::size_t at = 0;
  const auto bytes = [&](std::span<std::byte> to) -> Expected<std::size_t> {
    const std::size_t count = std::min({step, to.size(), file.size() - at});
    std::memcpy(to.data(), file.data() + at, count);
    at += count;
    return count;
  };
  return decode_turned_mask(bytes, most, turn, out, grey, greys);
}

TEST(MaskDecoder, AgreesWithLodepngOnEveryKindOfPng) {
  for (const auto colour : {LCT_GREY, LCT_GREY_ALPHA, LCT_PALETTE, LCT_RGB, LCT_RGBA}) {
    for (const unsigned depth : {1U, 2U, 4U, 8U, 16U}) {
      const bool few = colour == LCT_GREY || colour == LCT_PALETTE;
      if ((depth < 8 && !few) || (depth == 16 && colour == LCT_PALETTE)) continue;
      for (const std::uint32_t columns : {kColumns, 3U, 1U}) {
        for (const bool interlaced : {false, true}) {
          const std::uint32_t rows = columns == 1 ? 2 : kRows;
          const testing::NoisePng png(colour, depth, columns, rows, interlaced);
          Mask ours(columns, rows), theirs(columns, rows);
          theirs.image.clear();
          GreyShare grey;
          for (std::uint32_t i = 0; i < columns * rows; ++i) {
            const unsigned char* const at = &png.rgba[std::size_t{4} * i];
            const int level = (299 * at[0] + 587 * at[1] + 114 * at[2]) * at[3];
            const bool shows = level >= 128'000 * 255;
            if (shows) theirs.image.set(i % columns, i / columns);
            grey.lit += level > 0 ? 1 : 0;
            grey.grey += level > 0 && level < 255'000 * 255 ? 1 : 0;
            grey.lost += level > 0 && !shows ? 1 : 0;
          }
          for (const std::size_t step : {1U, 7U, 100'000U}) {
            GreyShare counted;
            const auto done = decode(png.file, {}, ours.image, step, UINT64_MAX, &counted);
            ASSERT_TRUE(done) << done.error().message();
            EXPECT_EQ(counted, grey) << "colour " << colour << ", depth " << depth << ", " << columns << " columns";
            ASSERT_EQ(ours.words, theirs.words) << "colour " << colour << ", depth " << depth << ", " << columns
                                                << " columns" << (interlaced ? ", interlaced" : "");
          }
        }
      }
    }
  }
}

TEST(MaskDecoder, LaysEveryPixelWhereTheTurnSays) {
  const auto file = noise(LCT_GREY, 8);
  Mask plain(kColumns, kRows);
  ASSERT_TRUE(decode(file, {}, plain.image));
  for (const unsigned bits : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
    const MaskTurn turn{(bits & 1U) != 0, (bits & 2U) != 0, (bits & 4U) != 0};
    Mask turned(turn.swaps ? kRows : kColumns, turn.swaps ? kColumns : kRows);
    ASSERT_TRUE(decode(file, turn, turned.image));
    for (std::uint32_t row = 0; row < kRows; ++row) {
      for (std::uint32_t column = 0; column < kColumns; ++column) {
        const std::uint32_t x = turn.mirror_x ? kColumns - 1 - column : column;
        const std::uint32_t y = turn.mirror_y ? kRows - 1 - row : row;
        ASSERT_EQ(plain.image.at(column, row), turn.swaps ? turned.image.at(y, x) : turned.image.at(x, y)) << bits;
      }
    }
    EXPECT_EQ(turned.image.count(), plain.image.count()) << "no pixel outside the image";
  }
}

/// The level of each pixel, from bits and greys.
std::vector<int> levels_of(const Mask& mask, const GreyRuns& greys) {
  std::vector<int> levels;
  for (std::uint32_t row = 0; row < mask.image.rows(); ++row) {
    for (std::uint32_t column = 0; column < mask.image.columns(); ++column) {
      levels.push_back(mask.image.at(column, row) ? 255 : 0);
    }
  }
  std::uint32_t end = 0;
  for (const GreyRun& run : greys.runs()) {
    EXPECT_TRUE(run.count > 0 && is_grey(run.level) && run.pixel >= end);
    EXPECT_EQ(run.pixel / mask.image.columns(), (run.end() - 1) / mask.image.columns()) << "of one row";
    end = run.end();
    for (std::uint32_t pixel = run.pixel; pixel < end; ++pixel) {
      EXPECT_EQ(levels[pixel], run.level >= kLeastCuringLevel ? 255 : 0) << "the bit below a grey pixel";
      levels[pixel] = run.level;
    }
  }
  return levels;
}

TEST(MaskDecoder, KeepsGreyPixelsOfEveryKindOfPngWhereTheTurnSays) {
  for (const auto colour : {LCT_GREY, LCT_GREY_ALPHA, LCT_PALETTE, LCT_RGB, LCT_RGBA}) {
    for (const unsigned depth : {1U, 2U, 4U, 8U, 16U}) {
      const bool few = colour == LCT_GREY || colour == LCT_PALETTE;
      if ((depth < 8 && !few) || (depth == 16 && colour == LCT_PALETTE)) continue;
      for (const bool interlaced : {false, true}) {
        const testing::NoisePng png(colour, depth, kColumns, kRows, interlaced);
        for (const unsigned bits : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
          const MaskTurn turn{(bits & 1U) != 0, (bits & 2U) != 0, (bits & 4U) != 0};
          Mask mask(turn.swaps ? kRows : kColumns, turn.swaps ? kColumns : kRows);
          std::vector<GreyRun> room(kColumns * kRows);
          GreyRuns greys(room, mask.image.columns());
          ASSERT_TRUE(decode(png.file, turn, mask.image, 1000, UINT64_MAX, nullptr, &greys));
          std::vector<int> expected(kColumns * kRows);
          for (std::uint32_t i = 0; i < kColumns * kRows; ++i) {
            const std::uint32_t column = i % kColumns, row = i / kColumns;
            const std::uint32_t x = turn.mirror_x ? kColumns - 1 - column : column;
            const std::uint32_t y = turn.mirror_y ? kRows - 1 - row : row;
            const unsigned char* const at = &png.rgba[std::size_t{4} * i];
            expected[turn.swaps ? x * kRows + y : y * kColumns + x] =
                (299 * at[0] + 587 * at[1] + 114 * at[2]) * at[3] / 255'000;
          }
          ASSERT_EQ(levels_of(mask, greys), expected)
              << "colour " << colour << ", depth " << depth << ", turn " << bits << (interlaced ? ", interlaced" : "");
        }
      }
    }
  }
}

TEST(MaskDecoder, DecodesTheSameBitsIfThereIsNoRoomForGrey) {
  const auto file = noise(LCT_GREY, 8);
  Mask plain(kColumns, kRows), some(kColumns, kRows);
  ASSERT_TRUE(decode(file, {}, plain.image));
  for (const std::size_t runs : {0U, 1U, 100U}) {
    std::vector<GreyRun> room(runs);
    GreyRuns greys(room, kColumns);
    greys.add(3, 3);  // of a layer before
    ASSERT_TRUE(decode(file, {}, some.image, 1000, UINT64_MAX, nullptr, &greys));
    EXPECT_EQ(some.words, plain.words);
    EXPECT_EQ(greys.runs().size(), runs);
    EXPECT_EQ(greys.lost() > 0, runs > 0);
    levels_of(some, greys);
  }
}

TEST(MaskDecoder, CountsWhatIsGreyAndWhatOfItIsLost) {
  // A row of 131 pixels: 40 black, 60 white, 20 of 127 and 11 of 128.
  std::vector<unsigned char> pixels;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (const auto& [count, level] : {std::pair{40, 0}, std::pair{60, 255}, std::pair{20, 127}, std::pair{11, 128}}) {
      pixels.insert(pixels.end(), static_cast<std::size_t>(count), static_cast<unsigned char>(level));
    }
  }
  std::vector<unsigned char> file;
  ASSERT_EQ(lodepng::encode(file, pixels, kColumns, kRows, LCT_GREY, 8), 0U);
  Mask mask(kColumns, kRows);
  GreyShare grey;
  for (const std::uint64_t layers : {1U, 2U}) {  // the layers of a print are summed
    ASSERT_TRUE(decode(file, {}, mask.image, 1000, UINT64_MAX, &grey));
    EXPECT_EQ(grey, (GreyShare{91 * kRows * layers, 31 * kRows * layers, 20 * kRows * layers}));
    EXPECT_EQ(mask.image.count(), 71U * kRows);
  }
  EXPECT_DOUBLE_EQ(grey.share(), 31.0 / 91);
  EXPECT_EQ(GreyShare{}.share(), 0);
}

TEST(MaskDecoder, TurnsByAQuarterWithoutMirroring) {
  const auto file = noise(LCT_GREY, 8);
  for (const unsigned bits : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
    const MaskTurn turn{(bits & 1U) != 0, (bits & 2U) != 0, (bits & 4U) != 0};
    const std::uint32_t columns = turn.swaps ? kRows : kColumns, rows = turn.swaps ? kColumns : kRows;
    Mask before(columns, rows), after(rows, columns);
    ASSERT_TRUE(decode(file, turn, before.image));
    ASSERT_TRUE(decode(file, turn.quarter(), after.image));
    for (std::uint32_t y = 0; y < rows; ++y) {
      for (std::uint32_t x = 0; x < columns; ++x) {
        ASSERT_EQ(before.image.at(x, y), after.image.at(rows - 1 - y, x)) << bits;
      }
    }
    EXPECT_EQ(turn.quarter().quarter().quarter().quarter(), turn);
  }
}

TEST(MaskDecoder, RefusesWhatIsNoMask) {
  Mask mask(kColumns, kRows);
  const auto grey = noise(LCT_GREY, 8);
  EXPECT_THAT(decode(noise(LCT_GREY, 8, 40, 30), {}, mask.image).error().message(),
              HasSubstr("has 40 x 30 pixels, the first layer 131 x 37"));
  EXPECT_THAT(decode(grey, {}, mask.image, 1000, 200).error().message(), HasSubstr("is longer than a mask can be"));
  const auto interlaced = noise(LCT_PALETTE, 4, kColumns, kRows, true);
  for (const auto& file : {grey, interlaced}) {
    for (std::size_t size = 0; size + 12 < file.size(); size += 97) {
      EXPECT_FALSE(decode(std::span(file).first(size), {}, mask.image)) << size;
    }
  }
  for (std::size_t at = 60; at < grey.size() - 16; at += 211) {
    auto damaged = grey;
    damaged[at] ^= 4;
    EXPECT_FALSE(decode(damaged, {}, mask.image)) << at;
  }
}

TEST(MaskDecoder, PassesOnTheErrorOfItsBytes) {
  Mask mask(kColumns, kRows);
  const auto fails = [](std::span<std::byte>) -> Expected<std::size_t> {
    return fail(ErrorCode::kCannotRead, "bad sector");
  };
  const auto done = decode_turned_mask(fails, 1000, {}, mask.image);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code(), ErrorCode::kCannotRead);
}

}  // namespace mask_decoder_test
}  // namespace plumbline::firmware
