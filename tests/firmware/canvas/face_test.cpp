#include "firmware/canvas/face.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/canvas/glyph_raster.hpp"

namespace plumbline {
namespace {

const GlyphOutline& glyph_of(const FontOutlines& font, std::uint16_t code) {
  for (const GlyphOutline& glyph : font.glyphs) {
    if (glyph.code == code) return glyph;
  }
  ADD_FAILURE() << code;
  return font.glyphs.front();
}

/// The area of an outline by the shoelace formula, curves in a thousand pieces: font units squared.
double area_of(const FontOutlines& font, const GlyphOutline& glyph) {
  double twice = 0;
  const auto points = font.points.subspan(glyph.first, glyph.count);
  for (std::size_t start = 0, i = 0; i < points.size(); ++i) {
    if ((points[i].flags & OutlinePoint::kLastOfContour) == 0) continue;
    const auto contour = points.subspan(start, i + 1 - start);
    start = i + 1;
    double x = contour[0].x, y = contour[0].y;
    const auto line_to = [&](double to_x, double to_y) {
      twice += x * to_y - to_x * y;
      x = to_x, y = to_y;
    };
    for (std::size_t k = 1; k <= contour.size(); ++k) {
      const OutlinePoint& p = contour[k % contour.size()];
      if ((p.flags & OutlinePoint::kOnCurve) != 0) {
        line_to(p.x, p.y);
        continue;
      }
      const OutlinePoint& end = contour[++k % contour.size()];
      const double from_x = x, from_y = y;
      for (int piece = 1; piece <= 1000; ++piece) {
        const double t = piece / 1000.0;
        line_to((1 - t) * (1 - t) * from_x + 2 * t * (1 - t) * p.x + t * t * end.x,
                (1 - t) * (1 - t) * from_y + 2 * t * (1 - t) * p.y + t * t * end.y);
      }
    }
  }
  return std::abs(twice) / 2;
}

// Letters of one or more contours that don't overlap: then the sum of the covers is the area.
TEST(GlyphRaster, CoversTheAreaOfTheOutline) {
  for (const FontWeight weight : {FontWeight::kRegular, FontWeight::kBold}) {
    const FontOutlines& font = font_outlines(weight);
    for (const char letter : std::string("HOBg8&i%")) {
      const GlyphOutline& glyph = glyph_of(font, static_cast<std::uint16_t>(letter));
      for (const int x_height : {9, 12, 33}) {
        const GlyphPicture picture = rasterise(font, glyph, x_height);
        double cover = 0;
        for (const std::uint8_t level : picture.cover) cover += level / 255.0;
        const double pixel = double{1} * font.x_height / x_height;
        const double area = area_of(font, glyph) / (pixel * pixel);
        EXPECT_NEAR(cover / area, 1, 0.03) << letter << " of " << x_height;
      }
    }
  }
}

TEST(Face, StandsSharpOnItsBaseline) {
  // Multiples of 3 make both an x and a capital whole pixels high.
  for (const int x_height : {9, 12, 18}) {
    const FontOutlines& font = font_outlines(FontWeight::kBold);
    const GlyphPicture capital = rasterise(font, glyph_of(font, 'H'), x_height);
    EXPECT_EQ(-capital.top, x_height * 4 / 3);
    EXPECT_EQ(capital.cover[static_cast<std::size_t>(capital.columns) / 4], 255) << "no grey edge at the top of H";
  }
}

TEST(Face, TakesTextAsUtf8) {
  std::string_view text = "aÄ…\xF0\x9F\x99\x82z\xFF";
  std::vector<std::uint16_t> codes;
  while (!text.empty()) codes.push_back(take_character(text));
  EXPECT_EQ(codes, (std::vector<std::uint16_t>{'a', 0xC4, 0x2026, kUnknownCharacter, 'z', kUnknownCharacter}));
}

TEST(Face, MeasuresWhatItDraws) {
  const Face face(FontWeight::kRegular, 9);
  std::vector<Colour> pixels(std::size_t{400} * 40);
  Canvas canvas(pixels, 400, 40);
  const std::string text = "Größe: 62,1 × 48 mm…";
  EXPECT_EQ(face.draw(canvas, 10, 20, text, 0xFFFF), 10 + face.width(text));
  int last = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 400; ++x) {
      if (pixels[static_cast<std::size_t>(y) * 400 + static_cast<std::size_t>(x)] != 0) last = std::max(last, x);
    }
  }
  EXPECT_LE(last, 10 + face.width(text));
  EXPECT_GE(last, 10 + face.width(text) - 6);
  EXPECT_EQ(face.width("漢"), face.width("\xEF\xBF\xBD")) << "a box for what the font lacks";
}

TEST(Canvas, CutsWhatLeavesIt) {
  std::vector<Colour> pixels(12 * 8, 7);
  const std::span<Colour> all(pixels);
  Canvas canvas(all.subspan(12, 12 * 6), 12, 6);  // a row before and after must stay
  canvas.fill({-5, -5, 100, 100}, 1);
  canvas.frame({-1, -1, 30, 30}, 2, 2);
  const Face face(FontWeight::kBold, 12);
  face.draw(canvas, -7, 3, "W", 3);
  face.draw(canvas, 9, 9, "W", 3);
  const std::vector<std::uint8_t> grey(9, 200);
  canvas.draw_grey({-4, -4, 40, 40}, grey, 3, 3, 0, 0xFFFF);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(pixels[i], 7);
    EXPECT_EQ(pixels[12 * 7 + i], 7);
  }
}

TEST(Canvas, ReducesAPictureToMeans) {
  std::vector<Colour> pixels(4);
  Canvas canvas(pixels, 2, 2);
  const std::vector<std::uint8_t> grey = {0, 255, 255, 255,  //
                                          0, 255, 255, 255,  //
                                          0, 0,   0,   0,    //
                                          0, 0,   255, 255};
  canvas.draw_grey(canvas.all(), grey, 4, 4, 0, 0xFFFF);
  EXPECT_EQ(green_of(pixels[0]) / 4, 32) << "half of it";
  EXPECT_EQ(pixels[1], 0xFFFF);
  EXPECT_EQ(pixels[2], 0);
  EXPECT_EQ(green_of(pixels[3]) / 4, 32);
}

}  // namespace
}  // namespace plumbline
