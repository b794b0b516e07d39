#include "firmware/canvas/face.hpp"

#include <freetype/freetype.h>

#include <algorithm>
#include <array>
#include <memory>
#include <new>

namespace plumbline::firmware::inline canvas {
namespace {

/// ASCII and Latin-1, for the languages of western Europe, then what texts of plumbline and the buttons need besides, by code.
constexpr std::array<std::array<std::uint16_t, 2>, 2> kRanges{{{0x20, 0x7E}, {0xA1, 0xFF}}};
constexpr std::u16string_view kFurther = u"–“”„…▶⚠✓✖❚\uFFFD";
static_assert(std::is_sorted(kFurther.begin(), kFurther.end()) && kFurther.back() == kUnknownCharacter);

/// Below this x-height glyphs are hinted, upwards only: rows are sharp, shapes and widths stay those of the font. Above it, hinting would
/// round an x to another height than was asked for, and rows are sharp enough without it.
constexpr int kLeastUnhinted = 16;
/// Levels of cover above 0. Nobody sees the difference to 255, and a picture of a screen has few colours, so that its PNG is small.
constexpr unsigned kLevels = 15;

/// A font file that is part of the program fails only where the heap has no room.
void check(FT_Error error) {
  if (error != FT_Err_Ok) throw std::bad_alloc();
}

struct FreeFont {
  void operator()(FT_Library library) const { FT_Done_FreeType(library); }
  void operator()(FT_Face face) const { FT_Done_Face(face); }
};
using Library = std::unique_ptr<FT_LibraryRec_, FreeFont>;
using FontFace = std::unique_ptr<FT_FaceRec_, FreeFont>;

Library open_library() {
  FT_Library library = nullptr;
  check(FT_Init_FreeType(&library));
  return Library(library);
}

FontFace open_font(const Library& library, FontWeight weight, int x_height) {
  const auto file = font_file(weight);
  FT_Face face = nullptr;
  check(FT_New_Memory_Face(library.get(), file.data(), static_cast<FT_Long>(file.size()), 0, &face));
  FontFace font(face);
  // The size whose x is so high.
  check(FT_Load_Char(face, 'x', FT_LOAD_NO_SCALE));
  const FT_Fixed scale = FT_DivFix(FT_Long{x_height} * 64, face->glyph->metrics.horiBearingY);
  FT_Size_RequestRec size{FT_SIZE_REQUEST_TYPE_SCALES, scale, scale, 0, 0};
  check(FT_Request_Size(face, &size));
  return font;
}

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
  const Library library = open_library();
  const FontFace font = open_font(library, weight, x_height);
  const FT_Int32 load =
      FT_LOAD_RENDER | FT_LOAD_NO_BITMAP | (x_height < kLeastUnhinted ? FT_LOAD_TARGET_LIGHT : FT_LOAD_NO_HINTING);
  const FT_GlyphSlotRec& slot = *font->glyph;
  const auto pixels = [](FT_Pos parts) { return static_cast<int>((parts + 32) / 64); };
  const auto add = [&](std::uint16_t code) {
    check(FT_Load_Char(font.get(), code, load));
    const FT_Bitmap& bitmap = slot.bitmap;
    glyphs_.push_back({code, static_cast<std::int16_t>(pixels(slot.advance.x)),
                       static_cast<std::int16_t>(slot.bitmap_left), static_cast<std::int16_t>(-slot.bitmap_top),
                       static_cast<std::int16_t>(bitmap.width), static_cast<std::int16_t>(bitmap.rows),
                       static_cast<std::uint32_t>(covers_.size())});
    for (unsigned row = 0; row < bitmap.rows; ++row) {
      const unsigned char* cover = bitmap.buffer + static_cast<std::ptrdiff_t>(row) * bitmap.pitch;
      for (unsigned column = 0; column < bitmap.width; ++column, ++cover) {
        covers_.push_back(static_cast<std::uint8_t>((*cover * kLevels + 127) / 255 * (255 / kLevels)));
      }
    }
  };
  for (const auto& [first, last] : kRanges) {
    for (std::uint16_t code = first; code <= last; ++code) add(code);
  }
  for (const char16_t code : kFurther) add(code);
  covers_.shrink_to_fit();
  check(FT_Load_Char(font.get(), 'H', load));
  cap_height_ = pixels(slot.metrics.horiBearingY);
  line_height_ = cap_height_ + descent_ + (x_height * 2 + 2) / 5;
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

std::string_view Face::start_of(std::string_view text, int width) const {
  std::string_view rest = text;
  while (!rest.empty()) {
    std::string_view after = rest;
    width -= glyph(take_character(after)).advance;
    if (width < 0) break;
    rest = after;
  }
  return text.substr(0, text.size() - rest.size());
}

int Face::draw(Canvas& canvas, int x, int baseline, std::string_view text, Colour ink) const {
  return for_each_pixel(x, baseline, text,
                        [&](int column, int row, unsigned cover) { canvas.blend(column, row, ink, cover); });
}

}  // namespace plumbline::firmware::inline canvas
