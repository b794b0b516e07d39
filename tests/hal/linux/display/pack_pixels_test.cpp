#include "hal/linux/display/pack_pixels.hpp"

#include <gtest/gtest.h>

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

TEST(PanelLayout, RefusesToPackARotatedWidthThatIsNoMultipleOfThree) {
  EXPECT_TRUE((PanelLayout{1440, 2560, 0, PanelLayout::Mirror::kNone, true}.check()));
  const auto refused = PanelLayout{1440, 2560, 90, PanelLayout::Mirror::kNone, true}.check();
  ASSERT_FALSE(refused);
  EXPECT_NE(std::string(refused.error().message()).find("2560"), std::string::npos);
  EXPECT_TRUE((PanelLayout{1440, 2560, 90, PanelLayout::Mirror::kNone, false}.check()));
}

}  // namespace
}  // namespace plumbline
