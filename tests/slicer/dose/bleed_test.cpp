#include "slicer/dose/bleed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/slicer/support/columns.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// What the layers from `first` to `end` - 1 cure below the film of the first, by the definition.
double depth_by_definition(const CureModel& model, std::uint32_t first, std::uint32_t end) {
  double sum = 0, largest = 0;
  for (std::uint32_t k = first; k < end; ++k) {
    const double dose =
        model.dose_of(k) * std::exp(-static_cast<double>(k - first) * kColumnLayer / model.penetration_mm);
    sum += dose;
    largest = std::max(largest, dose);
  }
  const double dose = largest + (1 - model.exchange) * (sum - largest);
  return std::max(0.0, model.penetration_mm * std::log(dose / model.critical_dose));
}

TEST(CureDepths, AreThoseOfTheWorkingCurve) {
  CureModel model = standard_resin();
  for (const double exchange : {0.0, 0.3, 1.0}) {
    model.exchange = exchange;
    for (const double penetration : {0.05, 0.12, 0.56, 2.0}) {  // light of many layers reaches far in a clear resin
      model.penetration_mm = penetration;
      for (const std::uint32_t bottom : {6U, 50U}) {
        model.bottom_layers = bottom;
        const CureDepths depths(model, kColumnLayer);
        for (const std::uint32_t first : {0U, 3U, 7U, 9U, 10U, 40U, 500U}) {
          for (const std::uint32_t count : {1U, 2U, 5U, 16U, 64U, 65U, 400U}) {
            EXPECT_NEAR(depths.below_film_mm(first, count), depth_by_definition(model, first, first + count),
                        1e-4 * penetration)
                << first << ' ' << count << ", Dp " << penetration;
          }
          EXPECT_NEAR(depths.below_film_mm(first, CureDepths::kThick), depth_by_definition(model, first, first + 4000),
                      1e-6);
        }
      }
    }
  }
  const CureDepths depths(standard_resin(), kColumnLayer);
  EXPECT_NEAR(depths.below_film_mm(500, 1), 0.121, 0.0005);
  EXPECT_NEAR(depths.below_film_mm(500, 400), 0.250, 0.001);
  EXPECT_EQ(depths.below_film_mm(500, 0), 0);
}

/// Heights in layers, of each column.
std::vector<std::vector<double>> heights_of(const RRep& rrep) {
  std::vector<std::vector<double>> heights(rrep.grid.columns);
  const CrossingPacking packing(rrep.grid);
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      if (i > rrep.first[k]) {
        EXPECT_LT(packing.pixel(rrep.packed[i - 1]), packing.pixel(rrep.packed[i]));
      }
      heights[packing.pixel(rrep.packed[i])].push_back(
          static_cast<double>(packing.height_mm(rrep.packed[i], k, rrep.grid)) / kColumnLayer);
    }
  }
  return heights;
}

/// The first layer whose mask has a pixel whose ray enters at this height.
std::uint32_t lowest_lit(double height) { return static_cast<std::uint32_t>(std::max(0.0, std::ceil(height - 0.5))); }

TEST(Bleed, TheFrontOfTheLightMeetsTheSurfaceToHalfALayer) {
  for (const double exchange : {0.0, 1.0}) {
    CureModel model = standard_resin();
    model.exchange = exchange;
    // Steps of the underside from the bottom layers up, and of the top.
    std::vector<std::vector<double>> columns;
    for (double z = 1.5; z < 60; z += 0.37) columns.insert(columns.end(), {{z, z + 40}, {0, 109}});
    for (double thick = 4; thick < 30; thick += 0.61) columns.insert(columns.end(), {{30, 30 + thick}, {0, 109}});
    ArenaBlock arena(kMiB);
    RRep rrep = columns_of(columns, 110, *arena);
    const std::size_t used = arena->used();
    const BleedCounts counts = value_of(correct_bleed(rrep, model, 0, *arena));
    EXPECT_EQ(arena->used(), used);
    EXPECT_EQ(counts.moved, columns.size() / 2);
    const auto found = heights_of(rrep);
    for (std::size_t c = 0; c < columns.size(); c += 2) {
      ASSERT_EQ(found[c].size(), 2U);
      EXPECT_NEAR(found[c][1], columns[c][1], 0.01) << "tops stay";
      const std::uint32_t exit = lowest_lit(columns[c][1]);
      const std::uint32_t lit = lowest_lit(found[c][0]);
      ASSERT_LT(lit, exit);
      const auto front = [&](std::uint32_t from) {
        return (from + 1) * kColumnLayer - depth_by_definition(model, from, exit);
      };
      const double off = front(lit) - columns[c][0] * kColumnLayer;
      // No other lowest layer is nearer; a gap to the plate that the bottom layers cure shut even so can't be helped.
      for (std::uint32_t other = lit > 3 ? lit - 3 : 0; other < std::min(exit, lit + 4); ++other) {
        EXPECT_LE(std::abs(off), std::abs(front(other) - columns[c][0] * kColumnLayer) + 1e-3)
            << columns[c][0] << ": " << lit << " or " << other;
      }
    }
  }
}

