#include "slicer/core/grey_runs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <vector>

namespace plumbline {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::uint32_t kGreyColumns = 30, kGreyRows = 40;

TEST(GreyRuns, LengthenTheLastRunWithinARow) {
  std::vector<GreyRun> room(10);
  GreyRuns greys(room, kGreyColumns);
  for (const std::uint32_t pixel : {5U, 6U, 7U}) greys.add(pixel, 100);
  greys.add(8, 101);
  greys.add(10, 101);
  greys.add(29, 9);
  greys.add(30, 9);  // the next row
  EXPECT_THAT(greys.runs(), ElementsAre(GreyRun{5, 3, 100}, GreyRun{8, 1, 101}, GreyRun{10, 1, 101}, GreyRun{29, 1, 9},
                                        GreyRun{30, 1, 9}));
  EXPECT_EQ(greys.lost(), 0U);
  greys.clear();
  EXPECT_TRUE(greys.empty());
}

TEST(GreyRuns, CountThePixelsThatFindNoRoom) {
  std::vector<GreyRun> room(2);
  GreyRuns greys(room, kGreyColumns);
  for (const std::uint32_t pixel : {1U, 3U, 4U, 6U, 8U}) greys.add(pixel, 50);
  greys.add(GreyRun{60, 7, 50});
  EXPECT_THAT(greys.runs(), ElementsAre(GreyRun{1, 1, 50}, GreyRun{3, 2, 50}));
  EXPECT_EQ(greys.lost(), 9U);
  greys.clear();
  EXPECT_EQ(greys.lost(), 0U);
  GreyRuns none;
  none.add(4, 200);
  EXPECT_THAT(none.runs(), IsEmpty());
  EXPECT_EQ(none.lost(), 1U);
}

/// Pixels of a few levels, in areas and in noise.
std::vector<std::uint8_t> some_levels(std::mt19937_64& random) {
  std::vector<std::uint8_t> levels(kGreyColumns * kGreyRows, 0);
  for (std::uint32_t i = 0; i < levels.size(); ++i) {
    const std::uint32_t row = i / kGreyColumns;
    levels[i] = row < 20   ? 77
                : row < 30 ? std::array<std::uint8_t, 3>{0, 128, 255}[static_cast<std::size_t>(random() % 3)]
                           : 0;
  }
  return levels;
}

TEST(GreyRuns, AreTheSameInWhateverOrderPixelsCome) {
  std::mt19937_64 random(3);
  const auto levels = some_levels(random);
  std::vector<std::uint32_t> order(levels.size());
  std::iota(order.begin(), order.end(), 0U);
  std::vector<GreyRun> first_room(GreyRuns::runs_needed(kGreyColumns, kGreyRows) + 120), room(first_room.size());
  GreyRuns ascending(first_room, kGreyColumns);
  for (const std::uint32_t pixel : order) {
    if (is_grey(levels[pixel])) ascending.add(pixel, levels[pixel]);
  }
  ASSERT_EQ(ascending.lost(), 0U);
  for (int turn = 0; turn < 4; ++turn) {  // single pixels are more than there is room for until they are joined
    if (turn == 0) std::reverse(order.begin(), order.end());
    if (turn == 1)
      std::sort(order.begin(), order.end(),
                [](auto a, auto b) { return std::pair(a % kGreyColumns, a) < std::pair(b % kGreyColumns, b); });
    GreyRuns greys(room, kGreyColumns);
    for (const std::uint32_t pixel : order) {
      if (is_grey(levels[pixel])) greys.add(pixel, levels[pixel]);
    }
    greys.finish();
    EXPECT_EQ(greys.lost(), 0U) << turn;
    EXPECT_TRUE(std::ranges::equal(greys.runs(), ascending.runs())) << turn;
    if (turn > 0) std::shuffle(order.begin() + 400, order.end(), random);
  }
}

TEST(GreyRuns, LoseEachPixelOnceIfTheyAreFullOutOfOrder) {
  std::mt19937_64 random(5);
  std::vector<GreyRun> room(16);
  GreyRuns greys(room, kGreyColumns);
  std::vector<std::uint32_t> order(600);
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = 2 * i;
  std::shuffle(order.begin(), order.end(), random);
  for (const std::uint32_t pixel : order) greys.add(pixel, 200);
  greys.finish();
  std::uint64_t kept = 0;
  std::uint32_t end = 0;
  for (const GreyRun& run : greys.runs()) {
    EXPECT_GE(run.pixel, end);
    end = run.end();
    kept += run.count;
  }
  EXPECT_EQ(kept, 16U);
  EXPECT_EQ(kept + greys.lost(), 600U);
}

TEST(SetBits, MakesWhiteWhatIsTakenToCure) {
  std::vector<std::uint64_t> words(BitImage::words_needed(70, 2));
  const BitImage image(words, 70, 2);
  for (std::uint32_t c = 0; c < 70; ++c) image.set(c, 0);
  set_bits(std::vector<GreyRun>{{60, 8, 127}, {68, 2, 128}, {70, 3, 254}, {139, 1, kLeastCuringLevel}}, image);
  for (std::uint32_t c = 0; c < 70; ++c) {
    EXPECT_EQ(image.at(c, 0), c < 60 || c >= 68) << c;
    EXPECT_EQ(image.at(c, 1), c < 3 || c == 69) << c;
  }
}

}  // namespace
}  // namespace plumbline
