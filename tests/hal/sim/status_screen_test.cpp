#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "hal/sim/sim_status_screen.hpp"

namespace plumbline {
namespace {

struct Watcher final : ScreenWatcher {
  void shown(std::uint32_t columns, std::uint32_t rows, std::span<const std::uint16_t> pixels) override {
    EXPECT_EQ(pixels.size(), std::size_t{columns} * rows);
    first_pixels.push_back(pixels.front());
  }
  std::vector<std::uint16_t> first_pixels;
};

TEST(SimStatusScreen, HandsEachFrameToItsWatcherAndKeepsTheLast) {
  Watcher watcher;
  SimStatusScreen screen(320, 240, &watcher);
  EXPECT_TRUE(screen.pixels().empty());
  std::vector<std::uint16_t> frame(std::size_t{320} * 240);
  for (const std::uint16_t colour : {std::uint16_t{1}, std::uint16_t{2}}) {
    std::fill(frame.begin(), frame.end(), colour);
    ASSERT_TRUE(screen.present(frame));
  }
  EXPECT_EQ(watcher.first_pixels, (std::vector<std::uint16_t>{1, 2}));
  EXPECT_TRUE(std::equal(frame.begin(), frame.end(), screen.pixels().begin(), screen.pixels().end()));
}

TEST(SimStatusScreen, DeliversEachTouchOnceAndInOrder) {
  SimStatusScreen screen(320, 240, nullptr);
  screen.touch({TimePoint(), 5, 6});
  screen.touch({TimePoint(), 7, 8});
  EXPECT_EQ(screen.next_touch()->column, 5U);
  EXPECT_EQ(screen.next_touch()->row, 8U);
  EXPECT_FALSE(screen.next_touch());
}

}  // namespace
}  // namespace plumbline
