#include "firmware/pictures/preview/preview.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>

#include "firmware/pictures/preview/picture.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_views.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

void draw_centred(const Picture& picture, std::int64_t centre, std::int64_t top, std::string_view text,
                  const LabelStyle& style) {
  draw_text(picture, centre - style.face.width(text) / 2, top, text, style);
}

/// Draws a scale bar: the longest of 1, 2 or 5 times a power of ten mm that takes at most 200 pixels.
void draw_scale_bar(const Picture& picture, double pixels_per_mm, std::int64_t left, std::int64_t top) {
  double length = 0.01;
  for (const double factor : {1.0, 10.0, 100.0, 1000.0, 10000.0}) {
    for (const double digit : {0.01, 0.02, 0.05}) {
      if (digit * factor * pixels_per_mm <= 200.0) length = digit * factor;
    }
  }
  const auto pixels = static_cast<std::int64_t>(std::floor(length * pixels_per_mm + 0.5));
  picture.fill(left, top + 5, pixels, 3, kInk);
  picture.fill(left, top, 2, 13, kInk);
  picture.fill(left + pixels - 2, top, 2, 13, kInk);
  char label[32];
  std::snprintf(label, sizeof label, "%g mm", length);
  draw_text(picture, left + pixels + 14, top, label, {page_faces().plain, kInk});
}

}  // namespace

std::size_t preview_bytes(const PrintGrid& grid) { return views_bytes(grid, kPreviewPage, Views::kThreeSides); }

Status draw_preview(const RRep& rrep, const Supports& supports, const PreviewText& text, Arena& arena,
                    std::span<std::uint8_t> rgb, const Paint* paint) {
  assert(rgb.size() == kPageBytes);
  const Picture picture{rgb, kPreviewColumns, kPreviewRows};
  const auto layout = draw_views(rrep, supports, kPreviewPage, Views::kThreeSides, arena, picture, paint);
  PLUMBLINE_TRY(layout);
  const LabelStyle title{page_faces().title, kInk}, plain{page_faces().plain, kInk}, pale{page_faces().plain, kPaleInk};
  if (*layout) {
    const Layout& at = **layout;
    const std::int64_t label = at.floor + 18;
    draw_centred(picture, at.front_left + at.width / 2, label, "front", pale);
    draw_centred(picture, at.side_left + at.depth / 2, label, "side", pale);
    draw_centred(picture, at.top_left + at.width / 2, label, "top", pale);
    draw_scale_bar(picture, at.pixels_per_mm, kMargin, 106);
  }

  const std::string_view size = *layout ? text.size : "empty";
  const int size_width = plain.face.width(size);
  draw_text(picture, std::int64_t{kPreviewColumns} - kMargin - size_width, 52, size, plain);
  draw_text(picture, kMargin, 38, title.face.start_of(text.name, int{kPreviewColumns - 3 * kMargin} - size_width),
            title);
  std::int64_t line = 806;
  for (const auto caption : text.captions.first(std::min(text.captions.size(), kMaxPreviewCaptions))) {
    draw_text(picture, kMargin, line, pale.face.start_of(caption, kPreviewColumns - 2 * kMargin), pale);
    line += 28;
  }
  return {};
}

}  // namespace plumbline::firmware::inline pictures
