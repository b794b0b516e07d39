#include "firmware/pictures/mask_window.hpp"

#include <algorithm>

namespace plumbline::firmware::inline pictures {

void draw_mask_window(ConstBitImage mask, std::span<const GreyRun> greys, ConstBitImage section,
                      const MaskWindow& window, MaskPicture& picture) {
  picture.clear();
  if (window.column >= mask.columns() || window.row >= mask.rows()) return;
  const std::uint32_t columns = mask.columns() - window.column, rows = mask.rows() - window.row;
  MaskSquares part = squares_of(window.column, window.row, columns, rows, MaskSquares::kMost);
  if (window.step > 0) {
    part.side = std::min(window.step, 64U);
    part.columns = std::min((columns + part.side - 1) / part.side, MaskSquares::kMost);
    part.rows = std::min((rows + part.side - 1) / part.side, MaskSquares::kMost);
  }
  picture.columns = part.columns;
  picture.rows = part.rows;
  const auto out = picture.bytes();
  std::ranges::fill(out, std::uint8_t{0});
  const auto at = [&](std::uint32_t x, std::uint32_t y) { return 3 * (std::size_t{y} * part.columns + x); };
  const auto level = [](std::uint64_t sum, std::uint32_t pixels) {
    return static_cast<std::uint8_t>((sum * 255 + pixels / 2) / pixels);
  };
  const auto lit = [&](std::uint32_t row, std::size_t word) { return mask.row(row)[word]; };
  for_each_square(mask, part, lit, [&](std::uint32_t x, std::uint32_t y, std::uint32_t count, std::uint32_t pixels) {
    out[at(x, y)] = level(count, pixels);
  });
  if (section.columns() > 0) {
    const auto added = [&](std::uint32_t row, std::size_t word) {
      return mask.row(row)[word] & ~section.row(row)[word];
    };
    for_each_square(mask, part, added,
                    [&](std::uint32_t x, std::uint32_t y, std::uint32_t count, std::uint32_t pixels) {
                      out[at(x, y) + 1] = level(count, pixels);
                    });
  }
  for (const GreyRun& run : greys) {
    const std::uint32_t row = run.pixel / mask.columns(), first = run.pixel % mask.columns();
    if (row < part.row || (row - part.row) / part.side >= part.rows) continue;
    for (std::uint32_t column = std::max(first, part.column); column < first + run.count; ++column) {
      const std::uint32_t x = (column - part.column) / part.side;
      if (x >= part.columns) break;
      const std::uint32_t y = (row - part.row) / part.side;
      const std::uint32_t pixels = part.pixels(mask, x, y);
      const int more = (int{run.level} - (mask.at(column, row) ? 255 : 0)) / static_cast<int>(pixels);
      std::uint8_t& light = out[at(x, y)];
      light = static_cast<std::uint8_t>(std::clamp(int{light} + more, 0, 255));
    }
  }
}

}  // namespace plumbline::firmware::inline pictures
