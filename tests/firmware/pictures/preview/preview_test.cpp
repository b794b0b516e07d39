#include "firmware/pictures/preview/preview.hpp"

#include <gtest/gtest.h>
#include <lodepng.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline::firmware {
namespace {

using namespace testing;

struct Drawing {
  explicit Drawing(const RRep& rrep, const PreviewText& text = {}, const Supports& supports = {})
      : rgb(std::size_t{3} * kPreviewColumns * kPreviewRows), memory(preview_bytes(rrep.grid) + Arena::kAlignment) {
    Arena arena(memory);
    status = draw_preview(rrep, supports, text, arena, rgb);
    peak = arena.peak();
    left = arena.used();
  }
  bool same(const Drawing& other, std::uint32_t column, std::uint32_t row) const {
    const std::size_t at = 3 * (std::size_t{row} * kPreviewColumns + column);
    return std::equal(rgb.begin() + std::ptrdiff_t(at), rgb.begin() + std::ptrdiff_t(at + 3),
                      other.rgb.begin() + std::ptrdiff_t(at));
  }
  int brightness(std::uint32_t column, std::uint32_t row) const {
    const std::size_t at = 3 * (std::size_t{row} * kPreviewColumns + column);
    return rgb[at] + rgb[at + 1] + rgb[at + 2];
  }
  std::vector<std::uint8_t> rgb;
  std::vector<std::byte> memory;
  Status status;
  std::size_t peak = 0, left = 0;
};

struct Stretch {
  std::uint32_t begin, end;
  std::uint32_t length() const { return end - begin; }
};
/// Stretches of a row that differ from the empty page.
std::vector<Stretch> runs(const Drawing& drawing, const Drawing& empty, std::uint32_t row) {
  std::vector<Stretch> found;
  for (std::uint32_t c = 0; c < kPreviewColumns; ++c) {
    if (drawing.same(empty, c, row)) continue;
    if (found.empty() || found.back().end != c) found.push_back({c, c});
    found.back().end = c + 1;
  }
  return found;
}

// Below the title and the scale, above the captions.
constexpr std::uint32_t kFirstRow = 125, kLastRow = 730;

TEST(Preview, ShowsASphereAsThreeEqualDiscs) {
  const Solid solid(cubic_grid(220, 220), ball(110, 110, 110, 100)), air(cubic_grid(220, 220), blocks({}));
  const Drawing drawing(solid.rrep), empty(air.rrep);
  ASSERT_TRUE(drawing.status.has_value());
  double area = 0;
  std::uint32_t rows = 0, widest = 0;
  std::vector<double> centres;
  for (std::uint32_t row = kFirstRow; row < kLastRow; ++row) {
    const auto found = runs(drawing, empty, row);
    if (found.size() != 3 || found[1].length() != found[0].length()) {
      if (widest > 0) break;  // reached the ground line and the labels below it
      continue;
    }
    EXPECT_EQ(found[2].length(), found[0].length());
    for (std::size_t k = 0; k < 3; ++k) {
      const double centre = 0.5 * (found[k].begin + found[k].end);
      if (centres.size() < 3) centres.push_back(centre);
      EXPECT_NEAR(centre, centres[k], 1.01);
    }
    area += found[0].length();
    widest = std::max(widest, found[0].length());
    ++rows;
  }
  EXPECT_GT(widest, 250U);
  EXPECT_NEAR(rows, widest, 4);
  EXPECT_NEAR(area / (widest * widest), 3.14159265 / 4, 0.02);
}

TEST(Preview, LightsASphereFromTheUpperLeft) {
  const Solid solid(cubic_grid(220, 220), ball(110, 110, 110, 100)), air(cubic_grid(220, 220), blocks({}));
  const Drawing drawing(solid.rrep), empty(air.rrep);
  const auto middle = runs(drawing, empty, 430);
  ASSERT_EQ(middle.size(), 3U);
  for (const Stretch& disc : middle) {
    const std::uint32_t centre = (disc.begin + disc.end) / 2, third = disc.length() / 3;
    const int lit = drawing.brightness(centre - third / 2, 430 - third);
    EXPECT_GT(lit, drawing.brightness(centre, 430));
    EXPECT_GT(drawing.brightness(centre, 430), drawing.brightness(centre + third, 430 + third / 2));
    EXPECT_GT(lit, 2 * empty.brightness(centre, 430));
  }
}

TEST(Preview, ShowsTheNearSideUnmirrored) {
  // A wall 12 x 8 x 16 mm with a block on its near, left, upper corner: x small, y small, z large.
  const PrintGrid grid{160, 120, 200, 0.1F, 0.1F, 0.1F};
  const Solid solid(grid, blocks({{20, 140, 60, 100, 0, 120}, {20, 50, 20, 100, 80, 160}}));
  const Solid air(grid, blocks({}));
  const Drawing drawing(solid.rrep), empty(air.rrep);
  // The uppermost row of the front and the side view holds the block alone.
  for (std::uint32_t row = kFirstRow; row < kLastRow; ++row) {
    const auto upper = runs(drawing, empty, row);
    if (upper.size() < 2) continue;
    const auto lower = runs(drawing, empty, row + 500);
    ASSERT_GE(lower.size(), 2U);
    EXPECT_NEAR(upper[0].begin, lower[0].begin, 2);              // front: x to the right, block at the left
    EXPECT_NEAR(upper[0].length() * 4.0, lower[0].length(), 8);  // 3 of 12 mm
    EXPECT_NEAR(upper[1].length(), 2.0 * lower[1].length(), 8);  // side: 8 mm above, the wall's 4 mm below
    EXPECT_NEAR(upper[1].begin, lower[1].begin, 2);              // -y to the right: the block sticks out there
    return;
  }
  FAIL() << "nothing drawn";
}

TEST(Preview, ShowsAHoleFromAbove) {
  const PrintGrid grid{200, 200, 20, 0.1F, 0.1F, 0.1F};
  const Solid solid(grid, [](std::uint32_t column, std::uint32_t row, std::uint32_t layer) {
    const double radius = std::hypot(column + 0.5 - 100, row + 0.5 - 100);
    return layer < 15 && radius < 90 && radius > 40;
  });
  const Solid air(grid, blocks({}));
  const Drawing drawing(solid.rrep), empty(air.rrep);
  std::uint32_t row = kFirstRow;
  std::vector<Stretch> at_hole;
  for (; row < kLastRow; ++row) {  // find the last row where the ring is split by a hole of 8 mm in 18
    const auto found = runs(drawing, empty, row);
    if (found.size() == 2 && found[0].begin > kPreviewColumns / 2) {
      if (at_hole.empty() || found[1].begin - found[0].end > at_hole[1].begin - at_hole[0].end) at_hole = found;
    }
  }
  ASSERT_EQ(at_hole.size(), 2U);
  const double whole = at_hole[1].end - at_hole[0].begin, hole = at_hole[1].begin - at_hole[0].end;
  EXPECT_NEAR(hole / whole, 8.0 / 18.0, 0.02);
}

TEST(Preview, KeepsTheShapeIfPixelsAreNotSquare) {
  const PrintGrid grid{440, 110, 88, 0.05F, 0.2F, 0.25F};
  const Solid solid(grid, [](std::uint32_t column, std::uint32_t row, std::uint32_t layer) {
    return std::hypot((column + 0.5) * 0.05 - 11, (row + 0.5) * 0.2 - 11, (layer + 0.5) * 0.25 - 11) < 10;
  });
  const Solid air(grid, blocks({}));
  const Drawing drawing(solid.rrep), empty(air.rrep);
  const auto middle = runs(drawing, empty, 430);
  ASSERT_EQ(middle.size(), 3U);
  EXPECT_NEAR(middle[0].length(), middle[1].length(), 6);
  EXPECT_NEAR(middle[0].length(), middle[2].length(), 6);
}

TEST(Preview, DrawsObjectsOfAnyShapeInsideThePage) {
  for (const PrintGrid& grid : {PrintGrid{4, 3, 2000, 0.1F, 0.1F, 0.1F}, PrintGrid{3000, 3, 2, 0.1F, 0.1F, 0.1F},
                                PrintGrid{3, 3000, 2, 0.1F, 0.1F, 0.1F}, PrintGrid{1, 1, 1, 0.05F, 0.05F, 0.05F},
                                PrintGrid{5000, 10, 1, 0.01F, 0.01F, 0.01F}}) {
    const Solid full(grid, blocks({{0, grid.columns, 0, grid.rows, 0, grid.layers}}));  // to the top of the last layer
    const Solid air(grid, blocks({}));
    const Drawing drawing(full.rrep), empty(air.rrep);
    ASSERT_TRUE(drawing.status.has_value());
    EXPECT_NE(drawing.rgb, empty.rgb);
    for (std::uint32_t row = 0; row < kPreviewRows; ++row) {
      EXPECT_TRUE(drawing.same(empty, 0, row));
      EXPECT_TRUE(drawing.same(empty, kPreviewColumns - 1, row));
    }
  }
}

/// A sphere above the plate, held by one pillar under its lowest point.
struct SphereOnAPillar {
  SphereOnAPillar() : solid(cubic_grid(220, 220), ball(110, 110, 110, 60)) {
    supports = {list, PixelPitch(solid.rrep.grid)};
  }
  Solid solid;
  const std::vector<Strut> list{{.column0 = 110,
                                 .row0 = 110,
                                 .column1 = 110,
                                 .row1 = 110,
                                 .first = 0,
                                 .end = 10,
                                 .radius0 = 2000,
                                 .radius1 = 500},
                                {.column0 = 110,
                                 .row0 = 110,
                                 .column1 = 110,
                                 .row1 = 110,
                                 .first = 10,
                                 .end = 52,
                                 .radius0 = 500,
                                 .radius1 = 500}};
  Supports supports;
};

TEST(Preview, LeavesThePrintBehindASupportInTheLight) {
  // A wall with a strip of another material far before its middle, from top to bottom.
  constexpr std::uint32_t kColumns = 200, kRows = 100, kPixels = kColumns / kSamplesPerPixel * kRows / kSamplesPerPixel;
  constexpr std::array<Rgb, 2> kWhiteAndBlack{{{255, 255, 255}, {0, 0, 0}}};
  std::vector<float> depth(kColumns * kRows), scratch(depth.size());
  std::vector<std::uint8_t> materials(depth.size());
  const DepthMap map{depth, materials, kColumns, kRows};
  const auto least_beside = [&](bool with_strip, std::optional<std::uint8_t> shadowless) {
    for (std::uint32_t row = 0; row < kRows; ++row) {
      for (std::uint32_t column = 0; column < kColumns; ++column) {
        const bool strip = with_strip && column >= 60 && column < 70;
        map.show(column, row, strip ? -40.0F : 0.0F, strip);
      }
    }
    std::vector<std::uint8_t> rgb(3 * kPixels);
    shade_depth(map, scratch, {rgb, kColumns / kSamplesPerPixel, kRows / kSamplesPerPixel}, 0, 0, kWhiteAndBlack,
                shadowless);
    int least = 255;
    for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
      const std::size_t column = pixel % (kColumns / kSamplesPerPixel);
      if (column < 30 || column >= 35) least = std::min<int>(least, rgb[3 * pixel]);
    }
    return least;
  };
  EXPECT_LT(least_beside(true, {}), least_beside(false, {}) * 3 / 4) << "or this test shows nothing";
  EXPECT_EQ(least_beside(true, 1), least_beside(false, {}));
}

