#include "hal/linux/screen/pack_screen.hpp"

#include <cassert>
#include <cstring>

namespace plumbline::inline hal::inline linux_board {
namespace {

/// Widens to 8 bits a channel, so that 0 stays 0 and the highest value 255.
constexpr std::uint32_t widened(std::uint16_t pixel) {
  const std::uint32_t red = pixel >> 11U, green = pixel >> 5U & 63U, blue = pixel & 31U;
  return (red << 3U | red >> 2U) << 16U | (green << 2U | green >> 4U) << 8U | (blue << 3U | blue >> 2U);
}

}  // namespace

ScreenPlace place_in_picture(const ScreenLayout& layout, const ScreenPlace& sent) {
  switch (layout.rotation_deg) {
    case 90: return {layout.columns - 1 - sent.row, sent.column};
    case 180: return {layout.columns - 1 - sent.column, layout.rows - 1 - sent.row};
    case 270: return {sent.row, layout.rows - 1 - sent.column};
    default: return sent;
  }
}

void pack_screen(const ScreenLayout& layout, std::span<const std::uint16_t> pixels, std::span<std::byte> out,
                 std::size_t pitch) {
  const std::uint32_t columns = layout.sent_columns(), rows = layout.sent_rows();
  const std::size_t bytes = layout.bits == 16 ? 2 : 4;
  assert(pixels.size() == std::size_t{columns} * rows && pitch >= bytes * columns && out.size() >= pitch * rows);
  for (std::uint32_t row = 0; row < rows; ++row) {
    std::byte* to = out.data() + row * pitch;
    // Along a row of what is sent the picture is crossed in steps of one pixel or of one row, forwards or backwards.
    const ScreenPlace first = place_in_picture(layout, {0, row});
    const std::uint16_t* from = pixels.data() + std::size_t{first.row} * layout.columns + first.column;
    std::ptrdiff_t step = 1;
    if (layout.rotation_deg == 90) step = layout.columns;
    if (layout.rotation_deg == 180) step = -1;
    if (layout.rotation_deg == 270) step = -static_cast<std::ptrdiff_t>(layout.columns);
    for (std::uint32_t column = 0; column < columns; ++column, to += bytes) {
      const std::uint16_t pixel = from[static_cast<std::ptrdiff_t>(column) * step];
      const std::uint32_t wide = widened(pixel);
      if (bytes == 2) {
        std::memcpy(to, &pixel, 2);
      } else {
        std::memcpy(to, &wide, 4);
      }
    }
  }
}

}  // namespace plumbline::inline hal::inline linux_board
