#include "firmware/pictures/preview/preview_layout.hpp"

#include "firmware/pictures/preview/preview_section.hpp"

namespace plumbline::firmware::inline pictures::preview {

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

Layout lay_out(const Extent& extent, const PrintGrid& grid, const Page& page, Views views) {
  Layout layout;
  layout.width_mm = (extent.column_end - extent.column) * double{grid.pitch_x_mm};
  layout.depth_mm = (extent.row_end - extent.row) * double{grid.pitch_y_mm};
  layout.height_mm = (extent.layer_end - extent.layer) * double{grid.layer_height_mm};
  const bool all = views == Views::kThreeSides;
  const std::uint32_t area_columns = page.area_columns(static_cast<std::uint32_t>(views));
  const double across = area_columns / (all ? 2.0 * layout.width_mm + layout.depth_mm : layout.width_mm);
  const double up = page.area_rows() / (all ? std::max(layout.height_mm, layout.depth_mm) : layout.height_mm);
  layout.pixels_per_mm = std::min({across, up, kMostPixelsPerMm});
  const auto pixels = [&](double mm, std::uint32_t most) {
    return std::clamp(static_cast<std::uint32_t>(mm * layout.pixels_per_mm), 1U, most);
  };
  layout.height = pixels(layout.height_mm, page.area_rows());
  if (!all) {
    layout.width = pixels(layout.width_mm, area_columns);
    layout.tall = layout.height;
    layout.front_left = (std::int64_t{page.columns} - page.beside - layout.width) / 2;
  } else {
    layout.width = pixels(layout.width_mm, area_columns / 2);
    layout.depth = pixels(layout.depth_mm, std::min(area_columns - 2 * layout.width, page.area_rows()));
    layout.tall = std::max(layout.height, layout.depth);
    // The rest of the width is shared between the gaps and the margins.
    const std::int64_t used = 2 * std::int64_t{layout.width} + layout.depth;
    const std::int64_t spare = std::int64_t{page.columns} - 2 * std::int64_t{page.margin} - used;
    const std::int64_t gap = std::clamp<std::int64_t>(spare / 4, page.gap, 2 * page.gap);
    layout.front_left = (std::int64_t{page.columns} - used - 2 * gap) / 2;
    layout.side_left = layout.front_left + layout.width + gap;
    layout.top_left = layout.side_left + layout.depth + gap;
  }
  layout.floor = (std::int64_t{page.top} + page.bottom + layout.tall) / 2;
  return layout;
}

}  // namespace plumbline::firmware::inline pictures::preview
