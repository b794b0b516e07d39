/// What drops on the simulated printer is what the support finder's islands foretell.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "hal/sim/sim_machine.hpp"
#include "slicer/supports/islands.hpp"
#include "tests/hal/small_print.hpp"

namespace plumbline {
namespace {

constexpr std::uint32_t kColumns = 130;
constexpr std::uint32_t kRows = 64;
constexpr std::uint32_t kLayers = 60;
constexpr double kPixelMl = 0.1 * 0.1 * 0.05 / 1000;

struct Shape {
  std::string name;
  std::function<bool(std::uint32_t x, std::uint32_t y, std::uint32_t layer)> solid;
  std::size_t islands = 0;  ///< by looking at it
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

struct Island {
  std::uint32_t layer, column, row;
  bool operator==(const Island&) const = default;
};

/// One layer's mask, drawn anew.
void draw(const Shape& shape, std::uint32_t layer, BitImage image) {
  image.clear();
  for (std::uint32_t y = 0; y < kRows; ++y) {
    for (std::uint32_t x = 0; x < kColumns; ++x) {
      if (shape.solid(x, y, layer)) image.set(x, y);
    }
  }
}

std::vector<Island> foretell(const Shape& shape) {
  std::vector<std::byte> block(std::size_t{1} << 20U);
  Arena arena(block);
  auto finder = IslandFinder::create(kColumns, arena).value();
  std::vector<std::uint64_t> words[3];
  for (auto& image : words) image.resize(BitImage::words_needed(kColumns, kRows), 0);
  std::vector<Island> islands;
  for (std::uint32_t k = 0; k < kLayers; ++k) {
    const BitImage mask(words[0], kColumns, kRows);
    draw(shape, k, mask);
    for (std::size_t i = 0; i < words[0].size(); ++i) words[2][i] = words[0][i] & ~words[1][i];
    const auto found = [&](const IslandFinder::Place& place) { islands.push_back({k, place.column, place.row}); };
    if (k > 0) {
      const Window window{0, kRows, 0, mask.stride()};
      for (std::uint32_t r = 0; r < kRows; ++r) {
        finder.next_row(mask, ConstBitImage(words[1], kColumns, kRows), ConstBitImage(words[2], kColumns, kRows), r,
                        window, found);
      }
      finder.end(found);
    }
    words[1] = words[0];
  }
  return islands;
}

/// Pixels of the regions that no layer above them holds, by flooding the masks.
double foretold_pixels(const Shape& shape) {
  std::vector<bool> held_above(kColumns * kRows, true);
  double loose = 0;
  for (std::uint32_t k = 0; k < kLayers; ++k) {
    std::vector<bool> seen(kColumns * kRows);
    std::vector<bool> held(kColumns * kRows);
    for (std::uint32_t start = 0; start < kColumns * kRows; ++start) {
      if (seen[start] || !shape.solid(start % kColumns, start / kColumns, k)) continue;
      std::vector<std::uint32_t> region{start};
      seen[start] = true;
      bool is_held = false;
      for (std::size_t at = 0; at < region.size(); ++at) {
        const std::uint32_t x = region[at] % kColumns;
        const std::uint32_t y = region[at] / kColumns;
        is_held = is_held || held_above[region[at]];
        const auto visit = [&](std::uint32_t i, std::uint32_t j) {
          if (i >= kColumns || j >= kRows || seen[j * kColumns + i] || !shape.solid(i, j, k)) return;
          seen[j * kColumns + i] = true;
          region.push_back(j * kColumns + i);
        };
        visit(x - 1, y);
        visit(x + 1, y);
        visit(x, y - 1);
        visit(x, y + 1);
      }
      for (const std::uint32_t pixel : region) held[pixel] = is_held;
      if (!is_held) loose += static_cast<double>(region.size());
    }
    held_above = held;
  }
  return loose;
}

TEST(Foretold, IslandsDropWhereTheyBeginWithTheVolumeUntilTheyWouldBeJoined) {
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

    std::vector<Island> dropped;
    double ml = 0;
    double shadow_ml = 0;
    for (const Objection& objection : plant.objections()) {
      ASSERT_TRUE(objection.loss) << to_string(objection);
      const Loss& loss = *objection.loss;
      if (objection.kind == ObjectionKind::kShadowed) {
        shadow_ml += loss.ml;
        continue;
      }
      ASSERT_EQ(objection.kind, ObjectionKind::kDropped) << to_string(objection);
      dropped.push_back(
          {loss.layer, static_cast<std::uint32_t>(loss.x_mm * 10), static_cast<std::uint32_t>(loss.y_mm * 10)});
      ml += loss.ml;
    }
    const auto islands = foretell(shape);
    EXPECT_EQ(dropped.size(), shape.islands);
    ASSERT_EQ(dropped.size(), islands.size());
    for (std::size_t i = 0; i < islands.size(); ++i) {
      EXPECT_EQ(dropped[i].layer, islands[i].layer);
      // Both name the middle of a widest row; there may be several.
      EXPECT_LE(std::abs(int(dropped[i].column) - int(islands[i].column)), 1);
      EXPECT_TRUE(shape.solid(dropped[i].column, dropped[i].row, dropped[i].layer));
    }
    const double foretold = foretold_pixels(shape) * kPixelMl;
    EXPECT_NEAR(ml, foretold, 0.02 * foretold);
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

}  // namespace
}  // namespace plumbline
