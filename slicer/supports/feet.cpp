#include "slicer/supports/feet.hpp"

#include <algorithm>

#include "slicer/core/bit_spans.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "supports";
constexpr LayerRegions::Settings kRegions{.runs_per_row = 64, .join_white_corners = false, .stage = kStage};

/// Draws the struts of the first layer.
void draw_first_layer(const StrutList& list, BitImage image) {
  const PixelPitch pitch(list.grid());
  for (const Strut& strut : list.struts()) {
    if (!strut.is_in(0)) continue;
    for_each_strut_span(
        pitch, strut, 0, image.columns(), image.rows(),
        [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) { fill(image, row, begin, end, true); });
  }
}

/// The middle of a region's widest run.
struct Middle {
  std::uint32_t column = 0, row = 0;
};
Middle middle_of(const LayerRegions& regions, std::uint32_t region) {
  Middle middle;
  std::uint32_t widest = 0;
  regions.any_run_of(region, [&](std::uint32_t row, std::uint32_t i) {
    const LayerRegions::Run& run = regions.run(i);
    const std::uint32_t width = run.last + 1U - run.first;
    if (width > widest) {
      widest = width;
      middle = {run.first + width / 2, row};
    }
    return false;
  });
  return middle;
}

Status add_pad(const Middle& middle, StrutList& list) {
  const PrintGrid& grid = list.grid();
  const auto px = static_cast<double>(grid.pitch_x_mm);
  const auto py = static_cast<double>(grid.pitch_y_mm);
  const Place place{middle.column * px, middle.row * py, 0};
  // Never cut at the panel's edge.
  const double room = std::min(
      {place.x, place.y, (grid.columns - 1 - middle.column) * px, (grid.rows - 1 - middle.row) * py, kPadRadius_mm});
  const std::uint32_t end = list.layer_at(kPadHeight_mm + static_cast<double>(grid.layer_height_mm) / 2);
  return list.add(StrutKind::kBase, place, place, 0, std::max(1U, end), room, room);
}

}  // namespace

Expected<std::uint32_t> add_feet(const RRep& rrep, StrutList& list, Arena& arena) {
  if (rrep.grid.layers == 0) return 0;
  const ArenaScope scope(arena);
  const std::size_t bottom = arena.bottom_mark();
  auto stream = LayerStream::create(rrep, arena);
  PLUMBLINE_TRY(stream);
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(rrep.grid.columns, rrep.grid.rows), kStage);
  PLUMBLINE_TRY(words);
  const BitImage image(*words, rrep.grid.columns, rrep.grid.rows);
  const auto object = stream->mask(0).words();
  std::copy(object.begin(), object.end(), image.words().begin());
  arena.release_bottom(bottom);
  draw_first_layer(list, image);

  auto regions = LayerRegions::create(rrep.grid.columns, rrep.grid.rows, arena, kRegions);
  PLUMBLINE_TRY(regions);
  std::uint32_t pads = 0;
  if (!regions->label(image)) return pads;
  const double pixel_mm2 = static_cast<double>(rrep.grid.pitch_x_mm) * static_cast<double>(rrep.grid.pitch_y_mm);
  const PixelPitch pitch(rrep.grid);
  for (std::uint32_t r = 0; r < regions->rows(); ++r) {
    for (std::uint32_t i = regions->row_begin(r); i < regions->row_begin(r + 1); ++i) {
      if (!regions->white(r, i) || regions->region(i) != i || regions->area(i) * pixel_mm2 >= kLeastFoot_mm2) continue;
      const Middle middle = middle_of(*regions, i);
      // Black: another one's pad is below it. Pads are a help, so they refuse no print that has used up its struts.
      if (!image.at(middle.column, middle.row) || list.is_full()) continue;
      PLUMBLINE_TRY(add_pad(middle, list));
      ++pads;
      for_each_disc_span(
          pitch, middle.column, middle.row, nanometres(kPadRadius_mm), image.columns(), image.rows(),
          [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) { fill(image, row, begin, end, false); });
    }
  }
  return pads;
}

std::size_t add_feet_bytes(const PrintGrid& grid) {
  return LayerStream::bytes_needed(grid) +
         Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         LayerRegions::bytes_needed(grid.rows, kRegions);
}

}  // namespace plumbline::inline slicer
