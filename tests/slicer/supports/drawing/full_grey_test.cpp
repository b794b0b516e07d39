#include "slicer/supports/drawing/full_grey.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/drawing/vertical_grey.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/columns.hpp"

namespace plumbline {
namespace full_grey_test {

using namespace testing;

constexpr std::uint32_t kColumns = 100, kRows = 70, kLayers = 40;
/// From where to where a ray is inside, in layers, at a place in pixels.
using Heights = std::function<std::optional<std::pair<double, double>>(double x, double y)>;

RRep ray_of(PrintGrid grid, std::uint32_t ray, const Heights& heights, Arena& arena) {
  if (ray > 0) grid = with_ray(grid, ray);
  const CrossingPacking packing(grid);
  std::vector<std::vector<std::uint32_t>> layers(grid.layers);
  for (std::uint32_t pixel = 0; pixel < grid.columns * grid.rows; ++pixel) {
    const auto inside = heights(pixel % grid.columns + static_cast<double>(grid.ray_x),
                                pixel / grid.columns + static_cast<double>(grid.ray_y));
    if (!inside) continue;
    for (const double z : {inside->first, inside->second}) {
      const CrossingHeight at = height_of(static_cast<float>(z) * grid.layer_height_mm, grid);
      if (at.layer() < grid.layers) layers[at.layer()].push_back(packing.packed(pixel, at.part()));
    }
  }
  const auto first = value_of(arena.take_bottom<std::uint32_t>(grid.layers + 1, "test"));
  std::vector<std::uint32_t> packed;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    first[k] = static_cast<std::uint32_t>(packed.size());
    packed.insert(packed.end(), layers[k].begin(), layers[k].end());
  }
  first[grid.layers] = static_cast<std::uint32_t>(packed.size());
  const auto words = value_of(arena.take_bottom<std::uint32_t>(packed.size(), "test"));
  std::ranges::copy(packed, words.begin());
  return {.grid = grid, .first = first, .packed = words, .is_exact = true};
}

/// All rays of an object, and the levels of its masks.
class Object {
 public:
  /// @param base  ray 0; none: as the others
  explicit Object(const Heights& heights, const std::optional<Heights>& base = {}) {
    rrep_ = ray_of(grid_, 0, base.value_or(heights), *arena_);
    for (std::uint32_t i = 0; i < others_.size(); ++i) others_[i] = ray_of(grid_, i + 1, heights, *arena_);
    rrep_.others = others_.data();
  }

  const RRep& rrep() const { return rrep_; }
  /// @returns [layer][pixel], 0 to 255
  std::vector<std::vector<std::uint32_t>> levels(const CureModel& model, const Supports& supports = {}) {
    const BottomScope scope(*arena_);
    auto stream = value_of(MaskStream::create(rrep_, supports, *arena_));
    auto grey = value_of(FullGrey::create(rrep_, supports, model, kColumnLayer, *arena_));
    std::vector<GreyRun> room(kColumns * kRows);
    GreyRuns greys(room, kColumns);
    std::vector<std::uint64_t> words(BitImage::words_needed(kColumns, kRows));
    const BitImage image(words, kColumns, kRows);
    std::vector<std::vector<std::uint32_t>> all(kLayers, std::vector<std::uint32_t>(kColumns * kRows));
    for (std::uint32_t k = 0; k < kLayers; ++k) {
      const ConstBitImage mask = stream.mask(k);
      std::ranges::copy(mask.words(), words.begin());
      grey.find(k, stream.section(), mask, image, greys);
      for (std::uint32_t p = 0; p < kColumns * kRows; ++p) {
        all[k][p] = image.at(p % kColumns, p / kColumns) ? kFullLevel : 0;
      }
      for (const GreyRun& run : greys.runs()) {
        for (std::uint32_t p = run.pixel; p < run.end(); ++p) {
          EXPECT_EQ(all[k][p] == kFullLevel, run.level >= kLeastCuringLevel) << "its bit";
          all[k][p] = run.level;
        }
      }
    }
    return all;
  }

