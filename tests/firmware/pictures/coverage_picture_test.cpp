#include "firmware/pictures/coverage_picture.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <vector>

#include "tests/slicer/support/solid.hpp"

namespace plumbline::firmware {
namespace {

using namespace testing;

/// A box whose sides and top were scanned, and whose underside was closed.
struct ScannedBox {
  ScannedBox() {
    Box3f bounds;
    bounds.extend(Vec3f(2, 4, 0));
    bounds.extend(Vec3f(8, 6, 3));
    map = ConfidenceMap::create(solid.rrep.grid, bounds, 0.2F, arena).value();
    for (std::uint32_t r = 40; r < 60; ++r) {
      for (std::uint32_t c = 20; c < 80; ++c) map.add(c, r, 0, Evidence::kBase);
    }
    for (float x = 2; x < 8; x += 0.05F) {
      for (float y = 4; y < 6; y += 0.05F) map.add_point({x, y, 2.99F});
      for (float z = 0.5F; z < 3; z += 0.05F) {
        map.add_point({x, 4, z});
        map.add_point({x, 6, z});
      }
    }
  }
  std::vector<std::byte> memory{std::size_t{64} << 20U};
  Arena arena{memory};
  Solid solid{PrintGrid{100, 100, 30, 0.1F, 0.1F, 0.1F}, blocks({{20, 80, 40, 60, 0, 30}})};
  ConfidenceMap map;
};

/// Pixels of the views in which one channel is far above the other.
std::size_t count_tinted(std::span<const std::uint8_t> rgb, std::size_t strong, std::size_t weak) {
  std::size_t count = 0;
  for (std::size_t at = 0; at < std::size_t{3} * 1600 * 780; at += 3)
    count += rgb[at + strong] > rgb[at + weak] + 60 ? 1 : 0;
  return count;
}

TEST(CoveragePicture, ShowsTheUndersideBlueAndTheRestAsScanned) {
  ScannedBox box;
  const std::size_t used = box.arena.used();
  std::vector<std::uint8_t> rgb(std::size_t{3} * 1600 * 900), again(rgb.size());
  ASSERT_TRUE(draw_coverage(box.solid.rrep, box.map, "box.ply", box.arena, rgb));
  EXPECT_EQ(box.arena.used(), used);
  const std::size_t blue = count_tinted(rgb, 2, 0), red = count_tinted(rgb, 0, 2);
  EXPECT_GT(blue, std::size_t{1600} * 780 / 60) << "the view from below";
  EXPECT_LT(blue, std::size_t{1600} * 780 / 4);
  EXPECT_LT(red, blue / 4) << "all else was scanned";

  const int usual = omp_get_max_threads();
  omp_set_num_threads(usual == 1 ? 3 : 1);
  ASSERT_TRUE(draw_coverage(box.solid.rrep, box.map, "box.ply", box.arena, again));
  omp_set_num_threads(usual);
  EXPECT_EQ(again, rgb) << "whatever the number of threads";

  std::vector<std::byte> little(100'000);
  Arena small(little);
  EXPECT_FALSE(draw_coverage(box.solid.rrep, box.map, "box.ply", small, rgb));
}

}  // namespace
}  // namespace plumbline::firmware