TEST(Preview, ShowsSupportsInAnotherColour) {
  const SphereOnAPillar scene;
  const Solid air(cubic_grid(220, 220), blocks({}));
  const Drawing drawing(scene.solid.rrep, {}, scene.supports), empty(air.rrep);
  ASSERT_TRUE(drawing.status.has_value());
  std::size_t blue = 0, cream = 0;
  double blue_row = 0, cream_row = 0;
  for (std::uint32_t row = kFirstRow; row < kLastRow; ++row) {
    for (std::uint32_t column = 0; column < kPreviewColumns / 2; ++column) {  // front and side
      if (drawing.same(empty, column, row)) continue;
      const std::size_t at = 3 * (std::size_t{row} * kPreviewColumns + column);
      const int warmth = drawing.rgb[at] - drawing.rgb[at + 2];
      if (warmth < -20) {
        ++blue;
        blue_row += row;
      } else if (warmth > 4) {
        ++cream;
        cream_row += row;
      }
    }
  }
  EXPECT_GT(blue, 500U);
  EXPECT_GT(cream, 10 * blue);
  EXPECT_GT(blue_row / static_cast<double>(blue), cream_row / static_cast<double>(cream)) << "the pillar is below";
}

TEST(Preview, WritesTheSizeThatItIsGivenUpperRight) {
  const SphereOnAPillar scene;
  const Drawing with(scene.solid.rrep, {.name = {}, .size = "10.00 x 10.00 x 14.00 mm", .captions = {}}),
      without(scene.solid.rrep);
  std::size_t differences = 0;
  for (std::uint32_t row = 40; row < 80; ++row) {
    for (std::uint32_t column = kPreviewColumns / 2; column < kPreviewColumns; ++column) {
      differences += with.same(without, column, row) ? 0 : 1;
    }
  }
  EXPECT_GT(differences, 100U);
}

