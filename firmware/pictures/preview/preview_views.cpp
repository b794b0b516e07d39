#include "firmware/pictures/preview/preview_views.hpp"

#include <algorithm>
#include <array>

#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/pictures/preview/preview_shading.hpp"
#include "firmware/pictures/preview/preview_smoothing.hpp"
#include "firmware/pictures/preview/preview_survey.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline::firmware::inline pictures::preview {
namespace {

constexpr const char* kStage = "preview";
constexpr Rgb kLine{112, 123, 136};

/// Draws the line that the object stands on, fading out at both ends.
void draw_floor(const Picture& picture, std::int64_t left, std::int64_t width, std::int64_t row, std::int64_t fade) {
  for (std::int64_t x = -fade; x < width + fade; ++x) {
    const std::int64_t inside = std::min(x + fade, width + fade - x);
    const float cover = std::min(static_cast<float>(inside) / static_cast<float>(fade), 1.0F);
    picture.blend(left + x, row, kLine, cover);
    picture.blend(left + x, row + 1, kLine, 0.4F * cover);
  }
}

std::uint32_t longer_side(const PrintGrid& grid) { return std::max(grid.columns, grid.rows); }

/// Samples of maps of a page, at most.
struct Samples {
  Samples(const Page& page, Views views) {
    const std::uint32_t across = page.area_columns(static_cast<std::uint32_t>(views));
    // Of three sides each has half of the width at most, but for the one from the side, which is as deep as that from above is high.
    const bool all = views == Views::kThreeSides;
    const std::uint32_t deep = std::min(across, page.area_rows());
    const std::size_t column = std::size_t{page.area_rows()} * kSamplesPerPixel * kSamplesPerPixel;
    largest = (all ? std::max(across / 2, deep) : across) * column;
    walls = (all ? (across + deep) / 2 : across) * column;
  }
  std::size_t largest;  ///< of one
  std::size_t walls;    ///< of those from the front and from the side together; that from above has fewer
};

/// What a picture shows from one side.
struct View {
  Side side;
  std::uint32_t width, height;      ///< pixels
  std::int64_t left, top;           ///< on the page
  float across_mm, up_mm, deep_mm;  ///< of a voxel
};

/// mm
Box3f box_of(const Extent& extent, const PrintGrid& grid) {
  const Vec3f voxel(grid.pitch_x_mm, grid.pitch_y_mm, grid.layer_height_mm);
  using Voxels = Eigen::Vector<std::uint32_t, 3>;
  return {Voxels(extent.column, extent.row, extent.layer).cast<float>().cwiseProduct(voxel),
          Voxels(extent.column_end, extent.row_end, extent.layer_end).cast<float>().cwiseProduct(voxel)};
}

}  // namespace

Vec3f SeenView::place(const Vec3f& print_mm) const {
  const Vec3f low = (print_mm - box.low) * samples_per_mm, high = (box.high - print_mm) * samples_per_mm;
  if (side == Side::kFront) return {low[0], high[2], low[1]};
  return side == Side::kSide ? Vec3f(high[1], high[2], low[0]) : Vec3f(low[0], high[1], high[2]);
}

std::size_t views_bytes(const PrintGrid& grid, const Page& page, Views views) {
  const Samples samples(page, views);
  const std::size_t room = Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
                           2 * Arena::rounded(std::size_t{longer_side(grid)} * sizeof(std::uint32_t)) +
                           Arena::rounded(longer_side(grid));
  const std::size_t cells = views == Views::kThreeSides ? height_cells(grid) : 0;
  const std::size_t from_above = Arena::rounded(cells * sizeof(std::uint16_t)) + Arena::rounded(cells);
  return room + Arena::rounded(samples.walls * sizeof(float)) + Arena::rounded(samples.walls) +
         std::max({room, Arena::rounded(samples.largest * sizeof(float)), from_above});
}

