#include "firmware/pictures/preview_layout.hpp"

#include "firmware/pictures/preview_section.hpp"

namespace plumbline::preview {

Extent find_extent(const RRep& rrep, std::span<std::uint64_t> words) {
  Extent extent{rrep.grid.columns, 0, rrep.grid.rows, 0, rrep.grid.layers, 0};
  Section section(rrep, words);
  std::int64_t inside = 0;
  for (std::uint32_t layer = 0; layer < rrep.grid.layers; ++layer) {
    if (rrep.first[layer] == rrep.first[layer + 1]) continue;
    extent.layer = std::min(extent.layer, layer);
    extent.layer_end = layer;
    section.advance(layer, [&](std::uint32_t column, std::uint32_t row, bool is_inside) {
      extent.hold(row, column, column + 1);
      inside += is_inside ? 1 : -1;
    });
  }
  if (inside > 0) extent.layer_end = rrep.grid.layers;  // the object continues above the last layer
  return extent;
}

Extent with_supports(Extent extent, const Supports& supports, const PrintGrid& grid) {
  const auto hold = [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) { extent.hold(row, begin, end); };
  for (const Strut& strut : supports.list) {
    if (strut.first == strut.end) continue;
    extent.layer = std::min<std::uint32_t>(extent.layer, strut.first);
    extent.layer_end = std::max<std::uint32_t>(extent.layer_end, strut.end);
    // A strut reaches farthest at one of its ends.
    for (const std::uint32_t layer : {std::uint32_t{strut.first}, std::uint32_t{strut.end} - 1}) {
      for_each_span(supports, strut, layer, grid, hold);
    }
  }
  return extent;
}

Layout lay_out(const Extent& extent, const PrintGrid& grid) {
  Layout page;
  page.width_mm = (extent.column_end - extent.column) * double{grid.pitch_x_mm};
  page.depth_mm = (extent.row_end - extent.row) * double{grid.pitch_y_mm};
  page.height_mm = (extent.layer_end - extent.layer) * double{grid.layer_height_mm};
  const double across = kAreaColumns / (2.0 * page.width_mm + page.depth_mm);
  const double up = kAreaRows / std::max(page.height_mm, page.depth_mm);
  page.pixels_per_mm = std::min({across, up, kMostPixelsPerMm});
  const auto pixels = [&](double mm, std::uint32_t most) {
    return std::clamp(static_cast<std::uint32_t>(mm * page.pixels_per_mm), 1U, most);
  };
  page.width = pixels(page.width_mm, kAreaColumns / 2);
  page.depth = pixels(page.depth_mm, std::min(kAreaColumns - 2 * page.width, kAreaRows));
  page.height = pixels(page.height_mm, kAreaRows);
  page.tall = std::max(page.height, page.depth);
  // The rest of the width is shared between the gaps and the margins.
  const std::int64_t spare = std::int64_t{kPreviewColumns} - 2 * kMargin - 2 * std::int64_t{page.width} - page.depth;
  const std::int64_t gap = std::clamp<std::int64_t>(spare / 4, kGap, 2 * kGap);
  page.front_left = (std::int64_t{kPreviewColumns} - 2 * std::int64_t{page.width} - page.depth - 2 * gap) / 2;
  page.side_left = page.front_left + page.width + gap;
  page.top_left = page.side_left + page.depth + gap;
  page.floor = (std::int64_t{kTop} + kBottom + page.tall) / 2;
  return page;
}

}  // namespace plumbline::preview
