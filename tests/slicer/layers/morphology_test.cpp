#include "slicer/layers/morphology.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

Pixels random_pixels(std::uint32_t columns, std::uint32_t rows, double white, Random& random) {
  Pixels pixels(columns, rows);
  for (std::uint32_t r = 0; r < rows; ++r) {
    for (std::uint32_t c = 0; c < columns; ++c) pixels.set(c, r, random.uniform() < white);
  }
  return pixels;
}

Pixels opened_and_closed(const Pixels& in) {
  OwnedImage out(in.columns(), in.rows());
  const OwnedImage image = in.image();
  for (std::uint32_t s = 0; s < 2 * image.view().stride(); ++s) {
    open_and_close_rows(image.view(), out.view(), s, 0, in.rows());
  }
  EXPECT_TRUE(out.clear_past_the_last_column());
  return Pixels(out.view());
}

class MorphologyOfSize : public ::testing::TestWithParam<std::tuple<std::uint32_t, std::uint32_t>> {};
INSTANTIATE_TEST_SUITE_P(Sizes, MorphologyOfSize,
                         ::testing::Combine(::testing::Values(1, 2, 63, 64, 65, 127, 128, 129, 200),
                                            ::testing::Values(1, 2, 3, 40)),
                         [](const auto& size) {
                           return std::to_string(std::get<0>(size.param)) + "x" +
                                  std::to_string(std::get<1>(size.param));
                         });

TEST_P(MorphologyOfSize, EqualsTheDefinitionPixelByPixelOnRandomImages) {
  const auto [columns, rows] = GetParam();
  Random random(columns * 1000 + rows);
  for (const double white : {0.1, 0.5, 0.7, 0.9, 1.0}) {
    const Pixels in = random_pixels(columns, rows, white, random);
    EXPECT_EQ(opened_and_closed(in), opened_and_closed_by_definition(in)) << white;
  }
}

TEST_P(MorphologyOfSize, ChangesNothingTheSecondTime) {
  const auto [columns, rows] = GetParam();
  Random random(columns * 2000 + rows);
  for (const double white : {0.5, 0.7, 0.85}) {
    const Pixels once = opened_and_closed(random_pixels(columns, rows, white, random));
    EXPECT_EQ(opened_and_closed(once), once);
  }
}

TEST(Morphology, GivesTheSameForSomeRowsOfAStripAsForTheImage) {
  Random random(5);
  const Pixels in = random_pixels(300, 20, 0.7, random);
  const Pixels whole = opened_and_closed(in);
  const OwnedImage image = in.image();
  for (const std::uint32_t rows : {1U, 2U, 3U, 7U, 20U}) {
    OwnedImage out(300, 20);
    for (std::uint32_t strip = 0; strip < 2 * out.view().stride(); ++strip) {
      for (std::uint32_t row = 0; row < 20; row += rows) {
        open_and_close_rows(image.view(), out.view(), strip, row, std::min(20U, row + rows));
      }
    }
    EXPECT_EQ(Pixels(out.view()), whole) << rows << " rows at a time";
  }
}

TEST(Morphology, RemovesSinglePixelsAndLinesOfOnePixel) {
  Pixels in(130, 20);
  in.set(3, 3, true);
  for (std::uint32_t c = 0; c < 130; ++c) in.set(c, 10, true);
  for (std::uint32_t r = 0; r < 20; ++r) in.set(64, r, true);
  in.set(100, 15, true);
  in.set(101, 16, true);
  EXPECT_EQ(opened_and_closed(in), Pixels(130, 20));
}

TEST(Morphology, FillsSingleHolesAndSlitsOfOnePixel) {
  Pixels full(130, 20);
  for (std::uint32_t r = 2; r < 18; ++r) {
    for (std::uint32_t c = 2; c < 128; ++c) full.set(c, r, true);
  }
  Pixels in = full;
  in.set(30, 8, false);
  for (std::uint32_t r = 5; r < 15; ++r) in.set(64, r, false);
  for (std::uint32_t c = 70; c < 90; ++c) in.set(c, 10, false);
  EXPECT_EQ(opened_and_closed(in), full);
}

TEST(Morphology, KeepsEveryPixelOfLinesThreeWideInAllDirections) {
  for (const int direction : {0, 45, 90, 135}) {
    for (int at = 0; at < 70; ++at) {
      Pixels in(70, 70);
      for (std::uint32_t r = 0; r < 70; ++r) {
        for (std::uint32_t c = 0; c < 70; ++c) {
          const int x = static_cast<int>(c);
          const int y = static_cast<int>(r);
          const int across = direction == 0 ? y : direction == 90 ? x : direction == 45 ? x - y + 35 : x + y - 35;
          in.set(c, r, across >= at && across < at + 3);
        }
      }
      // A diagonal that only cuts off a corner of the image is not three pixels wide there.
      if (direction % 90 == 45 && (at < 5 || at > 62)) continue;
      if (direction % 90 == 0 && at > 67) continue;
      const Pixels out = opened_and_closed(in);
      std::uint32_t lost = 0;
      for (std::uint32_t r = 2; r < 68; ++r) {
        for (std::uint32_t c = 2; c < 68; ++c) lost += in.at(c, r) && !out.at(c, r) ? 1 : 0;
      }
      EXPECT_EQ(lost, 0U) << direction << " degrees at " << at;
    }
  }
}

TEST(Morphology, RemovesNoPixelFromUnionsOfThreeByThreeSquares) {
  Random random(6);
  for (int round = 0; round < 50; ++round) {
    Pixels in(129, 50);
    for (std::uint32_t square = 0; square < 10 + 10U * static_cast<std::uint32_t>(round); ++square) {
      const std::uint32_t c = random.below(127);
      const std::uint32_t r = random.below(48);
      for (std::uint32_t i = 0; i < 9; ++i) in.set(c + i % 3, r + i / 3, true);
    }
    const Pixels out = opened_and_closed(in);
    for (std::uint32_t r = 0; r < 50; ++r) {
      for (std::uint32_t c = 0; c < 129; ++c) ASSERT_TRUE(!in.at(c, r) || out.at(c, r)) << c << ", " << r;
    }
  }
}

TEST(Morphology, FillsNoPixelOfHolesThatAreUnionsOfThreeByThreeSquares) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    Pixels in(129, 50);
    for (std::uint32_t r = 0; r < 50; ++r) {
      for (std::uint32_t c = 0; c < 129; ++c) in.set(c, r, true);
    }
    for (std::uint32_t square = 0; square < 10 + 10U * static_cast<std::uint32_t>(round); ++square) {
      const std::uint32_t c = random.below(127);
      const std::uint32_t r = random.below(48);
      for (std::uint32_t i = 0; i < 9; ++i) in.set(c + i % 3, r + i / 3, false);
    }
    const Pixels out = opened_and_closed(in);
    for (std::uint32_t r = 0; r < 50; ++r) {
      for (std::uint32_t c = 0; c < 129; ++c) ASSERT_TRUE(in.at(c, r) || !out.at(c, r)) << c << ", " << r;
    }
  }
}

}  // namespace
}  // namespace plumbline
