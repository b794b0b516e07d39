#include "hal/linux/display/pack_pixels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace plumbline {
namespace {

using Picture = std::vector<std::vector<bool>>;  // rows from the top

/// Rotates by quarter turns counter-clockwise, by definition: the right edge becomes the top.
Picture turned(const Picture& picture, std::uint32_t degrees) {
  if (degrees == 0) return picture;
  const std::size_t rows = picture.size();
  const std::size_t columns = picture[0].size();
  Picture out(columns, std::vector<bool>(rows));
  for (std::size_t r = 0; r < columns; ++r) {
    for (std::size_t c = 0; c < rows; ++c) out[r][c] = picture[c][columns - 1 - r];
  }
  return turned(out, degrees - 90);
}

Picture turned_over(Picture picture, PanelLayout::Mirror mirror) {
  if (mirror == PanelLayout::Mirror::kY) std::reverse(picture.begin(), picture.end());
  if (mirror == PanelLayout::Mirror::kX) {
    for (auto& row : picture) std::reverse(row.begin(), row.end());
  }
  return picture;
}

std::uint32_t pixel(const Picture& picture, std::size_t r, std::size_t c, bool rgb) {
  if (!rgb) return picture[r][c] ? 0xFFFFFF : 0;
  return (picture[r][3 * c] ? 0xFF0000U : 0U) | (picture[r][3 * c + 1] ? 0x00FF00U : 0U) |
         (picture[r][3 * c + 2] ? 0x0000FFU : 0U);
}

TEST(PanelLayout, SaysWhereAPixelIsSent) {
  for (const std::uint32_t degrees : {0U, 90U, 180U, 270U}) {
    for (const auto mirror : {PanelLayout::Mirror::kNone, PanelLayout::Mirror::kX, PanelLayout::Mirror::kY}) {
      const PanelLayout layout{5, 3, degrees, mirror, false};
      for (std::uint32_t r = 0; r < 3; ++r) {
        for (std::uint32_t c = 0; c < 5; ++c) {
          Picture picture(3, std::vector<bool>(5));
          picture[r][c] = true;
          const auto [column, row] = layout.sent({c, r});
          EXPECT_TRUE(turned_over(turned(picture, degrees), mirror)[row][column])
              << degrees << " degrees, mirror " << static_cast<int>(mirror) << ", pixel " << c << ", " << r;
        }
      }
    }
  }
}

TEST(PanelLayout, PacksEveryPixelWhereRotationMirrorAndPackingPutIt) {
  std::mt19937 random(4);
  int layouts = 0;
  for (const auto& [columns, rows] : {std::pair{195U, 66U}, {63U, 129U}, {3U, 3U}, {192U, 192U}}) {
    std::vector<std::uint64_t> words(BitImage::words_needed(columns, rows));
    const BitImage mask(words, columns, rows);
    Picture picture(rows, std::vector<bool>(columns));
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        picture[r][c] = (random() & 1U) != 0;
        if (picture[r][c]) mask.set(c, r);
      }
    }
    for (const std::uint32_t degrees : {0U, 90U, 180U, 270U}) {
      for (const auto mirror : {PanelLayout::Mirror::kNone, PanelLayout::Mirror::kX, PanelLayout::Mirror::kY}) {
        for (const bool rgb : {false, true}) {
          const PanelLayout layout{columns, rows, degrees, mirror, rgb};
          ASSERT_TRUE(layout.check());
          const Picture expected = turned_over(turned(picture, degrees), mirror);
          ASSERT_EQ(layout.mode_height(), expected.size());
          ASSERT_EQ(layout.mode_width(), expected[0].size() / (rgb ? 3 : 1));
          const std::size_t pitch = layout.mode_width() + 5;
          std::vector<std::uint32_t> pixels(pitch * layout.mode_height(), 0xDEADBEEF);
          pack_pixels(layout, mask, pixels, pitch);
          for (std::size_t r = 0; r < layout.mode_height(); ++r) {
            for (std::size_t c = 0; c < pitch; ++c) {
              const auto want = c < layout.mode_width() ? pixel(expected, r, c, rgb) : 0;
              ASSERT_EQ(pixels[r * pitch + c], want)
                  << columns << "x" << rows << ", " << degrees << " degrees, mirror " << static_cast<int>(mirror)
                  << ", rgb " << rgb << ", row " << r << ", column " << c;
            }
          }
          ++layouts;
        }
      }
    }
  }
  EXPECT_EQ(layouts, 4 * 4 * 3 * 2);
}

