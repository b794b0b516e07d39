/// What drops on the simulated printer is what the sweep of checks foretells.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "hal/sim/sim_machine.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "tests/hal/small_print.hpp"

namespace plumbline {
namespace foretold_test {

constexpr std::uint32_t kColumns = 130;
constexpr std::uint32_t kRows = 64;
constexpr std::uint32_t kLayers = 60;
constexpr double kPixelMl = 0.1 * 0.1 * 0.05 / 1000;

struct Shape {
  std::string name;
  std::function<bool(std::uint32_t x, std::uint32_t y, std::uint32_t layer)> solid;
  std::size_t pieces = 0;  ///< that nothing holds, by looking at it
};

double away(std::uint32_t x, std::uint32_t y, double cx, double cy) {
  return std::sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy));
}

std::vector<Shape> shapes() {
  return {
      {"post", [](auto x, auto y, auto) { return away(x, y, 30, 30) < 20; }, 0},
      {"mushroom",
       [](auto x, auto y, auto k) {
         const double r = away(x, y, 40, 32);
         return r < 12 || (r < 28 && k >= 40) || (r > 20 && r < 28 && k >= 25);
       },
       1},
      {"tables",
       [](auto x, auto y, auto k) {
         if (y < 5 || y >= 60 || x > 125) return false;
         return x < 20 || k >= 50 || (x > 40 && x < 60 && k >= 20) || (x > 80 && x < 90 && y < 30 && k >= 35);
       },
       2},
      {"icicles",
       [](auto x, auto y, auto k) {
         if (x < 30) return true;
         bool solid = k >= 45;
         for (int i = 0; i < 6; ++i) {
           const double tip = 10 + 5 * i;
           solid = solid || away(x, y, 45 + 14 * i, 12 + 8 * i) < (k < tip ? -1 : 0.2 * (k - tip) + 1);
         }
         return solid;
       },
       6},
      {"arch",
       [](auto x, auto y, auto k) { return y > 10 && y < 50 && (x < 20 || (x > 60 && x < 90) || k > 30) && x < 100; },
       0},
  };
}

/// One layer's mask, drawn anew.
void draw(const Shape& shape, std::uint32_t layer, BitImage image) {
  image.clear();
  for (std::uint32_t y = 0; y < kRows; ++y) {
    for (std::uint32_t x = 0; x < kColumns; ++x) {
      if (shape.solid(x, y, layer)) image.set(x, y);
    }
  }
}

/// The pieces that the sweep finds nothing to hold, lowest first.
std::vector<Issue> foretell(const Shape& shape) {
  const PrintGrid grid{.columns = kColumns,
                       .rows = kRows,
                       .layers = kLayers,
                       .pitch_x_mm = 0.1F,
                       .pitch_y_mm = 0.1F,
                       .layer_height_mm = 0.05F};
  std::vector<std::byte> block(StackChecker::bytes_needed(grid) + 4096);
  Arena arena(block);
  auto checker = StackChecker::create(grid, {}, arena).value();
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  for (std::uint32_t k = 0; k < kLayers; ++k) {
    draw(shape, k, BitImage(words, kColumns, kRows));
    checker.next(ConstBitImage(words, kColumns, kRows));
  }
  const IssueGroup& group = checker.finish().of(IssueKind::kFreePiece);
  EXPECT_EQ(group.kept_count, group.count);
  std::vector<Issue> pieces(group.all_kept().begin(), group.all_kept().end());
  std::sort(pieces.begin(), pieces.end(), [](const Issue& a, const Issue& b) { return a.first_layer < b.first_layer; });
  return pieces;
}

TEST(Foretold, FreePiecesDropInTheirLayersWithTheirVolume) {
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    PlantSettings settings;
    settings.panel.columns = kColumns;
    settings.panel.rows = kRows;
    settings.panel.pitch_x_mm = settings.panel.pitch_y_mm = 0.1;
    Plant plant(settings);
    SimMachine machine(plant);
    const auto draw_layer = [&](std::uint32_t k, BitImage image) { draw(shape, k, image); };
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = kLayers, .draw = draw_layer}));
    plant.conclude(JobEnd::kFinished);

    std::vector<Loss> dropped;
    double ml = 0;
    double shadow_ml = 0;
    for (const Objection& objection : plant.objections()) {
      ASSERT_TRUE(objection.loss) << to_string(objection);
      if (objection.kind == ObjectionKind::kShadowed) {
        shadow_ml += objection.loss->ml;
        continue;
      }
      ASSERT_EQ(objection.kind, ObjectionKind::kDropped) << to_string(objection);
      dropped.push_back(*objection.loss);
      ml += dropped.back().ml;
    }
    const auto pieces = foretell(shape);
    ASSERT_EQ(pieces.size(), shape.pieces);
    ASSERT_EQ(dropped.size(), pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      EXPECT_EQ(dropped[i].layer, pieces[i].first_layer);
      EXPECT_EQ(dropped[i].last_layer, pieces[i].last_layer);
      const double foretold_ml = static_cast<double>(pieces[i].voxels) * kPixelMl;
      EXPECT_NEAR(dropped[i].ml, foretold_ml, 0.02 * foretold_ml);
      const auto column = static_cast<std::uint32_t>(dropped[i].x_mm * 10);
      const auto row = static_cast<std::uint32_t>(dropped[i].y_mm * 10);
      EXPECT_TRUE(shape.solid(column, row, dropped[i].layer));
    }
    // Nothing else is missing: what stayed, dropped or was shadowed is what the masks asked for.
    double asked = 0;
    double stayed = 0;
    std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
    std::uint32_t k = 0;
    plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage cured) {
      draw(shape, k++, BitImage(words, kColumns, kRows));
      asked += static_cast<double>(BitImage(words, kColumns, kRows).count());
      stayed += static_cast<double>(cured.count());
    });
    EXPECT_NEAR(stayed * kPixelMl + ml + shadow_ml, asked * kPixelMl, 1e-9);
  }
}

}  // namespace foretold_test
}  // namespace plumbline
