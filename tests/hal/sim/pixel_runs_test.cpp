/// Regions of pixels against a flood fill.

#include "hal/sim/part/pixel_runs.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <utility>
#include <vector>

namespace plumbline {
namespace {

constexpr std::uint32_t kColumns = 131;
constexpr std::uint32_t kRows = 23;

/// An image with its words.
struct Picture {
  std::vector<std::uint64_t> words = std::vector<std::uint64_t>(BitImage::words_needed(kColumns, kRows), 0);
  BitImage image{words, kColumns, kRows};
};

Picture random_picture(std::mt19937& random, double white) {
  Picture picture;
  std::bernoulli_distribution is_white(white);
  for (std::uint32_t y = 0; y < kRows; ++y) {
    for (std::uint32_t x = 0; x < kColumns; ++x) {
      if (is_white(random)) picture.image.set(x, y);
    }
  }
  return picture;
}

/// Labels of all pixels of one colour, in raster order of their first pixels; -1: the other colour.
struct Flood {
  std::vector<int> label = std::vector<int>(kColumns * kRows, -1);
  std::vector<std::uint32_t> pixels, sides_x, sides_y;
  std::vector<bool> at_border;

  Flood(ConstBitImage image, bool white) {
    const auto is = [&](int x, int y) {
      if (x < 0 || y < 0 || x >= int{kColumns} || y >= int{kRows}) return false;
      return image.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)) == white;
    };
    for (int y = 0; y < int{kRows}; ++y) {
      for (int x = 0; x < int{kColumns}; ++x) {
        if (!is(x, y) || at(x, y) >= 0) continue;
        const int name = static_cast<int>(pixels.size());
        pixels.push_back(0);
        sides_x.push_back(0);
        sides_y.push_back(0);
        at_border.push_back(false);
        const auto l = static_cast<std::size_t>(name);
        std::vector<std::pair<int, int>> todo{{x, y}};
        at(x, y) = name;
        while (!todo.empty()) {
          const auto [i, j] = todo.back();
          todo.pop_back();
          ++pixels[l];
          if (i == 0 || j == 0 || i == int{kColumns} - 1 || j == int{kRows} - 1) at_border[l] = true;
          for (const auto& [di, dj] : std::array<std::pair<int, int>, 4>{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}}) {
            if (!is(i + di, j + dj)) {
              ++(di == 0 ? sides_x : sides_y)[l];
            } else if (at(i + di, j + dj) < 0) {
              at(i + di, j + dj) = name;
              todo.emplace_back(i + di, j + dj);
            }
          }
        }
      }
    }
  }
  int& at(int x, int y) { return label[static_cast<std::size_t>(y) * kColumns + static_cast<std::size_t>(x)]; }
};

TEST(PixelRuns, FindsTheWhiteRegionsThatAFloodFinds) {
  std::mt19937 random(1);
  PixelRuns runs;
  for (const double white : {0.0, 0.02, 0.3, 0.55, 0.6, 0.9, 1.0}) {
    for (int n = 0; n < 10; ++n) {
      const Picture picture = random_picture(random, white);
      Flood flood(picture.image, true);
      runs.find_white(picture.image);
      ASSERT_EQ(runs.regions().size(), flood.pixels.size());
      for (std::uint32_t y = 0; y < kRows; ++y) {
        for (std::uint32_t x = 0; x < kColumns; ++x) {
          ASSERT_EQ(static_cast<int>(runs.region_at(x, y)), flood.at(static_cast<int>(x), static_cast<int>(y)));
        }
      }
      for (std::size_t r = 0; r < flood.pixels.size(); ++r) {
        const PixelRuns::Region& region = runs.regions()[r];
        EXPECT_EQ(region.pixels, flood.pixels[r]);
        EXPECT_EQ(region.sides_x, flood.sides_x[r]);
        EXPECT_EQ(region.sides_y, flood.sides_y[r]);
        EXPECT_EQ(runs.region_at(region.column, region.row), r);
      }
    }
  }
}

TEST(PixelRuns, FindsTheBlackRegionsThatAFloodFinds) {
  std::mt19937 random(2);
  PixelRuns white;
  PixelRuns black;
  for (const double share : {0.0, 0.3, 0.55, 0.7, 0.9, 1.0}) {
    for (int n = 0; n < 10; ++n) {
      const Picture picture = random_picture(random, share);
      Flood flood(picture.image, false);
      white.find_white(picture.image);
      black.find_black(white, kColumns);
      std::size_t enclosed = 0;
      for (const bool border : flood.at_border) enclosed += border ? 0 : 1;
      ASSERT_EQ(black.regions().size(), 1 + enclosed);
      for (std::uint32_t y = black.first_row(); y < black.end_row(); ++y) {
        for (std::uint32_t x = 0; x < kColumns; ++x) {
          const int label = flood.at(static_cast<int>(x), static_cast<int>(y));
          const std::uint32_t region = black.region_at(x, y);
          ASSERT_EQ(region == PixelRuns::kNone, label < 0);
          if (label < 0) continue;
          ASSERT_EQ(region == 0, flood.at_border[static_cast<std::size_t>(label)]);
          if (region > 0) {
            ASSERT_EQ(black.regions()[region].pixels, flood.pixels[static_cast<std::size_t>(label)]);
          }
        }
      }
    }
  }
}

TEST(PixelRuns, CountThePixelsInWhichTwoLayersTouch) {
  std::mt19937 random(3);
  for (int n = 0; n < 20; ++n) {
    const Picture below = random_picture(random, 0.5);
    const Picture above = random_picture(random, 0.4);
    PixelRuns a;
    PixelRuns b;
    a.find_white(below.image);
    b.find_white(above.image);
    std::vector<std::uint32_t> found(a.regions().size() * b.regions().size(), 0);
    std::vector<std::uint32_t> expected = found;
    for_each_contact(a, b, [&](std::uint32_t i, std::uint32_t j, std::uint32_t pixels) {
      found[i * b.regions().size() + j] += pixels;
    });
    for (std::uint32_t y = 0; y < kRows; ++y) {
      for (std::uint32_t x = 0; x < kColumns; ++x) {
        if (!below.image.at(x, y) || !above.image.at(x, y)) continue;
        ++expected[a.region_at(x, y) * b.regions().size() + b.region_at(x, y)];
      }
    }
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace plumbline
