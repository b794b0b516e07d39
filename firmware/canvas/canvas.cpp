#include "firmware/canvas/canvas.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

namespace plumbline::firmware::inline canvas {
namespace {

constexpr unsigned mixed(unsigned below, unsigned above, unsigned cover) {
  return (below * (255 - cover) + above * cover + 127) / 255;
}

constexpr Colour mixed_colour(Colour below, Colour above, unsigned cover) {
  return static_cast<Colour>(mixed(below >> 11, above >> 11, cover) << 11 |
                             mixed(below >> 5 & 63U, above >> 5 & 63U, cover) << 5 |
                             mixed(below & 31U, above & 31U, cover));
}

/// Calls visit(x, y, mean) for each pixel of a box; mean[c] is that of the picture's pixels below it.
template <std::size_t Channels, class Visit>
void resample(const PixelBox& box, const PixelBox& visible, std::span<const std::uint8_t> picture, int columns,
              int rows, Visit&& visit) {
  assert(picture.size() == Channels * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int y = visible.y; y < visible.bottom(); ++y) {
    const int top = (y - box.y) * rows / box.height;
    const int bottom = std::max(top + 1, (y + 1 - box.y) * rows / box.height);
    for (int x = visible.x; x < visible.right(); ++x) {
      const int left = (x - box.x) * columns / box.width;
      const int right = std::max(left + 1, (x + 1 - box.x) * columns / box.width);
      std::array<unsigned, Channels> sum{};
      for (int r = top; r < bottom; ++r) {
        const std::uint8_t* at =
            picture.data() + Channels * (static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) +
                                         static_cast<std::size_t>(left));
        for (int c = left; c < right; ++c) {
          for (unsigned& channel : sum) channel += *at++;
        }
      }
      const auto count = static_cast<unsigned>((bottom - top) * (right - left));
      for (unsigned& channel : sum) channel = (channel + count / 2) / count;
      visit(x, y, sum);
    }
  }
}

}  // namespace

PixelBox common(const PixelBox& a, const PixelBox& b) {
  const int left = std::max(a.x, b.x), top = std::max(a.y, b.y);
  return {left, top, std::max(0, std::min(a.right(), b.right()) - left),
          std::max(0, std::min(a.bottom(), b.bottom()) - top)};
}

PixelBox fitted(const PixelBox& room, int columns, int rows) {
  if (room.empty() || columns <= 0 || rows <= 0) return {room.x, room.y, 0, 0};
  int width = room.width, height = room.width * rows / columns;
  if (height > room.height) {
    height = room.height;
    width = room.height * columns / rows;
  }
  return {room.x + (room.width - width) / 2, room.y + (room.height - height) / 2, width, height};
}

Canvas::Canvas(std::span<Colour> pixels, int columns, int rows) : pixels_(pixels), columns_(columns), rows_(rows) {
  assert(pixels.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
}

void Canvas::fill(const PixelBox& box, Colour ink) {
  const PixelBox seen = common(box, all());
  for (int y = seen.y; y < seen.bottom(); ++y) {
    Colour* const row = pixels_.data() + static_cast<std::ptrdiff_t>(y) * columns_;
    std::fill(row + seen.x, row + seen.right(), ink);
  }
}

void Canvas::frame(const PixelBox& box, int thickness, Colour ink) {
  fill(box.top_rows(thickness), ink);
  fill(box.from_row(box.height - thickness), ink);
  fill(box.left_columns(thickness), ink);
  fill(box.from_column(box.width - thickness), ink);
}

void Canvas::blend(int x, int y, Colour ink, unsigned cover) {
  if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return;
  Colour& pixel =
      pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
  pixel = mixed_colour(pixel, ink, cover);
}

void Canvas::draw_grey(const PixelBox& box, std::span<const std::uint8_t> grey, int columns, int rows, Colour dark,
                       Colour light) {
  resample<1>(box, common(box, all()), grey, columns, rows, [&](int x, int y, const std::array<unsigned, 1>& mean) {
    pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)] =
        mixed_colour(dark, light, mean[0]);
  });
}

void Canvas::draw_rgb(const PixelBox& box, std::span<const std::uint8_t> rgb, int columns, int rows) {
  resample<3>(box, common(box, all()), rgb, columns, rows, [&](int x, int y, const std::array<unsigned, 3>& mean) {
    pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)] =
        colour(mean[0], mean[1], mean[2]);
  });
}

}  // namespace plumbline::firmware::inline canvas
