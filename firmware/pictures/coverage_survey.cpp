#include "firmware/pictures/coverage_survey.hpp"

#include <algorithm>
#include <array>

#include "firmware/pictures/preview/preview_nearest.hpp"
#include "firmware/pictures/preview/preview_section.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline::firmware::inline pictures::preview {
namespace {

constexpr const char* kStage = "coverage picture";
constexpr std::uint16_t kNever = 0xFFFF;

class Surveyor {
 public:
  Surveyor(const RRep& rrep, const ConfidenceMap& map, const Extent& extent, const CoverageLayout& layout)
      : rrep_(rrep),
        map_(map),
        extent_(extent),
        samples_per_mm_(layout.samples_per_mm),
        step_(height_step(rrep.grid)),
        cells_((rrep.grid.columns + step_ - 1) / step_) {}

  Status take(Arena& arena) {
    const auto words =
        arena.take_top<std::uint64_t>(BitImage::words_needed(rrep_.grid.columns, rrep_.grid.rows), kStage);
    PLUMBLINE_TRY(words);
    const auto ends = arena.take_top<std::uint16_t>(height_cells(rrep_.grid), kStage);
    PLUMBLINE_TRY(ends);
    const auto nearest = arena.take_top<std::uint32_t>(rrep_.grid.columns, kStage);
    PLUMBLINE_TRY(nearest);
    words_ = *words;
    ends_ = *ends;
    nearest_ = *nearest;
    return {};
  }

  /// The front, or the back, which is mirrored. The lines of a layer are alike.
  void draw_wall(const DepthMap& map, bool front) {
    std::array<std::uint32_t, kMostSamples> columns;
    for (std::uint32_t u = 0; u < map.columns; ++u) columns[u] = column_of(front ? u : map.columns - 1 - u);
    Section section(rrep_, words_);
    NearestSolid nearest(nearest_, extent_, front ? Beside::kFront : Beside::kBack);
    std::int64_t line = std::int64_t{map.rows} - 1;
    for (std::uint32_t layer = 0; layer < extent_.layer_end && line >= 0; ++layer) {
      section.advance(layer, [&](std::uint32_t column, std::uint32_t row, bool inside) {
        if (inside) nearest.add(column, row);
      });
      if (layer < extent_.layer || layer_of(line, map.rows) > layer) continue;
      nearest.settle(section.image());
      const auto first = static_cast<std::uint32_t>(line);
      for (std::uint32_t u = 0; u < map.columns; ++u) {
        const std::uint32_t deep = nearest.distances()[columns[u]];
        if (deep == nearest.none()) continue;
        const std::uint32_t row = front ? extent_.row + deep : extent_.row_end - 1 - deep;
        show(map, u, first, samples(deep, rrep_.grid.pitch_y_mm), columns[u], row, layer);
      }
      for (--line; line >= 0 && layer_of(line, map.rows) <= layer; --line) {
        map.copy_line(first, static_cast<std::uint32_t>(line));
      }
    }
  }
  /// The view from above, with the back at the upper end, or from below, with the front there.
  void draw_flat(const DepthMap& map, bool top) {
    std::fill(ends_.begin(), ends_.end(), kNever);
    Section section(rrep_, words_);
    for (std::uint32_t layer = 0; layer < extent_.layer_end; ++layer) {
      section.advance(layer, [&](std::uint32_t column, std::uint32_t row, bool inside) {
        if (inside == top || ((column | row) & (step_ - 1)) != 0) return;
        std::uint16_t& end = ends_[std::size_t{row / step_} * cells_ + column / step_];
        if (top || end == kNever) end = static_cast<std::uint16_t>(layer);
      });
    }
    show_flat(map, section.image(), top);
  }

 private:
  std::uint32_t cell(double samples, double size_mm, std::uint32_t first, std::uint32_t end) const {
    return std::min(first + static_cast<std::uint32_t>(samples / (samples_per_mm_ * size_mm)), end - 1);
  }
  std::uint32_t column_of(std::uint32_t sample) const {
    return cell(sample + 0.5, double{rrep_.grid.pitch_x_mm}, extent_.column, extent_.column_end);
  }
  std::uint32_t row_of(double sample) const {
    return cell(sample, double{rrep_.grid.pitch_y_mm}, extent_.row, extent_.row_end);
  }
  std::uint32_t layer_of(std::int64_t line, std::uint32_t lines) const {
    return cell(static_cast<double>(lines) - static_cast<double>(line) - 0.5, double{rrep_.grid.layer_height_mm},
                extent_.layer, extent_.layer_end);
  }
  float samples(std::uint32_t cells, float size_mm) const {
    return static_cast<float>(cells * double{size_mm} * samples_per_mm_);
  }

