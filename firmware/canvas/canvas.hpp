#pragma once
/// A picture of 16-bit colours in the caller's memory, and what is drawn in it. Everything is cut at its edges. Nothing allocates.

#include <cstdint>
#include <span>

namespace plumbline::firmware::inline canvas {

/// RGB565: 5 bits of red, 6 of green, 5 of blue, red in the highest.
using Colour = std::uint16_t;

/// @param red, green, blue  0 to 255
constexpr Colour colour(unsigned red, unsigned green, unsigned blue) {
  return static_cast<Colour>((red >> 3) << 11 | (green >> 2) << 5 | blue >> 3);
}
/// Widens each channel to 0 to 255. Black and full brightness stay exact.
constexpr std::uint8_t red_of(Colour c) { return static_cast<std::uint8_t>((c >> 11) * 255U / 31U); }
constexpr std::uint8_t green_of(Colour c) { return static_cast<std::uint8_t>((c >> 5 & 63U) * 255U / 63U); }
constexpr std::uint8_t blue_of(Colour c) { return static_cast<std::uint8_t>((c & 31U) * 255U / 31U); }

/// Pixels; (0, 0) is the picture's upper left corner.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;

  constexpr int right() const { return x + width; }
  constexpr int bottom() const { return y + height; }
  constexpr bool empty() const { return width <= 0 || height <= 0; }
  constexpr PixelBox inset(int across, int down) const {
    return {x + across, y + down, width - 2 * across, height - 2 * down};
  }
  /// The upper `rows` rows; from_row() has the others.
  constexpr PixelBox top_rows(int rows) const { return {x, y, width, rows}; }
  constexpr PixelBox from_row(int rows) const { return {x, y + rows, width, height - rows}; }
  constexpr PixelBox left_columns(int columns) const { return {x, y, columns, height}; }
  constexpr PixelBox from_column(int columns) const { return {x + columns, y, width - columns, height}; }
  constexpr bool operator==(const PixelBox&) const = default;
};

/// @returns empty where they don't meet
PixelBox common(const PixelBox& a, const PixelBox& b);

class Canvas {
 public:
  /// @param pixels  columns * rows, row after row from the top
  Canvas(std::span<Colour> pixels, int columns, int rows);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  PixelBox all() const { return {0, 0, columns_, rows_}; }
  std::span<Colour> pixels() const { return pixels_; }

  void fill(const PixelBox& box, Colour ink);
  /// The edges of a box, drawn inside it.
  void frame(const PixelBox& box, int thickness, Colour ink);
  /// @param cover  0: nothing, 255: all of the pixel
  void blend(int x, int y, Colour ink, unsigned cover);
  /// Shows a picture of grey levels, enlarged or reduced to the box: 0 is `dark`, 255 `light`. A pixel shows the mean of those that it
  /// covers.
  /// @param grey  columns * rows
  void draw_grey(const PixelBox& box, std::span<const std::uint8_t> grey, int columns, int rows, Colour dark,
                 Colour light);
  /// Shows a picture in the same way.
  /// @param rgb  3 * columns * rows
  void draw_rgb(const PixelBox& box, std::span<const std::uint8_t> rgb, int columns, int rows);

 private:
  std::span<Colour> pixels_;
  int columns_;
  int rows_;
};

/// The largest box with a picture's proportions in the middle of another one.
PixelBox fitted(const PixelBox& room, int columns, int rows);

}  // namespace plumbline::firmware::inline canvas
