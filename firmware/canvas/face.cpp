#include "firmware/canvas/face.hpp"

#include <algorithm>
#include <utility>

#include "firmware/canvas/glyph_raster.hpp"

namespace plumbline {
namespace {

/// Bytes that begin a character of 2 or 3 bytes, by their highest bits.
constexpr bool begins_two(unsigned char byte) { return (byte & 0xE0U) == 0xC0U; }
constexpr bool begins_three(unsigned char byte) { return (byte & 0xF0U) == 0xE0U; }
constexpr bool continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

}  // namespace

std::uint16_t take_character(std::string_view& text) {
  const auto first = static_cast<unsigned char>(text.front());
  const auto low = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(text[i]) & 0x3FU); };
  std::size_t size = 1;
  unsigned code = first < 0x80 ? first : unsigned{kUnknownCharacter};
  if (begins_two(first) && text.size() > 1 && continues(text[1])) {
    size = 2;
    code = (first & 0x1FU) << 6 | low(1);
  } else if (begins_three(first) && text.size() > 2 && continues(text[1]) && continues(text[2])) {
    size = 3;
    code = (first & 0x0FU) << 12 | low(1) << 6 | low(2);
  } else {
    while (size < text.size() && continues(text[size])) ++size;  // one box for each character of 4 bytes
  }
  text.remove_prefix(size);
  return static_cast<std::uint16_t>(code);
}

// DejaVu's own descent is for all its scripts. This is that of g and of brackets.
Face::Face(FontWeight weight, int x_height) : x_height_(x_height), descent_((x_height * 3 + 5) / 7) {
  const FontOutlines& font = font_outlines(weight);
  const auto pixels = [&](int units) { return (2 * units * x_height + font.x_height) / (2 * font.x_height); };
  cap_height_ = pixels(font.cap_height);
  line_height_ = cap_height_ + descent_ + (x_height * 2 + 2) / 5;
  for (const GlyphOutline& outline : font.glyphs) {
    const GlyphPicture picture = rasterise(font, outline, x_height);
    glyphs_.push_back({outline.code, static_cast<std::int16_t>(pixels(outline.advance)),
                       static_cast<std::int16_t>(picture.left), static_cast<std::int16_t>(picture.top),
                       static_cast<std::int16_t>(picture.columns), static_cast<std::int16_t>(picture.rows),
                       static_cast<std::uint32_t>(covers_.size())});
    covers_.insert(covers_.end(), picture.cover.begin(), picture.cover.end());
  }
  covers_.shrink_to_fit();
}

const Face::Glyph& Face::glyph(std::uint16_t code) const {
  const auto found = std::lower_bound(glyphs_.begin(), glyphs_.end(), code,
                                      [](const Glyph& glyph, std::uint16_t wanted) { return glyph.code < wanted; });
  // The last one stands for what the font lacks: its code is the highest.
  return found != glyphs_.end() && found->code == code ? *found : glyphs_.back();
}

int Face::width(std::string_view text) const {
  int width = 0;
  while (!text.empty()) width += glyph(take_character(text)).advance;
  return width;
}

int Face::draw(Canvas& canvas, int x, int baseline, std::string_view text, Colour ink) const {
  while (!text.empty()) {
    const Glyph& shape = glyph(take_character(text));
    const std::uint8_t* cover = covers_.data() + shape.first;
    for (int row = 0; row < shape.rows; ++row) {
      for (int column = 0; column < shape.columns; ++column, ++cover) {
        if (*cover > 0) canvas.blend(x + shape.left + column, baseline + shape.top + row, ink, *cover);
      }
    }
    x += shape.advance;
  }
  return x;
}

}  // namespace plumbline