TEST(PanelLayout, PacksGreyPixelsOverThem) {
  std::mt19937 random(9);
  constexpr std::uint32_t kColumns = 66, kRows = 33;
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  const BitImage mask(words, kColumns, kRows);
  std::vector<GreyRun> room(GreyRuns::runs_needed(kColumns, kRows) * 16);
  GreyRuns greys(room, kColumns);
  std::vector<std::uint32_t> levels(std::size_t{kColumns} * kRows);
  for (std::uint32_t i = 0; i < levels.size(); ++i) {
    levels[i] = i > 0 && random() % 3 != 0 ? levels[i - 1] : static_cast<std::uint32_t>(random() % 256);
    if (levels[i] >= kLeastCuringLevel) mask.set(i % kColumns, i / kColumns);
    if (is_grey(levels[i])) greys.add(i, static_cast<std::uint8_t>(levels[i]));
  }
  for (const GreyScale& scale : {GreyScale{256, 1}, GreyScale{16, 2.2}}) {
    const auto values = scale.values();
    for (const std::uint32_t degrees : {0U, 90U, 180U, 270U}) {
      for (const auto mirror : {PanelLayout::Mirror::kNone, PanelLayout::Mirror::kX, PanelLayout::Mirror::kY}) {
        for (const bool rgb : {false, true}) {
          const PanelLayout layout{kColumns, kRows, degrees, mirror, rgb, scale};
          const std::size_t pitch = layout.mode_width() + 5;
          std::vector<std::uint32_t> pixels(pitch * layout.mode_height()), expected(pixels.size());
          for (std::uint32_t i = 0; i < levels.size(); ++i) {
            const auto to = layout.sent({i % kColumns, i / kColumns});
            const std::uint32_t value = values[levels[i]][4 * (i / kColumns % 4) + i % kColumns % 4];
            if (rgb) {
              expected[to.row * pitch + to.column / 3] |= value << (16 - 8 * (to.column % 3));
            } else {
              expected[to.row * pitch + to.column] = value * 0x010101;
            }
          }
          pack_pixels(layout, mask, pixels, pitch);
          pack_greys(layout, greys.runs(), values, pixels, pitch);
          EXPECT_EQ(pixels, expected) << degrees << " degrees, mirror " << static_cast<int>(mirror) << ", rgb " << rgb;
        }
      }
    }
  }
}