Expected<std::optional<Layout>> draw_views(const RRep& rrep, const Supports& supports, const Page& page, Views views,
                                           Arena& arena, const Picture& picture, const Paint* paint) {
  const PrintGrid& grid = rrep.grid;
  const ArenaScope scope(arena);
  std::array<SurveyScratch, 2> room;  // of two views at once
  const auto take_room = [&](SurveyScratch& one) -> Status {
    PLUMBLINE_TRY(arena.take_top(one.section, BitImage::words_needed(grid.columns, grid.rows), kStage));
    PLUMBLINE_TRY(arena.take_top(one.nearest, longer_side(grid), kStage));
    PLUMBLINE_TRY(arena.take_top(one.seen, longer_side(grid), kStage));
    return arena.take_top(one.materials, longer_side(grid), kStage);
  };
  PLUMBLINE_TRY(take_room(room[0]));
  const Samples most(page, views);
  const auto samples = arena.take_top<std::uint8_t>(most.walls, kStage);
  PLUMBLINE_TRY(samples);
  const auto depths = arena.take_top<float>(most.walls, kStage);
  PLUMBLINE_TRY(depths);

  draw_background(picture);
  const Extent object = find_extent(rrep, room[0].section);
  if (object.empty()) return std::optional<Layout>();
  const Extent extent = with_supports(object, supports, grid);
  const Layout layout = lay_out(extent, grid, page, views);
  const std::int64_t fade = page.gap * 4 / 9;
  draw_floor(picture, layout.front_left, layout.width, layout.floor, fade);
  if (views == Views::kThreeSides) draw_floor(picture, layout.side_left, layout.depth, layout.floor, fade);
  const auto in_samples = [&](float mm) { return mm * static_cast<float>(layout.samples_per_mm()); };
  const float x = grid.pitch_x_mm, y = grid.pitch_y_mm, z = grid.layer_height_mm;
  const std::int64_t upper = layout.floor - layout.height;
  const std::int64_t top_upper = layout.floor - (std::int64_t{layout.tall} + layout.depth) / 2;
  const std::array<View, 3> sides = {{{Side::kFront, layout.width, layout.height, layout.front_left, upper, x, z, y},
                                      {Side::kSide, layout.depth, layout.height, layout.side_left, upper, y, z, x},
                                      {Side::kTop, layout.width, layout.depth, layout.top_left, top_upper, x, y, z}}};
  const auto map_of = [&](const View& view, std::size_t first) {
    const std::uint32_t columns = view.width * kSamplesPerPixel, rows = view.height * kSamplesPerPixel;
    const std::size_t size = std::size_t{columns} * rows;
    return DepthMap{depths->subspan(first, size), samples->subspan(first, size), columns, rows};
  };
  const auto see = [&](const View& view, const SurveyScratch& one, const DepthMap& map) {
    survey(rrep, supports, extent, layout, one, view.side, map);
  };
  const auto draw = [&](const View& view, const DepthMap& map) -> Status {
    const ArenaScope one(arena);
    std::span<float> scratch;
    PLUMBLINE_TRY(arena.take_top(scratch, most.largest, kStage));
    if (paint != nullptr) {
      const auto scale = static_cast<float>(layout.samples_per_mm());
      paint->give_colours({map, view.side, box_of(extent, grid), scale});
    }
    const float across = in_samples(std::max(view.across_mm, view.up_mm));
    smooth_depth(map, scratch, {.across = across, .deep = in_samples(view.deep_mm)});
    const auto shadowless = paint != nullptr ? paint->shadowless : std::optional(kOfSupports);
    shade_depth(map, scratch, picture, view.left, view.top, paint != nullptr ? paint->colours : kMaterials, shadowless);
    return {};
  };
  // All at once would need more memory than most stages of a small job.
  const DepthMap front = map_of(sides[0], 0), side = map_of(sides[1], front.depth.size());
  {
    const ArenaScope both(arena);
    PLUMBLINE_TRY(take_room(room[1]));
    const std::size_t walls = views == Views::kThreeSides ? 2 : 1;
#pragma omp parallel for schedule(static, 1)
    for (std::size_t i = 0; i < walls; ++i) see(sides[i], room[i], i == 0 ? front : side);
  }
  PLUMBLINE_TRY(draw(sides[0], front));
  if (views == Views::kThreeSides) {
    PLUMBLINE_TRY(draw(sides[1], side));
    const DepthMap top = map_of(sides[2], 0);
    {
      const ArenaScope from_above(arena);
      PLUMBLINE_TRY(arena.take_top(room[0].heights, height_cells(grid), kStage));
      PLUMBLINE_TRY(arena.take_top(room[0].materials, height_cells(grid), kStage));
      see(sides[2], room[0], top);
    }
    PLUMBLINE_TRY(draw(sides[2], top));
  }
  return std::optional<Layout>(layout);
}

}  // namespace plumbline::firmware::inline pictures::preview
