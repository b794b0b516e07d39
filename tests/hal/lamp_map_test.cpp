#include "hal/lamp_map.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace plumbline {
namespace {

LampMap measured(std::uint32_t columns, std::uint32_t rows, std::uint32_t seed) {
  std::mt19937 random(seed);
  LampMap map{.columns = columns, .rows = rows};
  for (std::uint32_t i = 0; i < columns * rows; ++i) map.light[i] = 3 + static_cast<double>(random() % 1000) / 1000;
  return map;
}

std::vector<std::uint32_t> shares_of(const LampShares& shares, std::uint32_t columns, std::uint32_t row) {
  LampShares::Row walk(shares, row);
  walk.go_to(0);
  std::vector<std::uint32_t> all;
  for (std::uint32_t x = 0; x < columns; ++x) all.push_back(walk.next());
  return all;
}

TEST(LampMap, LetsThroughTheShareOfTheDarkestPlaceBilinearly) {
  for (const auto& [columns, rows, map] :
       {std::tuple(1440U, 37U, measured(8, 5, 1)), std::tuple(7680U, 11U, measured(16, 16, 2)),
        std::tuple(33U, 64U, measured(3, 1, 3)), std::tuple(5U, 3U, measured(16, 7, 4)),
        std::tuple(16384U, 2U, measured(2, 16, 5)), std::tuple(1U, 1U, measured(1, 1, 6))}) {
    const LampShares shares(map, columns, rows);
    LampMap g = map;  // of the same places
    for (double& light : g.light) light = light > 0 ? map.darkest() / light : 0;
    for (std::uint32_t y = 0; y < rows; ++y) {
      const auto of_row = shares_of(shares, columns, y);
      for (std::uint32_t x = 0; x < columns; ++x) {
        const double expected = g.at((x + 0.5) / columns, (y + 0.5) / rows) * g.darkest();
        ASSERT_NEAR(of_row[x], LampShares::kAll * expected, 4) << columns << ": " << x << ", " << y;
        ASSERT_LE(of_row[x], LampShares::kAll);
        LampShares::Row other(shares, y);
        if (x % 7 != 0) continue;
        other.go_to(x);
        ASSERT_EQ(other.next(), of_row[x]) << "wherever a run begins";
      }
    }
  }
}

TEST(LampMap, LeavesTheLevelsOfAnEvenLamp) {
  LampMap even{.columns = 4, .rows = 3};
  std::ranges::fill(even.light, 7.3);
  for (const std::uint32_t share : shares_of(LampShares(even, 100, 50), 100, 20)) EXPECT_EQ(share, LampShares::kAll);
  for (std::uint32_t level = 0; level < 256; ++level) {
    EXPECT_EQ(LampShares::scaled(level, LampShares::kAll), level);
    EXPECT_EQ(LampShares::scaled(level, LampShares::kAll / 2), (level + 1) / 2);
  }
}

TEST(LampMap, IsTheSameOnEveryMachine) {
  const LampShares shares(measured(7, 5, 9), 1440, 2560);
  std::uint64_t hash = 1469598103934665603U;  // FNV-1a
  for (std::uint32_t y = 0; y < 2560; y += 10) {
    for (const std::uint32_t share : shares_of(shares, 1440, y)) hash = (hash ^ share) * 1099511628211U;
  }
  EXPECT_EQ(hash, 9904245692116165673U);
}

TEST(LampMap, ShowsEachLitPixelOnceWithItsLevel) {
  constexpr std::uint32_t kColumns = 131, kRows = 60;
  std::mt19937 random(8);
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  const BitImage mask(words, kColumns, kRows);
  std::vector<std::uint32_t> levels(kColumns * kRows);
  std::vector<GreyRun> greys;
  for (std::uint32_t y = 0; y < kRows; ++y) {
    if (y % 5 == 0) continue;  // black
    for (std::uint32_t x = 0; x < kColumns;) {
      const auto count = std::min(static_cast<std::uint32_t>(1 + random() % 40), kColumns - x);
      const std::uint32_t level = std::array{0U, 255U, 60U, 200U}[random() % 4], pixel = y * kColumns + x;
      if (is_grey(level)) greys.push_back({pixel, static_cast<std::uint16_t>(count), static_cast<std::uint8_t>(level)});
      // Bits under grey pixels say nothing.
      if (level == 255 || (is_grey(level) && random() % 2 != 0)) fill(mask, y, x, x + count, true);
      std::fill_n(levels.begin() + pixel, count, level);
      x += count;
    }
  }
  const LampMap map = measured(3, 3, 1);
  const LampShares shares(map, kColumns, kRows);
  std::vector<std::uint32_t> shown(levels.size());
  std::uint32_t end = 0;
  for_each_lit_run(mask, greys, shares, [&](const GreyRun& run, LampShares::Row& row) {
    EXPECT_GE(run.pixel, end);
    end = run.end();
    const auto of_row = shares_of(shares, kColumns, run.pixel / kColumns);
    for (std::uint32_t pixel = run.pixel; pixel < end; ++pixel) {
      shown[pixel] = run.level;
      ASSERT_EQ(row.next(), of_row[pixel % kColumns]);
    }
  });
  EXPECT_EQ(shown, levels);
}

}  // namespace
}  // namespace plumbline
