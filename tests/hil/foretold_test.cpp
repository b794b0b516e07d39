/// What drops and tears on the simulated printer is what the sweep of checks foretells.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "hal/sim/sim_machine.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "tests/hal/small_print.hpp"

namespace plumbline::firmware {
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

StackFindings foretell(const Shape& shape, const PeelSettings& peel) {
  const PrintGrid grid{.columns = kColumns,
                       .rows = kRows,
                       .layers = kLayers,
                       .pitch_x_mm = 0.1F,
                       .pitch_y_mm = 0.1F,
                       .layer_height_mm = 0.05F};
  std::vector<std::byte> block(StackChecker::bytes_needed(grid) + 4096);
  Arena arena(block);
  CheckLimits limits;
  limits.peel = peel;
  auto checker = StackChecker::create(grid, limits, arena).value();
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  for (std::uint32_t k = 0; k < kLayers; ++k) {
    draw(shape, k, BitImage(words, kColumns, kRows));
    checker.next(ConstBitImage(words, kColumns, kRows));
  }
  return checker.finish();
}

std::uint64_t voxels(double ml) { return static_cast<std::uint64_t>(std::llround(ml / kPixelMl)); }

MATCHER_P(IsForetoldBy, piece, "") {
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-5 * a; };
  return arg.layer == piece.first_layer && arg.last_layer == piece.last_layer && voxels(arg.ml) == piece.voxels &&
         near(arg.asked_n, static_cast<double>(piece.asked_n)) && near(arg.held_n, static_cast<double>(piece.held_n));
}

/// Prints a shape, and compares what is lost with what the sweep foretells.
/// @returns number of pieces that tore off
std::size_t compare(const Shape& shape, const PeelSettings& peel) {
  SCOPED_TRACE(shape.name);
  PlantSettings settings;
  settings.panel.columns = kColumns;
  settings.panel.rows = kRows;
  settings.panel.pitch_x_mm = settings.panel.pitch_y_mm = 0.1;
  settings.peel = peel;
  Plant plant(settings);
  SimMachine machine(plant);
  const auto draw_layer = [&](std::uint32_t k, BitImage image) { draw(shape, k, image); };
  EXPECT_TRUE(print_layers(machine.machine(), {.layers = kLayers, .draw = draw_layer}));
  plant.conclude(JobEnd::kFinished);

  std::vector<Loss> dropped, torn;
  std::uint64_t lost_voxels = 0;
  std::uint64_t shadowed_voxels = 0;
  for (const Objection& objection : plant.objections()) {
    if (!objection.loss) {
      ADD_FAILURE() << to_string(objection);
      continue;
    }
    const Loss& loss = *objection.loss;
    if (loss.kind == LossKind::kShadowed) {
      shadowed_voxels += voxels(loss.ml);
      continue;
    }
    (loss.kind == LossKind::kDropped ? dropped : torn).push_back(loss);
    lost_voxels += voxels(loss.ml);
    const auto column = static_cast<std::uint32_t>(loss.x_mm * 10);
    const auto row = static_cast<std::uint32_t>(loss.y_mm * 10);
    EXPECT_TRUE(shape.solid(column, row, loss.layer));
  }
  const StackFindings foretold = foretell(shape, peel);
  if (shape.pieces && torn.empty()) {
    EXPECT_EQ(dropped.size(), *shape.pieces);
  }
  EXPECT_EQ(foretold.shadowed_voxels, shadowed_voxels);
  EXPECT_EQ(foretold.of(IssueKind::kFreePiece).voxels + foretold.of(IssueKind::kTear).voxels, lost_voxels);
  const auto expect_alike = [&](IssueKind kind, const std::vector<Loss>& lost) {
    EXPECT_EQ(foretold.count(kind), lost.size()) << words_of(kind).key;
    for (const Issue& piece : foretold.of(kind).all_kept()) {
      EXPECT_THAT(lost, testing::Contains(IsForetoldBy(piece))) << words_of(kind).key;
      EXPECT_TRUE(shape.solid(piece.column, piece.row, piece.layer));
    }
  };
  expect_alike(IssueKind::kFreePiece, dropped);
  expect_alike(IssueKind::kTear, torn);
  // Nothing else is missing: what stayed, was lost or was shadowed is what the masks asked for.
  std::uint64_t asked = 0;
  std::uint64_t stayed = 0;
  std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
  std::uint32_t k = 0;
  plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage cured) {
    draw(shape, k++, BitImage(words, kColumns, kRows));
    asked += BitImage(words, kColumns, kRows).count();
    stayed += cured.count();
  });
  EXPECT_EQ(stayed + lost_voxels + shadowed_voxels, asked);
  return torn.size();
}

TEST(Foretold, FreePiecesDropInTheirLayersWithTheirVolumeAndTheirShadow) {
  PeelSettings strong;  // nothing tears
  strong.green_strength_mpa = strong.plate_adhesion_mpa = 1e6;
  std::vector<Shape> all = shapes();
  for (std::uint32_t seed = 0; seed < 12; ++seed) all.push_back(balls(seed));
  for (const Shape& shape : all) EXPECT_EQ(compare(shape, strong), 0U);
}

TEST(Foretold, PiecesTearOffInTheirLayersWithTheirForcesAndTheirVolume) {
  const std::vector<Shape> weak = {
      {"table on one leg", [](auto x, auto y, auto k) { return away(x, y, 60, 30) < (k < 20 ? 2 : 28); }, 0},
      {"hourglass", [](auto x, auto y, auto k) { return away(x, y, 60, 30) < 2 + std::abs(k - 30.0); }, 0},
      {"table on legs of different strength",
       [](auto x, auto y, auto k) {
         if (k >= 30) return x > 10 && x < 110 && y > 10 && y < 54;
         return away(x, y, 20, 20) < 2 || away(x, y, 100, 20) < 3 || (away(x, y, 20, 45) < 2 + 0.1 * k);
       },
       0},
      {"cup",  // its floor is at the film
       [](auto x, auto y, auto k) {
         const double r = away(x, y, 60, 32);
         return r < (k < 10 ? 4 : 30) && (k < 14 || r > 26);
       },
       0},
      {"two blobs on one twig",
       [](auto x, auto y, auto k) {
         if (k < 25) return away(x, y, 60, 30) < 1.6;
         if (k < 30) return y > 28 && y < 33 && x > 20 && x < 100;
         return away(x, y, 25, 30) < 0.7 * (k - 28) || away(x, y, 95, 30) < 0.5 * (k - 28);
       },
       0},
  };
  std::size_t torn = 0;
  for (const Shape& shape : weak) torn += compare(shape, {});
  EXPECT_GE(torn, weak.size());
  // From everything tears to nothing.
  for (const double strength : {0.01, 0.03, 0.1}) {
    PeelSettings peel;
    peel.green_strength_mpa = 5 * strength;
    peel.plate_adhesion_mpa = strength;
    for (const Shape& shape : shapes()) torn += compare(shape, peel);
    for (std::uint32_t seed = 0; seed < 4; ++seed) torn += compare(balls(seed), peel);
  }
  EXPECT_GT(torn, 50U);
}

}  // namespace foretold_test
}  // namespace plumbline::firmware
