#pragma once
/// A picture in 8-bit colours, and the texts on it.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/canvas/face.hpp"

namespace plumbline::firmware::inline pictures {

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

struct LabelStyle {
  const Face& face;
  Rgb colour{255, 255, 255};
};

/// Draws one line; (left, top) is the upper left corner of its capitals.
void draw_text(const Picture& picture, std::int64_t left, std::int64_t top, std::string_view text,
               const LabelStyle& style);

}  // namespace plumbline::firmware::inline pictures
