#include "firmware/pictures/preview/picture.hpp"

#include <algorithm>

namespace plumbline::firmware::inline pictures {
void Picture::blend(std::int64_t column, std::int64_t row, const Rgb& colour, float cover) const {
  if (column < 0 || row < 0 || column >= columns || row >= rows) return;
  std::uint8_t* pixel = &rgb[3 * (static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(column))];
  if (cover >= 1.0F) {
    std::copy(colour.begin(), colour.end(), pixel);
    return;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const float mixed = static_cast<float>(pixel[c]) * (1.0F - cover) + static_cast<float>(colour[c]) * cover;
    pixel[c] = static_cast<std::uint8_t>(std::clamp(mixed + 0.5F, 0.0F, 255.0F));
  }
}

void Picture::fill(std::int64_t left, std::int64_t top, std::int64_t width, std::int64_t height,
                   const Rgb& colour) const {
  const std::int64_t first = std::clamp<std::int64_t>(left, 0, columns);
  const std::int64_t end = std::clamp<std::int64_t>(left + width, first, columns);
  for (std::int64_t y = std::max<std::int64_t>(top, 0); y < std::min<std::int64_t>(top + height, rows); ++y) {
    std::uint8_t* const pixels = rgb.data() + 3 * (y * std::int64_t{columns} + first);
    const std::int64_t count = 3 * (end - first);
    if (count == 0) continue;
    // One pixel, then copies of all that there are.
    std::copy(colour.begin(), colour.end(), pixels);
    for (std::int64_t done = 3; done < count; done *= 2)
      std::copy_n(pixels, std::min(done, count - done), pixels + done);
  }
}

void draw_text(const Picture& picture, std::int64_t left, std::int64_t top, std::string_view text,
               const LabelStyle& style) {
  style.face.for_each_pixel(static_cast<int>(left), static_cast<int>(top) + style.face.cap_height(), text,
                            [&](int column, int row, unsigned cover) {
                              picture.blend(column, row, style.colour, static_cast<float>(cover) / 255);
                            });
}

}  // namespace plumbline::firmware::inline pictures
