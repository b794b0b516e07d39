#include "hal/linux/screen/pack_screen.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace plumbline {
namespace {

/// A picture of which every pixel has a colour of its own.
std::vector<std::uint16_t> picture_of(std::uint32_t columns, std::uint32_t rows) {
  std::vector<std::uint16_t> pixels;
  for (std::uint32_t i = 0; i < columns * rows; ++i) pixels.push_back(static_cast<std::uint16_t>(i * 977 + 5));
  return pixels;
}

std::vector<std::byte> packed(const ScreenLayout& layout, const std::vector<std::uint16_t>& pixels, std::size_t pitch) {
  std::vector<std::byte> out(pitch * layout.sent_rows(), std::byte{0xAA});
  pack_screen(layout, pixels, out, pitch);
  return out;
}

TEST(PackScreen, WidensEachColourToEightBits) {
  const ScreenLayout layout{4, 1, 0, 24};
  const auto out = packed(layout, {0x0000, 0xFFFF, 0xF800, 0x0411}, 16);
  std::array<std::uint32_t, 4> words{};
  std::memcpy(words.data(), out.data(), sizeof words);
  EXPECT_EQ(words[0], 0U);
  EXPECT_EQ(words[1], 0xFFFFFFU);
  EXPECT_EQ(words[2], 0xFF0000U);
  EXPECT_EQ(words[3], 0x00828CU) << "green 32 of 63, blue 17 of 31";
}

// Turned by 90 degrees counter-clockwise, the upper right corner comes to the upper left; four such turns give the picture again.
TEST(PackScreen, TurnsCounterClockwise) {
  constexpr std::uint32_t kColumns = 5, kRows = 3;
  const auto picture = picture_of(kColumns, kRows);
  const auto turned = [](const std::vector<std::uint16_t>& pixels, std::uint32_t columns, std::uint32_t rows,
                         std::uint32_t degrees) {
    const ScreenLayout layout{columns, rows, degrees, 16};
    const std::size_t pitch = 2 * layout.sent_columns() + 6;  // drivers round rows up
    const auto out = packed(layout, pixels, pitch);
    std::vector<std::uint16_t> sent(pixels.size());
    for (std::uint32_t r = 0; r < layout.sent_rows(); ++r) {
      std::memcpy(sent.data() + r * layout.sent_columns(), out.data() + r * pitch, 2 * layout.sent_columns());
      EXPECT_EQ(out[r * pitch + 2 * layout.sent_columns()], std::byte{0xAA}) << "behind the row";
    }
    return sent;
  };
  const auto once = turned(picture, kColumns, kRows, 90);
  EXPECT_EQ(once[0], picture[kColumns - 1]);
  const auto twice = turned(once, kRows, kColumns, 90);
  EXPECT_EQ(twice, turned(picture, kColumns, kRows, 180));
  const auto thrice = turned(twice, kColumns, kRows, 90);
  EXPECT_EQ(thrice, turned(picture, kColumns, kRows, 270));
  EXPECT_EQ(turned(thrice, kRows, kColumns, 90), picture);
  EXPECT_EQ(turned(picture, kColumns, kRows, 0), picture);
}

}  // namespace
}  // namespace plumbline