TEST(Bleed, LeavesWhatStandsOnThePlateAndALayerOfWhatIsThin) {
  ArenaBlock arena(kMiB);
  RRep rrep = columns_of({{0, 50}, {0, 79}, {40, 41.2}, {0, 79}, {40, 43, 60}, {}}, 80, *arena);
  const BleedCounts counts = value_of(correct_bleed(rrep, standard_resin(), 0, *arena));
  const auto found = heights_of(rrep);
  EXPECT_NEAR(found[0][0], 0, 0.02);
  EXPECT_EQ(lowest_lit(found[2][0]), lowest_lit(41.2) - 1);
  EXPECT_EQ(lowest_lit(found[4][0]), 42U);
  ASSERT_EQ(found[4].size(), 3U) << "a ray that does not leave";
  EXPECT_GT(found[4][2], 63);
  EXPECT_EQ(counts.moved, 2U);
  // Raised by supports it does not stand on the plate, and is far above the bottom layers.
  RRep raised = columns_of({{0, 50}}, 80, *arena);
  EXPECT_EQ(value_of(correct_bleed(raised, standard_resin(), 100, *arena)).moved, 1U);
  EXPECT_NEAR(heights_of(raised)[0][0], 0.25 / kColumnLayer - 1, 0.1);
}

/// Layers of a row's columns in which a piece begins that nothing below it holds.
std::vector<std::uint32_t> islands_of(const RRep& rrep) {
  const auto heights = heights_of(rrep);
  const auto is_lit = [&](std::size_t c, std::uint32_t k) {
    if (c >= heights.size()) return false;
    return std::ranges::count_if(heights[c], [&](double height) { return lowest_lit(height) <= k; }) % 2 != 0;
  };
  std::vector<std::uint32_t> islands;
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    for (std::size_t c = 0; c < heights.size(); ++c) {
      bool is_piece = false, is_held = false;
      for (; is_lit(c, k); ++c) {
        is_piece = true;
        is_held |= k > 0 && is_lit(c, k - 1);
      }
      if (is_piece && !is_held) islands.push_back(k);
    }
  }
  return islands;
}

TEST(Bleed, LeavesNoStripOfASharpEdgeWhereNothingHoldsIt) {
  // A body with a lip: its underside is lowest at the edge, where it is thin.
  ArenaBlock arena(kMiB);
  for (const std::uint32_t lifted : {0U, 50U}) {
    RRep rrep = columns_of({{}, {30, 33}, {30, 34}, {30, 36}, {31, 39}, {32, 60}, {32, 60}, {30, 60}}, 80, *arena);
    EXPECT_EQ(islands_of(rrep), (std::vector<std::uint32_t>{30, 30}));
    EXPECT_GT(value_of(correct_bleed(rrep, standard_resin(), lifted, *arena)).pixels, 8U);
    EXPECT_EQ(islands_of(rrep), (std::vector<std::uint32_t>{34, 34})) << "the same two";
  }
}

TEST(Bleed, KeepsATiltedSheetInOnePiece) {
  ArenaBlock arena(kMiB);
  for (const double thick : {3.0, 5.0}) {
    std::vector<std::vector<double>> columns = {{0, 79}};
    for (int c = 0; c < 12; ++c) columns.push_back({20.0 + 1.6 * c, 20.0 + 1.6 * c + thick});
    RRep rrep = columns_of(columns, 80, *arena);
    correct_bleed(rrep, standard_resin(), 0, *arena).value();
    EXPECT_EQ(islands_of(rrep), std::vector<std::uint32_t>{0}) << thick;
    for (const auto& heights : heights_of(rrep)) EXPECT_EQ(heights.size(), 2U) << thick;
  }
}

TEST(Bleed, KeepsALayerOfASheetThatStandsAlone) {
  ArenaBlock arena(kMiB);
  RRep rrep = columns_of({{}, {20, 22}, {20, 22}, {20, 22}, {}}, 40, *arena);
  correct_bleed(rrep, standard_resin(), 10, *arena).value();
  EXPECT_EQ(islands_of(rrep), std::vector<std::uint32_t>{21});
}

TEST(Bleed, DoesTheSameInLittleMemory) {
  // A body with a broad lip that hangs lower than it.
  const auto lip = [](double x, double y, double z) {
    return y > 2 && y < 78 && ((x > 60 && x < 78 && z > 34) || (x > 4 && x <= 60 && z > 28 && z < 31.2 + 0.02 * x));
  };
  const Solid solid(cubic_grid(80, 60, 0.05F), lip);
  ArenaBlock plenty(kMiB);
  ArenaBlock little(Arena::rounded(61 * 4) + Arena::rounded(solid.rrep.packed.size_bytes()) +
                    bleed_bytes(solid.rrep.grid, solid.rrep.crossings()) + 8 * Arena::kAlignment);
  std::vector<std::vector<std::uint32_t>> found;
  for (ArenaBlock* const arena : {&plenty, &little}) {
    RRep rrep = solid.rrep;
    const auto first = value_of((*arena)->take_bottom<std::uint32_t>(rrep.first.size(), "test"));
    const auto packed = value_of((*arena)->take_bottom<std::uint32_t>(rrep.packed.size(), "test"));
    std::ranges::copy(rrep.first, first.begin());
    std::ranges::copy(rrep.packed, packed.begin());
    rrep.first = first;
    rrep.packed = packed;
    const BleedCounts counts = value_of(correct_bleed(rrep, standard_resin(), 20, **arena));
    EXPECT_GT(counts.moved, 1000U);
    found.emplace_back(packed.begin(), packed.end());
  }
  EXPECT_EQ(found[0], found[1]);
}

}  // namespace
}  // namespace plumbline