TEST(Preview, HasTheSamePixelsWithAnyNumberOfThreads) {
  const Solid solid(cubic_grid(150, 150, 0.2F), ball(75, 75, 75, 65));
  const int usual = omp_get_max_threads();
  omp_set_num_threads(1);
  const Drawing alone(solid.rrep);
  omp_set_num_threads(3);
  const Drawing together(solid.rrep);
  omp_set_num_threads(usual);
  EXPECT_EQ(alone.rgb, together.rgb);
}

TEST(Preview, TakesThePlannedMemoryAndReturnsIt) {
  const Solid solid(cubic_grid(100, 100, 0.2F), ball(50, 50, 50, 45));
  const Drawing drawing(solid.rrep);
  EXPECT_EQ(drawing.peak, preview_bytes(solid.rrep.grid));
  EXPECT_EQ(drawing.left, 0U);
}

TEST(Preview, ReportsAnArenaThatIsTooSmall) {
  const Solid solid(cubic_grid(100, 100, 0.2F), ball(50, 50, 50, 45));
  std::vector<std::byte> memory(preview_bytes(solid.rrep.grid) / 2);
  std::vector<std::uint8_t> rgb(std::size_t{3} * kPreviewColumns * kPreviewRows);
  Arena arena(memory);
  const Status status = draw_preview(solid.rrep, {}, {}, arena, rgb);
  ASSERT_FALSE(status.has_value());
  EXPECT_EQ(status.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_EQ(arena.used(), 0U);
}

TEST(Preview, EncodesTheSamePixelsAsPng) {
  const Solid solid(cubic_grid(100, 100, 0.2F), ball(50, 50, 50, 45));
  const std::string_view captions[] = {"one line", "and another"};
  const PreviewText text{"sphere.ply", "24.0 x 24.0 x 24.0 mm", captions};
  const Drawing drawing(solid.rrep, text);
  std::vector<std::byte> memory(preview_bytes(solid.rrep.grid) + kPageBytes + 4 * Arena::kAlignment);
  Arena arena(memory);
  auto encoder = PictureEncoder::create(kPageBytes);
  ASSERT_TRUE(encoder.has_value());
  const auto png = encode_page(
      arena, *encoder, [&](std::span<std::uint8_t> rgb) { return draw_preview(solid.rrep, {}, text, arena, rgb); });
  ASSERT_TRUE(png.has_value());
  EXPECT_EQ(arena.used(), 0U);
  std::vector<unsigned char> decoded;
  unsigned columns = 0, rows = 0;
  ASSERT_EQ(lodepng::decode(decoded, columns, rows, reinterpret_cast<const unsigned char*>(png->data()), png->size(),
                            LCT_RGB, 8),
            0U);
  EXPECT_EQ(columns, kPreviewColumns);
  EXPECT_EQ(rows, kPreviewRows);
  EXPECT_EQ(decoded, drawing.rgb);
}

TEST(Preview, CutsTextThatIsLongerThanThePage) {
  const Solid solid(cubic_grid(20, 20, 0.2F), ball(10, 10, 10, 9));
  const std::string long_text(5000, 'W');
  const std::string_view captions[] = {long_text, long_text, long_text, long_text};
  const Drawing drawing(solid.rrep, {long_text, {}, captions}), plain(solid.rrep);
  ASSERT_TRUE(drawing.status.has_value());
  EXPECT_NE(drawing.rgb, plain.rgb);
  for (std::uint32_t row = 0; row < kPreviewRows; ++row) EXPECT_TRUE(drawing.same(plain, kPreviewColumns - 1, row));
}

TEST(Picture, IgnoresPixelsOutsideIt) {
  // The picture lies between two guards.
  constexpr std::ptrdiff_t kBytes = 3 * 10 * 10;
  std::vector<std::uint8_t> memory(3 * kBytes, 77);
  const std::span<std::uint8_t> rgb = std::span(memory).subspan(kBytes, kBytes);
  draw_text({rgb, 10, 10}, -30, -7, "ABCDEFGHIJ", {preview::page_faces().title});
  draw_text({rgb, 10, 10}, 8, 8, "\xC3\xA9W", {preview::page_faces().plain});
  EXPECT_LT(std::ranges::count(rgb, 77), kBytes) << "nothing drawn where the text overlaps the picture";
  EXPECT_EQ(std::ranges::count(std::span(memory).first(kBytes), 77), kBytes);
  EXPECT_EQ(std::ranges::count(std::span(memory).last(kBytes), 77), kBytes);
}

}  // namespace
}  // namespace plumbline::firmware