  void show(const DepthMap& map, std::uint32_t u, std::uint32_t v, float depth, std::uint32_t column, std::uint32_t row,
            std::uint32_t layer) const {
    const std::size_t sample = std::size_t{v} * map.columns + u;
    map.depth[sample] = depth;
    map.material[sample] = static_cast<std::uint8_t>(map_.at(column, row, layer));
  }
  void show_flat(const DepthMap& map, const BitImage& last, bool top) const {
    std::array<std::uint32_t, kMostSamples> columns;
    for (std::uint32_t u = 0; u < map.columns; ++u) columns[u] = column_of(u) / step_;
    for (std::uint32_t v = 0; v < map.rows; ++v) {
      const std::uint32_t row = row_of(top ? map.rows - v - 0.5 : v + 0.5) / step_;
      for (std::uint32_t u = 0; u < map.columns; ++u) {
        const std::uint32_t column = columns[u];
        std::uint32_t end = ends_[std::size_t{row} * cells_ + column];
        // Columns that are still solid in the last layer end at the top of the grid.
        if (top && last.at(column * step_, row * step_)) end = extent_.layer_end;
        if (end == kNever) continue;
        const std::uint32_t deep = top ? extent_.layer_end - end : end - extent_.layer;
        show(map, u, v, samples(deep, rrep_.grid.layer_height_mm), column * step_, row * step_, top ? end - 1 : end);
      }
    }
  }

  const RRep& rrep_;
  const ConfidenceMap& map_;
  const Extent& extent_;
  double samples_per_mm_;
  std::uint32_t step_;                ///< pixels between two heights
  std::uint32_t cells_;               ///< a row of heights
  std::span<std::uint64_t> words_;    ///< of the section
  std::span<std::uint16_t> ends_;     ///< of the surface, by cell: the layers in which it begins or ends
  std::span<std::uint32_t> nearest_;  ///< by column
};

}  // namespace

CoverageLayout CoverageLayout::of(const Extent& extent, const PrintGrid& grid, const Page& page) {
  const double width_mm = (extent.column_end - extent.column) * double{grid.pitch_x_mm};
  const double depth_mm = (extent.row_end - extent.row) * double{grid.pitch_y_mm};
  const double height_mm = (extent.layer_end - extent.layer) * double{grid.layer_height_mm};
  const double pixels_per_mm = std::min(
      {page.area_columns(4) / (4 * width_mm), page.area_rows() / std::max(height_mm, depth_mm), kMostPixelsPerMm});
  const auto pixels = [&](double mm) { return std::max(1U, static_cast<std::uint32_t>(mm * pixels_per_mm)); };
  CoverageLayout layout;
  layout.samples_per_mm = pixels_per_mm * kSamplesPerPixel;
  layout.width = pixels(width_mm);
  layout.depth = pixels(depth_mm);
  layout.height = pixels(height_mm);
  const std::int64_t spare =
      std::int64_t{page.columns} - 2 * std::int64_t{page.margin} - 4 * std::int64_t{layout.width};
  layout.step = layout.width + std::min<std::int64_t>(spare / 3, 2 * std::int64_t{page.gap});
  layout.left = (std::int64_t{page.columns} - 3 * layout.step - layout.width) / 2;
  return layout;
}

Status survey_coverage(const RRep& rrep, const ConfidenceMap& map, const Extent& extent, const CoverageLayout& layout,
                       Arena& arena, bool walls, const std::array<DepthMap, 2>& views) {
  const ArenaScope scope(arena);
  std::array<Surveyor, 2> surveyors = {Surveyor(rrep, map, extent, layout), Surveyor(rrep, map, extent, layout)};
  for (Surveyor& surveyor : surveyors) PLUMBLINE_TRY(surveyor.take(arena));
#pragma omp parallel for schedule(static, 1)
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::fill(views[v].depth.begin(), views[v].depth.end(), DepthMap::kEmpty);
    walls ? surveyors[v].draw_wall(views[v], v == 0) : surveyors[v].draw_flat(views[v], v == 0);
  }
  return {};
}

}  // namespace plumbline::firmware::inline pictures::preview