TEST(PanelLayout, DimsEveryLitPixelByTheLampsMap) {
  std::mt19937 random(5);
  constexpr std::uint32_t kColumns = 66, kRows = 33;
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  const BitImage mask(words, kColumns, kRows);
  std::vector<GreyRun> greys;
  std::vector<double> levels(std::size_t{kColumns} * kRows);
  for (std::uint32_t i = 0; i < levels.size(); i += 3) {  // in one row: 66 is 3 x 22
    const auto level = std::array<std::uint8_t, 4>{0, 90, 200, 255}[random() % 4];
    std::fill_n(levels.begin() + i, 3, level);
    if (is_grey(level)) greys.push_back({i, 3, level});
    if (level >= kLeastCuringLevel) fill(mask, i / kColumns, i % kColumns, i % kColumns + 3, true);
  }
  LampMap map{.columns = 3, .rows = 2, .light = {3, 3.3, 3.6, 3.1, 3.5, 3.2}};
  LampMap g = map;
  for (double& light : g.light) light = light > 0 ? 3 / light : 0;
  for (const std::uint32_t degrees : {0U, 90U, 180U, 270U}) {
    for (const auto mirror : {PanelLayout::Mirror::kNone, PanelLayout::Mirror::kX, PanelLayout::Mirror::kY}) {
      for (const bool rgb : {false, true}) {
        PanelLayout layout{kColumns, kRows, degrees, mirror, rgb, GreyScale{256, 1}};
        layout.lamp = map;
        const std::size_t pitch = layout.mode_width() + 5;
        const auto values = layout.grey.values();
        std::vector<std::uint32_t> pixels(pitch * layout.mode_height()), even;
        pack_pixels(layout, mask, pixels, pitch);
        even = pixels;
        pack_evenly(layout, mask, greys, LampShares(map, kColumns, kRows), values, pixels, pitch);
        for (std::uint32_t i = 0; i < levels.size(); ++i) {
          const std::uint32_t column = i % kColumns, row = i / kColumns;
          const auto to = layout.sent({column, row});
          const std::uint32_t word = pixels[to.row * pitch + to.column / (rgb ? 3 : 1)];
          const std::uint32_t value = rgb ? word >> (16 - 8 * (to.column % 3)) & 0xFFU : word & 0xFFU;
          const double share = g.at((column + 0.5) / kColumns, (row + 0.5) / kRows) * g.darkest();
          ASSERT_NEAR(value, levels[i] * share, 0.51) << degrees << " degrees, rgb " << rgb << ", pixel " << i;
          ASSERT_TRUE(rgb || word == value * 0x010101U);
        }
        LampMap flat = map;
        std::ranges::fill(flat.light, 2.0);
        std::vector<std::uint32_t> same = even;
        pack_greys(layout, greys, values, even, pitch);
        pack_evenly(layout, mask, greys, LampShares(flat, kColumns, kRows), values, same, pitch);
        EXPECT_EQ(same, even) << "an even lamp";
      }
    }
  }
}

TEST(GreyScale, GivesTheMeanLightThatIsAskedForByTheTwoValuesAroundIt) {
  for (const std::uint32_t levels : {2U, 3U, 4U, 8U, 16U, 64U, 255U, 256U}) {
    for (const double gamma : {0.45, 1.0, 2.2, 5.0}) {
      const GreyScale scale{levels, gamma};
      const auto values = scale.values();
      std::vector<double> lights;
      for (std::uint32_t k = 0; k < levels; ++k) {
        lights.push_back(std::pow(std::round(255.0 * k / (levels - 1)) / 255.0, gamma));
      }
      for (std::uint32_t share = 0; share < 256; ++share) {
        const auto above = std::upper_bound(lights.begin() + 1, lights.end() - 1, share / 255.0);
        double sum = 0;
        for (std::uint32_t pixel = 0; pixel < 256; ++pixel) {
          const double light = std::pow(values[share][4 * (pixel / 16 % 4) + pixel % 4] / 255.0, gamma);
          ASSERT_TRUE(light == *above || light == *(above - 1)) << levels << " " << gamma << " " << share;
          sum += light;
        }
        const double off = std::abs(sum / 256 - share / 255.0);
        ASSERT_LE(off, (*above - *(above - 1)) / 32 + 1e-12) << levels << " " << gamma << " " << share;
        if (gamma < 1) continue;  // the first step of light is a large one
        ASSERT_LE(off, 1.0 / (4 * levels)) << levels << " " << gamma << " " << share;
      }
    }
  }
  const auto plain = GreyScale{256, 1}.values();
  for (std::uint32_t share = 0; share < 256; ++share) {
    for (const std::uint8_t value : plain[share]) EXPECT_EQ(value, share);
  }
}

TEST(PanelLayout, RefusesToPackARotatedWidthThatIsNoMultipleOfThree) {
  EXPECT_TRUE((PanelLayout{1440, 2560, 0, PanelLayout::Mirror::kNone, true}.check()));
  const auto refused = PanelLayout{1440, 2560, 90, PanelLayout::Mirror::kNone, true}.check();
  ASSERT_FALSE(refused);
  EXPECT_NE(std::string(refused.error().message()).find("2560"), std::string::npos);
  EXPECT_TRUE((PanelLayout{1440, 2560, 90, PanelLayout::Mirror::kNone, false}.check()));
}

}  // namespace
}  // namespace plumbline
