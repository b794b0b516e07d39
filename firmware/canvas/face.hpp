#pragma once
/// The font in one size: its glyphs are drawn once by FreeType, when it is made, and blended from then on.

#include <cstdint>
#include <string_view>
#include <vector>

#include "firmware/canvas/canvas.hpp"
#include "firmware/canvas/font_file.hpp"

namespace plumbline::firmware::inline canvas {

/// What is shown for a character that a face lacks.
inline constexpr std::uint16_t kUnknownCharacter = 0xFFFD;

/// Takes the next character off the front of UTF-8 text.
/// @pre text is not empty. @returns kUnknownCharacter for what is no UTF-8 or beyond 16 bits
std::uint16_t take_character(std::string_view& text);

/// The same pixels on x86-64 and aarch64. On armv7 FreeType rounds otherwise: of large glyphs, 1 pixel in 10,000 differs by 1/15.
class Face {
 public:
  /// Takes all its memory here, and needs neither FreeType nor the font file afterwards.
  /// @param x_height  pixels of an x, 4 to 96. A multiple of 3, or one below 16, makes capitals (4/3 of it) sharp at both ends, too
  Face(FontWeight weight, int x_height);

  int x_height() const { return x_height_; }
  int cap_height() const { return cap_height_; }
  /// Pixels from one baseline to the next.
  int line_height() const { return line_height_; }
  /// Pixels below the baseline that letters such as g take.
  int descent() const { return descent_; }
  /// Pixels from the start of a text to its end.
  int width(std::string_view text) const;
  /// The longest start of a text that is not wider than `width`.
  std::string_view start_of(std::string_view text, int width) const;

  /// Calls put(x, y, cover) for each pixel that a text covers, 1 to 255 of it.
  /// @returns x of whatever follows
  template <class Put>
  int for_each_pixel(int x, int baseline, std::string_view text, Put&& put) const {
    while (!text.empty()) {
      const Glyph& shape = glyph(take_character(text));
      const std::uint8_t* cover = covers_.data() + shape.first;
      for (int row = 0; row < shape.rows; ++row) {
        for (int column = 0; column < shape.columns; ++column, ++cover) {
          if (*cover > 0) put(x + shape.left + column, baseline + shape.top + row, *cover);
        }
      }
      x += shape.advance;
    }
    return x;
  }
  /// @returns x of whatever follows
  int draw(Canvas& canvas, int x, int baseline, std::string_view text, Colour ink) const;

 private:
  struct Glyph {
    std::uint16_t code;
    std::int16_t advance;
    std::int16_t left, top;  ///< of the picture, from the pen and the baseline; y down
    std::int16_t columns, rows;
    std::uint32_t first;  ///< of covers_
  };
  const Glyph& glyph(std::uint16_t code) const;

  std::vector<Glyph> glyphs_;         ///< by code
  std::vector<std::uint8_t> covers_;  ///< 0 to 255
  int x_height_, cap_height_ = 0, line_height_ = 0, descent_;
};

}  // namespace plumbline::firmware::inline canvas
