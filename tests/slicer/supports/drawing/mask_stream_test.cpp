#include "slicer/supports/drawing/mask_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "slicer/supports/support_finder.hpp"
#include "tests/slicer/support/solid.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace mask_stream_test {

using namespace testing;

constexpr double kPitch = 0.1;  ///< mm, of pixels and layers

/// A block on the plate, a smaller one on top of it, and 60 random struts, some of which lie.
struct Scene {
  Scene() : solid(cubic_grid(128, 40), blocks({{50, 78, 0, 128, 0, 20}, {60, 68, 50, 60, 20, 38}})) {
    Random random(5);
    for (int i = 0; i < 60; ++i) {
      Strut s;
      s.column0 = static_cast<std::uint16_t>(random.below(128));
      s.row0 = static_cast<std::uint16_t>(random.below(128));
      s.column1 = static_cast<std::uint16_t>(i % 3 == 0 ? s.column0 : random.below(128));
      s.row1 = static_cast<std::uint16_t>(i % 3 == 0 ? s.row0 : random.below(128));
      s.first = static_cast<std::uint16_t>(random.below(2) * random.below(30));
      s.end = static_cast<std::uint16_t>(std::min(40U, s.first + random.below(25)));
      s.radius0 = static_cast<std::uint16_t>(random.below(1500));
      s.radius1 = static_cast<std::uint16_t>(random.below(1500));
      if (i % 7 == 0) s.radius0 = s.radius1 = static_cast<std::uint16_t>(3000 + 20 * i);  // wider than half a word
      s.lies = i % 5 == 1 ? 1 : 0;
      list.push_back(s);
    }
    std::sort(list.begin(), list.end(), [](const Strut& a, const Strut& b) { return a.first < b.first; });
    supports = {list, PixelPitch(solid.rrep.grid)};
  }
  /// The object's mask with the section of each strut in the layer, by distances from its axis.
  Pixels mask_by_definition(const Pixels& object, std::uint32_t layer) const {
    Pixels mask = object;
    for (const Strut& s : list) {
      if (!s.is_in(layer)) continue;
      const double t = (layer + 0.5 - s.first) / (s.end - s.first);
      const double radius = (s.radius0 + t * (s.radius1 - s.radius0)) / 1000;
      const double ax = s.lies != 0 ? s.column0 : s.column0 + std::round(t * (s.column1 - s.column0));
      const double ay = s.lies != 0 ? s.row0 : s.row0 + std::round(t * (s.row1 - s.row0));
      const double bx = s.lies != 0 ? s.column1 : ax;
      const double by = s.lies != 0 ? s.row1 : ay;
      const double square = (bx - ax) * (bx - ax) + (by - ay) * (by - ay);
      for (std::uint32_t r = 0; r < 128; ++r) {
        for (std::uint32_t c = 0; c < 128; ++c) {
          const double along = square > 0 ? ((c - ax) * (bx - ax) + (r - ay) * (by - ay)) / square : 0;
          const double at = std::clamp(along, 0.0, 1.0);
          const double dx = (c - ax - at * (bx - ax)) * kPitch;
          const double dy = (r - ay - at * (by - ay)) * kPitch;
          if (dx * dx + dy * dy <= (radius + 1e-6) * (radius + 1e-6)) mask.set(c, r, true);
        }
      }
    }
    return mask;
  }

  Solid solid;
  std::vector<Strut> list;
  Supports supports;
};

TEST(MaskStream, DrawsTheSupportsIntoTheObjectsMasks) {
  const Scene scene;
  const auto object = scene.solid.masks();
  ArenaBlock arena(4 * kMiB);
  MaskStream stream = value_of(MaskStream::create(scene.solid.rrep, scene.supports, *arena));
  EXPECT_EQ(arena->bottom_used(), MaskStream::bytes_needed(scene.solid.rrep.grid, scene.list.size()));
  for (std::uint32_t k = 0; k < 40; ++k) {
    ASSERT_EQ(Pixels(stream.mask(k)), scene.mask_by_definition(object[k], k)) << "layer " << k;
    EXPECT_EQ(stream.support_pixels(), 0U);
  }
}

TEST(MaskStream, CountsThePixelsOfSupportsIfItIsToldTo) {
  const Scene scene;
  const auto object = scene.solid.masks();
  const auto masks = scene.solid.masks(&scene.supports);
  ArenaBlock arena(4 * kMiB);
  MaskStream stream = value_of(MaskStream::create(scene.solid.rrep, scene.supports, *arena, true));
  for (std::uint32_t k = 0; k < 40; ++k) {
    ASSERT_EQ(Pixels(stream.mask(k)), masks[k]) << "layer " << k;
    EXPECT_EQ(stream.support_pixels(), masks[k].count() - object[k].count());
  }
}

TEST(MaskStream, DrawsAnyLayerInAnyOrder) {
  const Scene scene;
  const auto masks = scene.solid.masks(&scene.supports);
  ArenaBlock arena(4 * kMiB);
  MaskStream stream = value_of(MaskStream::create(scene.solid.rrep, scene.supports, *arena));
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t k = random.below(40);
    ASSERT_EQ(Pixels(stream.mask(k)), masks[k]) << "layer " << k;
    ASSERT_EQ(Pixels(stream.mask(k)), masks[k]) << "layer " << k << " again";
  }
}

TEST(MaskStream, GivesTheObjectsMasksWithoutSupports) {
  const Scene scene;
  const Supports none{{}, scene.supports.pitch};
  EXPECT_EQ(scene.solid.masks(&none), scene.solid.masks());
  ArenaBlock arena(4 * kMiB);
  ASSERT_TRUE(MaskStream::create(scene.solid.rrep, none, *arena).has_value());
  EXPECT_EQ(arena->bottom_used(), LayerStream::bytes_needed(scene.solid.rrep.grid));
}

TEST(MaskStream, IsRefusedIfItsListDoesNotFit) {
  const Scene scene;
  const std::size_t bytes = MaskStream::bytes_needed(scene.solid.rrep.grid, scene.list.size());
  ArenaBlock arena(bytes - Arena::kAlignment);
  const auto stream = MaskStream::create(scene.solid.rrep, scene.supports, *arena);
  ASSERT_FALSE(stream.has_value());
  EXPECT_EQ(stream.error().code(), ErrorCode::kOutOfMemory);
}

}  // namespace mask_stream_test
}  // namespace plumbline
