#pragma once
/// Turns the picture of a status screen and converts it to what is sent to its panel.

#include <cstddef>
#include <cstdint>
#include <span>

namespace plumbline::inline hal::inline linux_board {

struct ScreenLayout {
  std::uint32_t columns = 0, rows = 0;  ///< of the picture
  std::uint32_t rotation_deg = 0;       ///< counter-clockwise, from the picture to what is sent: 0, 90, 180 or 270
  std::uint32_t bits = 24;              ///< of a pixel that is sent: 16 is RGB565, 24 is XRGB8888, both little endian

  std::uint32_t sent_columns() const { return rotation_deg % 180 == 0 ? columns : rows; }
  std::uint32_t sent_rows() const { return rotation_deg % 180 == 0 ? rows : columns; }
};

/// Where a pixel that is sent comes from, and the other way round: a touch panel reports places on the panel.
struct ScreenPlace {
  std::uint32_t column = 0, row = 0;
  bool operator==(const ScreenPlace&) const = default;
};
/// @param sent  column and row of what is sent
/// @returns the place in the picture
ScreenPlace place_in_picture(const ScreenLayout& layout, const ScreenPlace& sent);

/// Writes each pixel once, in order: display memory is slow to read.
/// @param pixels  RGB565, columns * rows
/// @param out     sent_rows() rows of `pitch` bytes, pitch a multiple of 4
void pack_screen(const ScreenLayout& layout, std::span<const std::uint16_t> pixels, std::span<std::byte> out,
                 std::size_t pitch);

}  // namespace plumbline::inline hal::inline linux_board
