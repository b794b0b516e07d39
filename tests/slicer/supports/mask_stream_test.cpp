#include "slicer/supports/mask_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "slicer/supports/support_finder.hpp"
#include "tests/slicer/support/solid.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kPitch = 0.1;  ///< mm, of pixels and layers

/// Radius of a support in the middle of a layer, mm, by the definition in supports.hpp.
double radius_by_definition(const SupportSettings& s, const Support& support, std::uint32_t layer) {
  const double head = s.head_front_diameter / 2;
  const double pillar = s.pillar_diameter / 2;
  const double base = s.base_diameter / 2;
  if (layer >= support.tip) return head;
  const double z = (layer + 0.5) * kPitch;
  const auto cone = [&](double height) { return head + (pillar - head) * height / s.head_width; };
  const double radius = std::min(pillar, cone(support.tip * kPitch - z));
  if (support.first > 0) return std::min(radius, cone(z - support.first * kPitch));
  const double height = std::min(s.base_height, support.tip * kPitch / 3);
  return z < height ? std::max(radius, base - (base - pillar) * z / height) : radius;
}

/// A block on the plate, a smaller one on top of it, and 40 random supports, some of which start above the plate.
struct Scene {
  Scene() : solid(cubic_grid(128, 40), blocks({{50, 78, 0, 128, 0, 20}, {60, 68, 50, 60, 20, 38}})) {
    Random random(5);
    for (int i = 0; i < 40; ++i) {
      Support s;
      s.column = static_cast<std::uint16_t>(random.below(128));
      s.row = static_cast<std::uint16_t>(random.below(128));
      s.first = static_cast<std::uint16_t>(random.below(2) * random.below(30));
      s.tip = static_cast<std::uint16_t>(std::min(38U, s.first + 1 + random.below(25)));
      s.end = static_cast<std::uint16_t>(s.tip + random.below(3));
      list.push_back(s);
    }
    std::sort(list.begin(), list.end(), [](const Support& a, const Support& b) { return a.first < b.first; });
    supports = {list, SupportShape(settings, solid.rrep.grid)};
  }
  /// The object's mask with the disc of each support in the layer.
  Pixels mask_by_definition(const Pixels& object, std::uint32_t layer) const {
    Pixels mask = object;
    for (const Support& s : list) {
      if (!s.is_in(layer)) continue;
      const double radius = radius_by_definition(settings, s, layer) + 1e-6;
      for (std::uint32_t r = 0; r < 128; ++r) {
        for (std::uint32_t c = 0; c < 128; ++c) {
          const double dx = (static_cast<double>(c) - s.column) * kPitch;
          const double dy = (static_cast<double>(r) - s.row) * kPitch;
          if (dx * dx + dy * dy <= radius * radius) mask.set(c, r, true);
        }
      }
    }
    return mask;
  }

  SupportSettings settings;
  Solid solid;
  std::vector<Support> list;
  Supports supports;
};

TEST(MaskStream, DrawsTheSupportsIntoTheObjectsMasks) {
  const Scene scene;
  const auto object = scene.solid.masks();
  ArenaBlock arena(4 * kMiB);
  MaskStream stream = value_of(MaskStream::create(scene.solid.rrep, scene.supports, *arena));
  EXPECT_EQ(arena->bottom_used(), MaskStream::bytes_needed(scene.solid.rrep.grid, scene.list.size()));
  for (std::uint32_t k = 0; k < 40; ++k) {
    const Pixels mask(stream.mask(k));
    ASSERT_EQ(mask, scene.mask_by_definition(object[k], k)) << "layer " << k;
    EXPECT_EQ(stream.support_pixels(), mask.count() - object[k].count());
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
  const Supports none{{}, scene.supports.shape};
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

}  // namespace
}  // namespace plumbline
