#pragma once
/// A font in one size: its glyphs are drawn once, when it is made, and blended from then on.

#include <cstdint>
#include <string_view>
#include <vector>

#include "firmware/canvas/canvas.hpp"
#include "firmware/canvas/glyph_table.hpp"

namespace plumbline {

/// Takes the next character off the front of UTF-8 text.
/// @pre text is not empty. @returns kUnknownCharacter for what is no UTF-8 or beyond 16 bits
std::uint16_t take_character(std::string_view& text);

class Face {
 public:
  /// Takes all its memory here.
  /// @param x_height  pixels of an x, 4 to 96. A multiple of 3 makes capitals (4/3 of it) sharp at both ends, too
  Face(FontWeight weight, int x_height);

  int x_height() const { return x_height_; }
  int cap_height() const { return cap_height_; }
  /// Pixels from one baseline to the next.
  int line_height() const { return line_height_; }
  /// Pixels below the baseline that letters such as g take.
  int descent() const { return descent_; }
  /// Pixels from the start of a text to its end.
  int width(std::string_view text) const;

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
  int x_height_, cap_height_, line_height_, descent_;
};

}  // namespace plumbline
