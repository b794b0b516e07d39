#include "firmware/canvas/face.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumbline::firmware {
namespace {

/// What a face covers of a text: from 0 to 255, a row after another; (kLeft, kBaseline) is where the text starts.
struct Inked {
  static constexpr int kColumns = 300, kRows = 300, kLeft = 60, kBaseline = 200;

  Inked(const Face& face, std::string_view text) : covers(std::size_t{kColumns} * kRows) {
    face.for_each_pixel(kLeft, kBaseline, text, [&](int x, int y, unsigned cover) {
      ASSERT_TRUE(x >= 0 && y >= 0 && x < kColumns && y < kRows);
      covers[static_cast<std::size_t>(y * kColumns + x)] = cover;
    });
  }
  /// The darkest pixel of a row.
  unsigned darkest(int row) const {
    const auto first = covers.begin() + std::ptrdiff_t{row} * kColumns;
    return *std::max_element(first, first + kColumns);
  }
  std::vector<unsigned> covers;
};

// z and E have strokes along their upper and lower edges.
TEST(Face, StandsSharpOnItsBaseline) {
  for (const FontWeight weight : {FontWeight::kRegular, FontWeight::kBold}) {
    for (const int x_height : {9, 10, 11, 12, 15, 16, 20, 27, 33, 45, 64, 96}) {
      SCOPED_TRACE(x_height);
      const Face face(weight, x_height);
      EXPECT_NEAR(face.cap_height(), x_height * 4 / 3.0, 0.7);
      const bool has_sharp_capitals = x_height < 16 || x_height % 3 == 0;
      for (const auto& [letter, height] : {std::pair("z", x_height), std::pair("E", face.cap_height())}) {
        if (height != x_height && !has_sharp_capitals) continue;
        const Inked inked(face, letter);
        EXPECT_EQ(inked.darkest(Inked::kBaseline), 0U) << letter;
        EXPECT_EQ(inked.darkest(Inked::kBaseline - 1), 255U) << letter;
        EXPECT_EQ(inked.darkest(Inked::kBaseline - height), 255U) << letter;
        EXPECT_EQ(inked.darkest(Inked::kBaseline - height - 1), 0U) << letter;
      }
    }
  }
}

TEST(Face, HasADifferentGlyphForEveryCharacter) {
  const Face face(FontWeight::kRegular, 11);
  std::map<std::vector<unsigned>, std::string_view> known;
  std::string_view text =
      " !\"#$%&'()*+,-./0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`abcdefghijklmnopqrstuvwxyz{|}~"
      "°²µ·ÄÖ×Üßäéöü–“”„…▶⚠✓✖❚\uFFFD";
  while (!text.empty()) {
    std::string_view rest = text;
    take_character(rest);
    const std::string_view character = text.substr(0, text.size() - rest.size());
    const auto& [same, is_new] = known.emplace(Inked(face, character).covers, character);
    EXPECT_TRUE(is_new) << character << " looks like " << same->second;
    text = rest;
  }
}

TEST(Face, FindsTheStartThatFits) {
  const Face face(FontWeight::kRegular, 9);
  const std::string_view text = "Größe";
  EXPECT_EQ(face.start_of(text, face.width(text)), text);
  EXPECT_EQ(face.start_of(text, face.width(text) - 1), "Größ");
  EXPECT_EQ(face.start_of(text, face.width("Grö") - 1), "Gr") << "cuts between characters";
  EXPECT_EQ(face.start_of(text, -1), "");
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
}  // namespace plumbline::firmware
