#include "slicer/dose/adaptive_layers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <utility>
#include <vector>

#include "slicer/dose/bleed.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "tests/slicer/support/columns.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline {
namespace {

using namespace testing;

LayerSteps steps_of(std::initializer_list<std::pair<std::uint32_t, std::uint32_t>> runs) {
  LayerSteps steps;
  for (const auto& [count, step] : runs) {
    for (std::uint32_t i = 0; i < count; ++i) EXPECT_TRUE(steps.add(step));
  }
  return steps;
}

TEST(LayerSteps, GoFromLayersOfThePrintToThoseOfTheRRepAndBack) {
  const LayerSteps steps = steps_of({{2, 3}, {3, 1}, {4, 5}});
  EXPECT_TRUE(steps.valid());
  std::uint32_t first = 0, layer = 0;
  for (const std::uint32_t step : {3U, 3U, 1U, 1U, 1U, 5U, 5U, 5U, 5U, 1U, 1U}) {  // above the runs, one each
    const LayerStep found = steps.of(layer);
    EXPECT_EQ(found.first, first);
    EXPECT_EQ(found.step, step);
    EXPECT_EQ(found.sampled(), first + (step - 1) / 2) << "the middle";
    for (std::uint32_t k = first; k < first + step; ++k) EXPECT_EQ(steps.layer_at(k), layer) << k;
    first += step;
    ++layer;
  }
  EXPECT_EQ(steps.layers(29), 9U);
  EXPECT_EQ(steps.layers(27), 9U) << "the last one is sampled";
  EXPECT_EQ(steps.layers(26), 8U) << "it is not";
  EXPECT_EQ(steps.run_end(3), 5U);
  EXPECT_TRUE(LayerSteps().all_one());
  EXPECT_EQ(LayerSteps().layers(77), 77U);
}

TEST(LayerSteps, AreRefusedWhereTheyDoNotAddUp) {
  LayerSteps steps = steps_of({{4, 3}, {2, 1}});
  const auto with = [&](std::size_t byte, unsigned char value) {
    LayerSteps wrong = steps;
    std::memcpy(reinterpret_cast<unsigned char*>(&wrong) + byte, &value, 1);
    return wrong.valid();
  };
  EXPECT_TRUE(with(0, 4));
  EXPECT_FALSE(with(0, 5)) << "five layers of three are not twelve";
  EXPECT_FALSE(with(4, 4)) << "an even step";
  EXPECT_FALSE(with(sizeof(LayerSteps) - 4, 255)) << "more runs than there are";
  for (std::uint32_t i = 0; i + 2 < LayerSteps::kMostRuns; ++i) EXPECT_TRUE(steps.add(i % 2 == 0 ? 5 : 7));
  EXPECT_FALSE(steps.add(1)) << "no room for another run";
  EXPECT_TRUE(steps.valid());
}

constexpr PrintGrid kHillGrid{.columns = 80, .rows = 80, .layers = 0, .layer_height_mm = 0.02F};

/// On the plate, its top at height_mm(x, y), in layers of 20 um.
template <class Height>
Solid hill(Height height_mm, std::uint32_t layers) {
  PrintGrid grid = kHillGrid;
  grid.layers = layers;
  return Solid(grid, [&](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return (k + 0.5) * 0.02 < height_mm((c - 39.5) * 0.05, (r - 39.5) * 0.05);
  });
}

TEST(AdaptiveLayers, AreThinOnShallowTopsAndThickOnSteepWalls) {
  constexpr AdaptiveLayers kAsked{.most = 5, .first = 3, .first_layers = 4};
  ArenaBlock arena(kMiB);
  // A cone of 80 degrees up to 4 mm, a dome on it.
  const auto height = [](double x, double y) {
    const double r = std::hypot(x, y);
    return r < 1 ? 4 + 0.3 * (1 - r * r) : 4 - (r - 1) * std::tan(80 * 3.14159 / 180);
  };
  const Solid solid = hill(height, 215);
  const std::size_t used = arena->used();
  const LayerSteps steps = value_of(choose_steps(solid.rrep, kAsked, 10, {}, *arena));
  EXPECT_EQ(arena->used(), used);
  EXPECT_EQ(steps.of(0).step, 3U);
  EXPECT_EQ(steps.of(3).step, 3U) << "the bottom layers";
  EXPECT_EQ(steps.of(steps.layer_at(110)).step, 5U) << "the cone";
  for (std::uint32_t k = 212; k < 224; ++k) EXPECT_EQ(steps.of(steps.layer_at(k)).step, 1U) << "the dome, " << k;
  EXPECT_LE(steps.layers(225), 70U);
  EXPECT_EQ(steps.of(steps.layers(225) - 1).end(), 225U) << "none reaches beyond the top";
}

TEST(AdaptiveLayers, BeginAtALevelTop) {
  constexpr AdaptiveLayers kAsked{.most = 5, .first = 1, .first_layers = 0};
  for (const std::uint32_t level : {91U, 92U, 93U, 94U}) {
    ArenaBlock arena(kMiB);
    const auto height = [&](double x, double y) {  // a shelf that is a small share of a high tower
      if (std::abs(x) < 1.6 && std::abs(y) < 1.6) return 4.0;
      return std::abs(x) < 1.9 && std::abs(y) < 1 ? level * 0.02 : 0;
    };
    const LayerSteps steps = value_of(choose_steps(hill(height, 200).rrep, kAsked, 0, {}, *arena));
    EXPECT_EQ(steps.of(steps.layer_at(level)).first, level);
  }
}

TEST(AdaptiveLayers, BecomeFewerRunsThanThereIsRoomFor) {
  constexpr AdaptiveLayers kAsked{.most = 5, .first = 1, .first_layers = 0};
  ArenaBlock arena(8 * kMiB);
  PrintGrid grid = kHillGrid;
  grid.layers = 6000;
  // Level tops and undersides all the way up, each with steep walls between.
  const Solid solid(grid, [&](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return c > 4 && c < 70 && r > 4 && r < (k / 41 % 2 == 0 ? 30 : 70);
  });
  const LayerSteps steps = value_of(choose_steps(solid.rrep, kAsked, 0, {}, *arena));
  EXPECT_TRUE(steps.valid());
  EXPECT_EQ(steps.runs().back().rrep_end, 6000U);
}

TEST(AdaptiveLayers, MasksAreThoseOfTheMiddleOfEachLayer) {
  const auto height = [](double x, double y) { return 2.5 + std::sin(5 * x) + std::cos(4 * y); };
  for (const std::uint32_t lifted : {0U, 4U, 5U}) {
    ArenaBlock arena(kMiB);
    const Solid before = hill(height, 230);
    Solid after = hill(height, 230);
    const LayerSteps steps = steps_of({{5, 3}, {20, 5}, {9, 1}, {60, 5}});
    take_steps(after.rrep, steps, lifted);
    EXPECT_EQ(after.rrep.grid.layers, 230U);
    LayerStream exact = value_of(LayerStream::create(before.rrep, *arena));
    LayerStream printed = value_of(LayerStream::create(after.rrep, *arena));
    for (std::uint32_t k = 0; k < 230; ++k) {
      const LayerStep step = steps.of(steps.layer_at(k + lifted));
      if (step.sampled() < lifted || step.sampled() >= lifted + 230) continue;  // the object begins or ends in it
      const ConstBitImage mask = exact.mask(step.sampled() - lifted);
      EXPECT_TRUE(std::ranges::equal(printed.mask(k).words(), mask.words())) << k << ' ' << lifted;
    }
  }
}

/// Where light cures down to if all layers from `lit` on are lit, by the definition of the dose.
double front_mm(const CureModel& model, const LayerSteps& steps, std::uint32_t lit) {
  double dose = 0;
  for (std::uint32_t layer = lit; layer < lit + 60; ++layer) {
    const double higher = steps.of(layer).step * kColumnLayer - model.layer_height_mm;
    const double depth = (steps.of(layer).end() - steps.of(lit).end()) * kColumnLayer;
    dose += model.dose * std::exp((higher - depth) / model.penetration_mm);
  }
  return steps.of(lit).end() * kColumnLayer - model.penetration_mm * std::log(dose / model.critical_dose);
}

TEST(AdaptiveLayers, LightOfLayersOfAnyHeightMeetsTheSurface) {
  CureModel model = standard_resin();
  model.bottom_layers = model.faded_layers = 0;
  model.layer_height_mm = 0.06;
  const LayerSteps steps = steps_of({{30, 3}, {40, 1}, {30, 3}, {30, 1}, {60, 3}});
  std::vector<std::vector<double>> columns;
  for (double z = 20.3; z < 180; z += 1.37) columns.insert(columns.end(), {{z, 399}, {0, 399}});
  ArenaBlock arena(kMiB);
  RRep rrep = columns_of(columns, 400, *arena);
  ASSERT_TRUE(correct_bleed(rrep, model, 0, *arena, steps));
  const CrossingPacking packing(rrep.grid);
  std::vector<std::uint32_t> lowest(columns.size(), 0);
  for (std::uint32_t k = rrep.grid.layers; k-- > 0;) {
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) lowest[packing.pixel(rrep.packed[i])] = k;
  }
  for (std::size_t c = 0; c < columns.size(); c += 2) {
    const std::uint32_t lit = steps.layer_at(lowest[c]);
    EXPECT_EQ(steps.of(lit).first, lowest[c]) << "layers begin there";
    const double off = std::abs(front_mm(model, steps, lit) - columns[c][0] * kColumnLayer);
    for (const std::uint32_t other : {lit - 1, lit + 1}) {
      EXPECT_LE(off, std::abs(front_mm(model, steps, other) - columns[c][0] * kColumnLayer) + 2e-3) << columns[c][0];
    }
  }
}

}  // namespace
}  // namespace plumbline
