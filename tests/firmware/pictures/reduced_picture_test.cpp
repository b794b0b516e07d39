#include "firmware/pictures/reduced_picture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "tests/firmware/pictures/noise_png.hpp"

namespace plumbline::firmware {
namespace reduced_picture_test {

using ::testing::HasSubstr;
using testing::NoisePng;

Status reduce(std::span<const unsigned char> file, std::span<std::uint8_t> rgb, const PngSize& size) {
  std::size_t at = 0;
  const auto bytes = [&](std::span<std::byte> to) -> Expected<std::size_t> {
    const std::size_t count = std::min<std::size_t>({777, to.size(), file.size() - at});
    std::memcpy(to.data(), file.data() + at, count);
    at += count;
    return count;
  };
  return decode_reduced(bytes, rgb, size);
}

TEST(ReducedPicture, IsTheMeanOfThePixelsOfAnyFormat) {
  constexpr std::uint32_t kSide = 8, kTimes = 5;
  for (const auto& [colour, depth] :
       {std::pair{LCT_GREY, 1U}, std::pair{LCT_GREY, 16U}, std::pair{LCT_GREY_ALPHA, 8U}, std::pair{LCT_RGB, 8U},
        std::pair{LCT_RGB, 16U}, std::pair{LCT_RGBA, 8U}, std::pair{LCT_RGBA, 16U}, std::pair{LCT_PALETTE, 4U}}) {
    const NoisePng noise(colour, depth, kSide * kTimes, kSide * kTimes);
    std::vector<std::uint8_t> rgb(std::size_t{3} * kSide * kSide, 40);
    const auto done = reduce(noise.file, rgb, {kSide, kSide});
    ASSERT_TRUE(done) << done.error().message();
    for (std::uint32_t y = 0; y < kSide; ++y) {
      for (std::uint32_t x = 0; x < kSide; ++x) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
          double sum = 0;
          for (std::uint32_t i = 0; i < kTimes * kTimes; ++i) {
            const std::size_t pixel = std::size_t{y * kTimes + i / kTimes} * kSide * kTimes + x * kTimes + i % kTimes;
            const double opacity = noise.rgba[4 * pixel + 3] / 255.0;
            sum += opacity * noise.rgba[4 * pixel + channel] + (1 - opacity) * 40;
          }
          EXPECT_NEAR(rgb[3 * (y * kSide + x) + channel], sum / (kTimes * kTimes), 2) << colour << ' ' << depth;
        }
      }
    }
  }
}

TEST(ReducedPicture, IsCentredAndNotEnlarged) {
  const auto white_at = [](std::uint32_t columns, std::uint32_t rows) {
    std::vector<unsigned char> file;
    EXPECT_EQ(
        lodepng::encode(file, std::vector<unsigned char>(std::size_t{columns} * rows, 255), columns, rows, LCT_GREY, 8),
        0U);
    std::vector<std::uint8_t> rgb(3 * 64 * 64);
    EXPECT_TRUE(reduce(file, rgb, {64, 64}));
    std::uint32_t left = 64, right = 0, top = 64, bottom = 0;
    for (std::uint32_t i = 0; i < 64 * 64; ++i) {
      if (rgb[std::size_t{3} * i] == 0) continue;
      left = std::min(left, i % 64), right = std::max(right, i % 64 + 1);
      top = std::min(top, i / 64), bottom = std::max(bottom, i / 64 + 1);
    }
    return std::array{left, right, top, bottom};
  };
  EXPECT_EQ(white_at(400, 400), (std::array{0U, 64U, 0U, 64U}));
  EXPECT_EQ(white_at(800, 480), (std::array{0U, 64U, 13U, 51U}));
  EXPECT_EQ(white_at(65, 100), (std::array{11U, 53U, 0U, 64U}));
  EXPECT_EQ(white_at(10, 20), (std::array{27U, 37U, 22U, 42U}));
  EXPECT_EQ(white_at(4096, 1), (std::array{0U, 64U, 31U, 32U}));
  EXPECT_EQ(white_at(1, 1), (std::array{31U, 32U, 31U, 32U}));
}

TEST(ReducedPicture, RefusesWhatIsDamagedOrTooLarge) {
  std::vector<std::uint8_t> rgb(3 * 64 * 64);
  const NoisePng noise(LCT_RGB, 8, 90, 70);
  ASSERT_TRUE(reduce(noise.file, rgb, {64, 64}));
  for (std::size_t size = 0; size + 12 < noise.file.size(); size += 331) {
    EXPECT_FALSE(reduce(std::span(noise.file).first(size), rgb, {64, 64})) << size;
  }
  for (std::size_t at = 20; at < noise.file.size() - 16; at += 401) {
    auto damaged = noise.file;
    damaged[at] ^= 4;
    EXPECT_FALSE(reduce(damaged, rgb, {64, 64})) << at;
  }
  EXPECT_THAT(reduce(NoisePng(LCT_RGB, 8, 90, 70, true).file, rgb, {64, 64}).error().message(),
              HasSubstr("interlaced"));
  EXPECT_THAT(reduce(NoisePng(LCT_GREY, 1, 4097, 2).file, rgb, {64, 64}).error().message(),
              HasSubstr("4097 x 2 pixels"));
}

}  // namespace reduced_picture_test
}  // namespace plumbline::firmware
