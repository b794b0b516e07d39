#include "slicer/core/regions/layer_regions.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "slicer/core/bit_image.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr std::uint32_t kColumns = 70;
constexpr std::uint32_t kRows = 40;

class LayerRegionsOf : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Corners, LayerRegionsOf, ::testing::Bool());

TEST_P(LayerRegionsOf, AreThoseOfAFloodFill) {
  const LayerRegions::Settings settings{.join_white_corners = GetParam()};
  Random random(5);
  ArenaBlock memory(std::size_t{4} << 20);
  auto regions = LayerRegions::create(kColumns, kRows, *memory, settings);
  ASSERT_TRUE(regions.has_value());
  EXPECT_EQ(memory->top_used(), LayerRegions::bytes_needed(kRows, settings));
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  for (const std::uint32_t percent : {10U, 40U, 50U, 60U, 90U}) {
    const BitImage image(words, kColumns, kRows);
    image.clear();
    for (std::uint32_t r = 0; r < kRows; ++r) {
      for (std::uint32_t c = 0; c < kColumns; ++c) {
        if (random.below(100) < percent) image.set(c, r);
      }
    }
    ASSERT_TRUE(regions->label(image));
    // Finds each pixel's region, then the same partition by flood fill. Their names must correspond one to one.
    std::vector<std::uint32_t> region(std::size_t{kColumns} * kRows);
    for (std::uint32_t r = 0; r < kRows; ++r) {
      for (std::uint32_t i = regions->row_begin(r); i < regions->row_begin(r + 1); ++i) {
        const LayerRegions::Run run = regions->run(i);
        for (std::uint32_t c = run.first; run.first <= run.last && c <= run.last; ++c) {
          EXPECT_EQ(regions->white(r, i), image.at(c, r));
          EXPECT_EQ(regions->row_of(i), r);
          region[r * kColumns + c] = regions->region(i);
        }
      }
    }
    std::vector<int> flood(region.size(), -1);
    std::map<std::uint32_t, int> name;
    std::map<std::uint32_t, std::uint32_t> area;
    int next = 0;
    const auto fill = [&](std::uint32_t start, int label) {
      std::vector<std::uint32_t> stack{start};
      flood[start] = label;
      while (!stack.empty()) {
        const std::uint32_t p = stack.back();
        stack.pop_back();
        const int c = static_cast<int>(p % kColumns);
        const int r = static_cast<int>(p / kColumns);
        const bool white = image.at(p % kColumns, p / kColumns);
        for (int dr = -1; dr <= 1; ++dr) {
          for (int dc = -1; dc <= 1; ++dc) {
            if (!(white && GetParam()) && dr != 0 && dc != 0) continue;
            const int nc = c + dc;
            const int nr = r + dr;
            if (nc < 0 || nr < 0 || nc >= static_cast<int>(kColumns) || nr >= static_cast<int>(kRows)) continue;
            const auto q = static_cast<std::uint32_t>(nr) * kColumns + static_cast<std::uint32_t>(nc);
            if (flood[q] >= 0 || image.at(q % kColumns, q / kColumns) != white) continue;
            flood[q] = label;
            stack.push_back(q);
          }
        }
      }
    };
    for (std::uint32_t p = 0; p < region.size(); ++p) {
      const bool border =
          p % kColumns == 0 || p % kColumns == kColumns - 1 || p / kColumns == 0 || p / kColumns == kRows - 1;
      if (border && !image.at(p % kColumns, p / kColumns) && flood[p] < 0)
        fill(p, 1000000);  // all of the outside is one region
    }
    for (std::uint32_t p = 0; p < region.size(); ++p) {
      if (flood[p] < 0) fill(p, next++);
    }
    std::uint32_t first_enclosed = 0;
    while (first_enclosed < region.size() &&
           (image.at(first_enclosed % kColumns, first_enclosed / kColumns) || flood[first_enclosed] == 1000000)) {
      ++first_enclosed;
    }
    EXPECT_EQ(regions->first_enclosed_row(), first_enclosed / kColumns);
    std::set<std::pair<std::uint32_t, int>> pairs;
    for (std::uint32_t p = 0; p < region.size(); ++p) {
      pairs.insert({region[p], flood[p]});
      ++area[region[p]];
    }
    std::set<std::uint32_t> ours;
    std::set<int> theirs;
    for (const auto& [a, b] : pairs) {
      ours.insert(a);
      theirs.insert(b);
      if (a != LayerRegions::kOutside) {
        EXPECT_EQ(regions->area(a), area[a]);
      }
    }
    EXPECT_EQ(pairs.size(), ours.size());
    EXPECT_EQ(pairs.size(), theirs.size());
  }
}

}  // namespace
}  // namespace plumbline
