/// What drops on the simulated printer is what the sweep of checks foretells.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <tuple>
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
  std::optional<std::size_t> pieces;  ///< that nothing holds, by looking at it
};

/// Sixty balls, some of them on the plate: they fall in dozens of pieces, which join each other and shadow what is above.
Shape balls(std::uint32_t seed) {
  struct Ball {
    double x, y, z, r;
  };
  std::mt19937 random(seed);
  const auto upto = [&](double most) { return most * static_cast<double>(random() % 1024) / 1024; };
  std::vector<Ball> all(60);
  for (Ball& ball : all) ball = {upto(kColumns), upto(kRows), upto(kLayers), 2 + upto(7)};
  return {"balls " + std::to_string(seed),
          [all](std::uint32_t x, std::uint32_t y, std::uint32_t k) {
            return std::any_of(all.begin(), all.end(), [&](const Ball& b) {
              return (x - b.x) * (x - b.x) + (y - b.y) * (y - b.y) + (k - b.z) * (k - b.z) < b.r * b.r;
            });
          },
          std::nullopt};
}

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
      {"fork",  // two tines that join before they meet the post
       [](auto x, auto y, auto k) {
         if (y < 10 || y >= 40) return false;
         return x < 20 || k >= 50 || (k >= 35 && x > 50 && x < 100) ||
                (k >= 20 && ((x > 50 && x < 60) || (x > 90 && x < 100)));
       },
       1},
      {"shade",  // a speck that falls takes the light from the only pixels that would hold a wall
       [](auto x, auto y, auto k) {
         if (y < 10 || y >= 40) return false;
         const bool bridge = k >= 20 && k < 30 && x >= 30 && x < 60;
         return x < 30 || (k == 15 && x >= 40 && x < 44) || (bridge && k >= 20) || (k >= 25 && x >= 60 && x < 70);
       },
       2},
      {"gap", [](auto x, auto y, auto k) { return away(x, y, 60, 30) < 20 && k != 30; }, 1},
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

StackFindings foretell(const Shape& shape) {
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
  return checker.finish();
}

/// Layers and voxels of a piece.
using Piece = std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>;

std::uint64_t voxels(double ml) { return static_cast<std::uint64_t>(std::llround(ml / kPixelMl)); }

TEST(Foretold, FreePiecesDropInTheirLayersWithTheirVolumeAndTheirShadow) {
  std::vector<Shape> all = shapes();
  for (std::uint32_t seed = 0; seed < 12; ++seed) all.push_back(balls(seed));
  for (const Shape& shape : all) {
    SCOPED_TRACE(shape.name);
    PlantSettings settings;
    settings.panel.columns = kColumns;
    settings.panel.rows = kRows;
    settings.panel.pitch_x_mm = settings.panel.pitch_y_mm = 0.1;
    settings.peel.green_strength_mpa = settings.peel.plate_adhesion_mpa = 1e6;  // nothing tears
    Plant plant(settings);
    SimMachine machine(plant);
    const auto draw_layer = [&](std::uint32_t k, BitImage image) { draw(shape, k, image); };
    ASSERT_TRUE(print_layers(machine.machine(), {.layers = kLayers, .draw = draw_layer}));
    plant.conclude(JobEnd::kFinished);

    std::vector<Piece> dropped;
    std::uint64_t dropped_voxels = 0;
    std::uint64_t shadowed_voxels = 0;
    for (const Objection& objection : plant.objections()) {
      ASSERT_TRUE(objection.loss) << to_string(objection);
      const Loss& loss = *objection.loss;
      if (objection.kind == ObjectionKind::kShadowed) {
        shadowed_voxels += voxels(loss.ml);
        continue;
      }
      ASSERT_EQ(objection.kind, ObjectionKind::kDropped) << to_string(objection);
      dropped.emplace_back(loss.layer, loss.last_layer, voxels(loss.ml));
      dropped_voxels += voxels(loss.ml);
      const auto column = static_cast<std::uint32_t>(loss.x_mm * 10);
      const auto row = static_cast<std::uint32_t>(loss.y_mm * 10);
      EXPECT_TRUE(shape.solid(column, row, loss.layer));
    }
    const StackFindings foretold = foretell(shape);
    const IssueGroup& pieces = foretold.of(IssueKind::kFreePiece);
    if (shape.pieces) {
      EXPECT_EQ(pieces.count, *shape.pieces);
    } else {
      EXPECT_GT(pieces.count, IssueGroup::kKept);
    }
    EXPECT_EQ(pieces.count, dropped.size());
    EXPECT_EQ(pieces.voxels, dropped_voxels);
    EXPECT_EQ(foretold.shadowed_voxels, shadowed_voxels);
    for (const Issue& piece : pieces.all_kept()) {
      const Piece expected(piece.first_layer, piece.last_layer, piece.voxels);
      EXPECT_THAT(dropped, testing::Contains(expected));
    }
    // Nothing else is missing: what stayed, dropped or was shadowed is what the masks asked for.
    std::uint64_t asked = 0;
    std::uint64_t stayed = 0;
    std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
    std::uint32_t k = 0;
    plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage cured) {
      draw(shape, k++, BitImage(words, kColumns, kRows));
      asked += BitImage(words, kColumns, kRows).count();
      stayed += cured.count();
    });
    EXPECT_EQ(stayed + dropped_voxels + shadowed_voxels, asked);
  }
}

}  // namespace foretold_test
}  // namespace plumbline
