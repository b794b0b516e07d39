#pragma once
/// Turns the outline of a glyph into pixels. Whole numbers only, so the same on every machine.

#include <cstdint>
#include <vector>

#include "firmware/canvas/glyph_table.hpp"

namespace plumbline {

struct GlyphPicture {
  int left = 0, top = 0;  ///< of its first pixel, from the pen on the baseline; y down
  int columns = 0, rows = 0;
  std::vector<std::uint8_t> cover;  ///< 0 to 255
};

/// Fills an outline by the non-zero winding rule. Each pixel is sampled on eight lines, and its share of each line is exact.
/// @param x_height  pixels of the font's x
GlyphPicture rasterise(const FontOutlines& font, const GlyphOutline& glyph, int x_height);

}  // namespace plumbline
