#pragma once
/// Discs of pixels, by integers only.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// Lengths are nanometres, so that squares of 30 mm still fit into 64 bits.
using Nanometres = std::int64_t;

/// @param mm  0 to 1000
inline Nanometres nanometres(double mm) { return static_cast<Nanometres>(std::floor(mm * 1e6 + 0.5)); }

struct PixelPitch {
  Nanometres x = 1, y = 1;

  PixelPitch() = default;
  explicit PixelPitch(const PrintGrid& grid)
      : x(nanometres(static_cast<double>(grid.pitch_x_mm))), y(nanometres(static_cast<double>(grid.pitch_y_mm))) {}
};

/// Calls visit(dy, reach) for dy = 0, 1, ...: in the rows dy above and below its centre, a disc round a pixel's centre
/// holds the pixels up to `reach` columns to the left and right: (reach * pitch.x)^2 + (dy * pitch.y)^2 <= radius^2.
/// @param radius  nm, 0 to 3e8
template <class Visit>
void for_each_disc_row(const PixelPitch& pitch, Nanometres radius, Visit visit) {
  Nanometres reach = radius / pitch.x;
  for (Nanometres dy = 0; dy * pitch.y <= radius; ++dy) {
    const Nanometres up = dy * pitch.y;
    while ((reach * pitch.x) * (reach * pitch.x) + up * up > radius * radius) --reach;
    visit(static_cast<std::uint32_t>(dy), static_cast<std::uint32_t>(reach));
  }
}

/// Calls visit(row, begin, end) for the pixels of a disc round (column, row), as far as they are on the grid: columns
/// [begin, end), never none.
template <class Visit>
void for_each_disc_span(const PixelPitch& pitch, std::uint32_t column, std::uint32_t row, Nanometres radius,
                        std::uint32_t columns, std::uint32_t rows, Visit visit) {
  for_each_disc_row(pitch, radius, [&](std::uint32_t dy, std::uint32_t reach) {
    const std::uint32_t begin = column - std::min(column, reach);
    const std::uint32_t end = std::min(columns, column + reach + 1);
    if (dy <= row) visit(row - dy, begin, end);
    if (dy > 0 && row + dy < rows) visit(row + dy, begin, end);
  });
}

}  // namespace plumbline::inline slicer