 private:
  PrintGrid grid_{.columns = kColumns, .rows = kRows, .layers = kLayers};
  ArenaBlock arena_{4 * kMiB};
  RRep rrep_;
  std::array<RRep, kRaysAround> others_;
};

std::uint32_t at(std::uint32_t column, std::uint32_t row) { return row * kColumns + column; }

CureModel without_bottom() {
  CureModel model = standard_resin();
  model.bottom_layers = model.faded_layers = 0;
  return model;
}

TEST(FullGrey, AWallAtAQuarterOfAPixelHasThatLevel) {
  constexpr std::array<std::uint32_t, 4> kLevels = {0, 64, 128, 191};
  for (std::uint32_t across = 0; across < 4; ++across) {
    for (std::uint32_t along = 0; along < 4; ++along) {
      Object box([&](double x, double y) {
        const bool inside = x > 10 && x < 66 + across / 4.0 && y > 20 && y < 50 + along / 4.0;
        return inside ? std::optional(std::pair(0.0, 30.0)) : std::nullopt;
      });
      const auto levels = box.levels(without_bottom());
      for (const std::uint32_t k : {0U, 10U, 28U}) {
        for (std::uint32_t row = 22; row < 48; ++row) EXPECT_EQ(levels[k][at(66, row)], kLevels[across]) << k;
        for (std::uint32_t c = 12; c < 64; ++c) EXPECT_EQ(levels[k][at(c, 50)], kLevels[along]) << k;
        EXPECT_EQ(levels[k][at(30, 30)], 255U);
        EXPECT_EQ(levels[k][at(65, 30)], 255U);
        EXPECT_EQ(levels[k][at(68, 30)], 0U);
        EXPECT_EQ(levels[k][at(9, 30)], 0U);
      }
    }
  }
}

TEST(FullGrey, HasTheCoverageOfACylinderToAnEighth) {
  const auto inside = [](double x, double y) {
    return (x - 47.3) * (x - 47.3) + (y - 33.8) * (y - 33.8) < 25.0 * 25.0;
  };
  Object cylinder(
      [&](double x, double y) { return inside(x, y) ? std::optional(std::pair(0.0, 30.0)) : std::nullopt; });
  const auto levels = cylinder.levels(without_bottom());
  double off = 0, sum = 0, whole = 0;
  std::uint32_t walls = 0;
  for (std::uint32_t p = 0; p < kColumns * kRows; ++p) {
    constexpr int kFine = 32;
    int covered = 0;
    for (int i = 0; i < kFine * kFine; ++i) {
      covered += inside(p % kColumns + (i % kFine + 0.5) / kFine, p / kColumns + (i / kFine + 0.5) / kFine) ? 1 : 0;
    }
    const double exact = static_cast<double>(covered) / (kFine * kFine), found = levels[10][p] / 255.0;
    sum += found;
    whole += exact;
    if (covered == 0 || covered == kFine * kFine) {
      EXPECT_EQ(found, exact) << p % kColumns << ", " << p / kColumns;
      continue;
    }
    ++walls;
    off += std::abs(found - exact);
  }
  EXPECT_GT(walls, 150U);
  EXPECT_LT(off / walls, 0.125);
  EXPECT_NEAR(sum / whole, 1, 0.002);
}

TEST(FullGrey, LeavesTopsAndBottomLayersOfOneBit) {
  const CureModel model = standard_resin();
  Object box([&](double x, double y) {
    // A wall at three quarters, and beyond it a step that ends in layer 20.
    const double end = x < 66.75 ? 30.0 : 20.0;
    return x > 10 && x < 80.6 && y > 20 && y < 50 ? std::optional(std::pair(0.0, end)) : std::nullopt;
  });
  const auto levels = box.levels(model);
  for (std::uint32_t k = 0; k < model.bottom_layers + model.faded_layers; ++k) {
    for (const std::uint32_t level : levels[k]) EXPECT_TRUE(level == 0 || level == 255) << k;
    EXPECT_EQ(levels[k][at(80, 30)], 255U) << "half of its rays are inside";
  }
  EXPECT_EQ(levels[18][at(80, 30)], 128U);
  EXPECT_EQ(levels[19][at(80, 30)], 255U) << "the last layer of the step";
  EXPECT_EQ(levels[19][at(66, 30)], 255U) << "whole below the step's edge";
  EXPECT_EQ(levels[20][at(66, 30)], 191U);
  EXPECT_EQ(levels[29][at(66, 30)], 255U) << "the last layer of all";
}

TEST(FullGrey, HasTheLevelsOfVerticalGreyBelowAFlatUnderside) {
  for (const double height : {12.1, 12.4, 12.6, 12.9}) {
    Object slab([&](double x, double y) {
      return x > 10 && x < 66 && y > 20 && y < 50 ? std::optional(std::pair(height, 30.0)) : std::nullopt;
    });
    const auto levels = slab.levels(without_bottom());
    ArenaBlock arena(4 * kMiB);
    auto stream = value_of(MaskStream::create(slab.rrep(), {}, *arena));
    auto vertical = value_of(VerticalGrey::create(slab.rrep(), {}, without_bottom(), kColumnLayer, *arena));
    std::vector<GreyRun> room(kColumns * kRows);
    GreyRuns greys(room, kColumns);
    const ConstBitImage mask = stream.mask(12);
    vertical.find(12, stream.section(), mask, greys);
    ASSERT_EQ(greys.runs().size(), 30U) << height;
    for (const GreyRun& run : greys.runs()) EXPECT_EQ(levels[12][run.pixel + 20], run.level) << height;
  }
}

TEST(FullGrey, BringsNothingBackThatIsNotInTheMaskOfRay0) {
  const auto slab = [](double x, double y) { return x > 10 && x < 66.5 && y > 20 && y < 50; };
  const auto heights = [&](double x, double y) {
    const bool speck = x > 80 && x < 90 && y > 30 && y < 40;
    return slab(x, y) || speck ? std::optional(std::pair(0.0, 30.0)) : std::nullopt;
  };
  Object object(heights,
                [&](double x, double y) { return slab(x, y) ? std::optional(std::pair(0.0, 30.0)) : std::nullopt; });
  const auto levels = object.levels(without_bottom());
  EXPECT_EQ(levels[10][at(66, 30)], 128U);
  for (std::uint32_t c = 70; c < kColumns; ++c) EXPECT_EQ(levels[10][at(c, 35)], 0U) << c;
}

TEST(FullGrey, IsWhiteWhereASupportIs) {
  Object box([](double x, double y) {
    return x > 10 && x < 66.5 && y > 20 && y < 50 ? std::optional(std::pair(0.0, 30.0)) : std::nullopt;
  });
  const std::vector<Strut> list = {
      {.column0 = 66, .row0 = 30, .column1 = 66, .row1 = 30, .first = 0, .end = 20, .radius0 = 200, .radius1 = 200}};
  const auto levels = box.levels(without_bottom(), Supports{list, PixelPitch(box.rrep().grid)});
  EXPECT_EQ(levels[10][at(66, 30)], 255U);
  EXPECT_EQ(levels[10][at(66, 45)], 128U);
}

}  // namespace full_grey_test
}  // namespace plumbline
