#include "firmware/pictures/preview/preview_page.hpp"

#include <cmath>

namespace plumbline::firmware::inline pictures::preview {
namespace {

constexpr Rgb kSkyColour{46, 53, 63}, kFloorColour{70, 79, 91};

}  // namespace

void draw_background(const Picture& picture) {
  for (std::uint32_t row = 0; row < picture.rows; ++row) {
    const float t = static_cast<float>(row) / static_cast<float>(picture.rows);
    Rgb colour;
    for (std::size_t c = 0; c < 3; ++c) {
      const float mixed = static_cast<float>(kSkyColour[c]) * (1 - t) + static_cast<float>(kFloorColour[c]) * t;
      colour[c] = static_cast<std::uint8_t>(std::floor(mixed + 0.5F));
    }
    picture.fill(0, row, picture.columns, 1, colour);
  }
}

const PageFaces& page_faces() {
  static const PageFaces kFaces;
  return kFaces;
}

}  // namespace plumbline::firmware::inline pictures::preview
