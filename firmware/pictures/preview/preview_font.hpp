#pragma once
/// Text on pictures, in a font of 5 x 9 dots drawn for it.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace plumbline {

using Rgb = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// 8-bit RGB, rows from the top; a view.
struct Picture {
  std::span<std::uint8_t> rgb;  ///< 3 * columns * rows bytes
  std::uint32_t columns = 0, rows = 0;

  /// Mixes `colour` into a pixel; pixels outside the picture are ignored.
  /// @param cover  0 leaves the pixel, 1 replaces it
  void blend(std::int64_t column, std::int64_t row, const Rgb& colour, float cover) const;
  /// Fills columns [left, left + width) of rows [top, top + height), as far as they are inside.
  void fill(std::int64_t left, std::int64_t top, std::int64_t width, std::int64_t height, const Rgb& colour) const;
};

/// A line of text, its edges smoothed.
struct LabelStyle {
  std::uint32_t scale = 2;  ///< picture pixels a dot, 1 or more
  Rgb colour{255, 255, 255};

  std::uint32_t advance() const { return 6 * scale; }  ///< pixels from one character to the next
};

/// Pixels that `text` is wide.
std::uint32_t text_width(std::string_view text, const LabelStyle& style);

/// Draws one line; (left, top) is the corner of the first capital. ASCII; every other byte is drawn as a box.
void draw_text(const Picture& picture, std::int64_t left, std::int64_t top, std::string_view text,
               const LabelStyle& style);

}  // namespace plumbline
