#include "firmware/pictures/preview/preview_views.hpp"

#include <algorithm>

#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "firmware/pictures/preview/preview_smoothing.hpp"
#include "firmware/pictures/preview/preview_survey.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline::preview {
namespace {

constexpr const char* kStage = "preview";
constexpr Colour kLine{112, 123, 136};

/// Draws the line that the object stands on, fading out at both ends.
void draw_floor(const Picture& picture, std::int64_t left, std::int64_t width, std::int64_t row, std::int64_t fade) {
  for (std::int64_t x = -fade; x < width + fade; ++x) {
    const std::int64_t inside = std::min(x + fade, width + fade - x);
    const float cover = std::min(static_cast<float>(inside) / static_cast<float>(fade), 1.0F);
    picture.blend(left + x, row, kLine, cover);
    picture.blend(left + x, row + 1, kLine, 0.4F * cover);
  }
}

std::size_t material_bytes(const PrintGrid& grid) {
  return std::max<std::size_t>(height_cells(grid), std::max(grid.columns, grid.rows));
}

/// Samples of the largest map of a page.
std::size_t samples_of(const Page& page, Views views) {
  const std::uint32_t across = page.area_columns(static_cast<std::uint32_t>(views)), up = page.area_rows();
  // Of three sides each has half of the width at most, but for the one from the side, which is as deep as that from above is high.
  const std::uint32_t columns = views == Views::kThreeSides ? std::max(across / 2, std::min(across, up)) : across;
  return std::size_t{columns} * up * kSamplesPerPixel * kSamplesPerPixel;
}

}  // namespace

std::size_t views_bytes(const PrintGrid& grid, const Page& page, Views views) {
  const std::size_t samples = samples_of(page, views);
  return Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         2 * Arena::rounded(std::size_t{std::max(grid.columns, grid.rows)} * sizeof(std::uint32_t)) +
         Arena::rounded(height_cells(grid) * sizeof(std::uint16_t)) + Arena::rounded(material_bytes(grid)) +
         2 * Arena::rounded(samples * sizeof(float)) + Arena::rounded(samples);
}

Expected<std::optional<Layout>> draw_views(const RRep& rrep, const Supports& supports, const Page& page, Views views,
                                           Arena& arena, const Picture& picture) {
  const PrintGrid& grid = rrep.grid;
  const ArenaScope scope(arena);
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(words);
  const auto nearest = arena.take_top<std::uint32_t>(std::max(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(nearest);
  const auto seen = arena.take_top<std::uint32_t>(std::max(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(seen);
  const auto heights = arena.take_top<std::uint16_t>(height_cells(grid), kStage);
  PLUMBLINE_TRY(heights);
  const auto materials = arena.take_top<std::uint8_t>(material_bytes(grid), kStage);
  PLUMBLINE_TRY(materials);
  const std::size_t count = samples_of(page, views);
  const auto samples = arena.take_top<std::uint8_t>(count, kStage);
  PLUMBLINE_TRY(samples);
  const auto depths = arena.take_top<float>(count, kStage);
  PLUMBLINE_TRY(depths);
  const auto scratch = arena.take_top<float>(count, kStage);
  PLUMBLINE_TRY(scratch);

  draw_background(picture);
  const Extent object = find_extent(rrep, *words);
  if (object.empty()) return std::optional<Layout>();
  const Extent extent = with_supports(object, supports, grid);
  const Layout layout = lay_out(extent, grid, page, views);
  const std::int64_t fade = page.gap * 4 / 9;
  draw_floor(picture, layout.front_left, layout.width, layout.floor, fade);
  if (views == Views::kThreeSides) draw_floor(picture, layout.side_left, layout.depth, layout.floor, fade);
  const auto in_samples = [&](float mm) { return mm * static_cast<float>(layout.samples_per_mm()); };
  // One after another: all at once would need more memory than most stages of a small job.
  const auto draw = [&](Side side, std::uint32_t width, std::uint32_t height, std::int64_t left, float across_mm,
                        float up_mm, float deep_mm) {
    const std::uint32_t columns = width * kSamplesPerPixel, rows = height * kSamplesPerPixel;
    const std::size_t size = std::size_t{columns} * rows;
    const DepthMap map{depths->first(size), samples->first(size), columns, rows};
    survey(rrep, supports, extent, layout, {*words, *nearest, *seen, *heights, *materials}, side, map);
    smooth_depth(map, *scratch, {.across = in_samples(std::max(across_mm, up_mm)), .deep = in_samples(deep_mm)});
    const std::int64_t below = side == Side::kTop ? (std::int64_t{layout.tall} + height) / 2 : height;
    shade_depth(map, *scratch, picture, left, layout.floor - below, kMaterials);
  };
  const float x = grid.pitch_x_mm, y = grid.pitch_y_mm, z = grid.layer_height_mm;
  draw(Side::kFront, layout.width, layout.height, layout.front_left, x, z, y);
  if (views == Views::kThreeSides) {
    draw(Side::kSide, layout.depth, layout.height, layout.side_left, y, z, x);
    draw(Side::kTop, layout.width, layout.depth, layout.top_left, x, y, z);
  }
  return std::optional<Layout>(layout);
}

}  // namespace plumbline::preview
