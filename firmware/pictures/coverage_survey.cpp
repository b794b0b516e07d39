#include "firmware/pictures/coverage_survey.hpp"

#include <algorithm>
#include <bit>

#include "slicer/core/bit_image.hpp"

namespace plumbline::preview {
namespace {

constexpr const char* kStage = "coverage picture";
constexpr std::uint32_t kNone = 0xFFFFFFFFU;
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
    const auto highest = arena.take_top<std::uint16_t>(height_cells(rrep_.grid), kStage);
    PLUMBLINE_TRY(highest);
    const auto lowest = arena.take_top<std::uint16_t>(height_cells(rrep_.grid), kStage);
    PLUMBLINE_TRY(lowest);
    const auto nearest = arena.take_top<std::uint32_t>(rrep_.grid.columns, kStage);
    PLUMBLINE_TRY(nearest);
    const auto found = arena.take_top<std::uint64_t>((rrep_.grid.columns + 63) / 64, kStage);
    PLUMBLINE_TRY(found);
    highest_ = *highest;
    lowest_ = *lowest;
    nearest_ = *nearest;
    found_ = *found;
    return {};
  }

  void survey(std::span<std::uint64_t> words, const CoverageViews& views) {
    std::fill(highest_.begin(), highest_.end(), std::uint16_t{0});
    std::fill(lowest_.begin(), lowest_.end(), kNever);
    BitImage section(words, rrep_.grid.columns, rrep_.grid.rows);
    section.clear();
    std::int64_t line = std::int64_t{views.front.rows} - 1;
    for (std::uint32_t layer = 0; layer < extent_.layer_end; ++layer) {
      advance(section, layer);
      const std::int64_t first = line;
      while (line >= 0 && layer_of(line, views.front.rows) <= layer) --line;
      if (layer < extent_.layer || first == line) continue;
      see(section, true);
      for (std::int64_t at = first; at > line; --at)
        draw_wall(views.front, static_cast<std::uint32_t>(at), layer, true);
      see(section, false);
      for (std::int64_t at = first; at > line; --at)
        draw_wall(views.back, static_cast<std::uint32_t>(at), layer, false);
    }
    draw_flat(views.top, section, true);
    draw_flat(views.below, section, false);
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

  void advance(BitImage& section, std::uint32_t layer) {
    for (std::uint32_t k = rrep_.first[layer]; k < rrep_.first[layer + 1]; ++k) {
      const std::uint32_t row = rrep_.pixel[k] / rrep_.grid.columns;
      const std::uint32_t column = rrep_.pixel[k] % rrep_.grid.columns;
      std::uint64_t& word = section.row(row)[column / 64];
      word ^= std::uint64_t{1} << (column % 64);
      if (((column | row) & (step_ - 1)) != 0) continue;
      const std::size_t at = std::size_t{row / step_} * cells_ + column / step_;
      if ((word >> (column % 64) & 1U) == 0) {
        highest_[at] = static_cast<std::uint16_t>(layer);
      } else if (lowest_[at] == kNever) {
        lowest_[at] = static_cast<std::uint16_t>(layer);
      }
    }
  }

  /// Finds the nearest row of each column, seen from the front or from the back.
  void see(const BitImage& section, bool from_front) {
    std::fill(nearest_.begin(), nearest_.end(), kNone);
    std::fill(found_.begin(), found_.end(), std::uint64_t{0});
    for (std::uint32_t k = 0; k < extent_.row_end - extent_.row; ++k) {
      const std::uint32_t row = from_front ? extent_.row + k : extent_.row_end - 1 - k;
      const auto words = section.row(row);
      for (std::size_t w = 0; w < found_.size(); ++w) {
        std::uint64_t fresh = words[w] & ~found_[w];
        found_[w] |= fresh;
        for (; fresh != 0; fresh &= fresh - 1)
          nearest_[w * 64 + static_cast<std::size_t>(std::countr_zero(fresh))] = row;
      }
    }
  }

  void show(const DepthMap& map, std::uint32_t u, std::uint32_t v, float depth, std::uint32_t column, std::uint32_t row,
            std::uint32_t layer) const {
    const std::size_t sample = std::size_t{v} * map.columns + u;
    map.depth[sample] = depth;
    map.material[sample] = static_cast<std::uint8_t>(map_.at(column, row, layer));
  }
  /// Draws a line of the front view, or of the back view, which is mirrored.
  void draw_wall(const DepthMap& map, std::uint32_t line, std::uint32_t layer, bool front) const {
    for (std::uint32_t u = 0; u < map.columns; ++u) {
      const std::uint32_t column = column_of(front ? u : map.columns - 1 - u);
      const std::uint32_t row = nearest_[column];
      if (row == kNone) continue;
      const std::uint32_t deep = front ? row - extent_.row : extent_.row_end - 1 - row;
      show(map, u, line, samples(deep, rrep_.grid.pitch_y_mm), column, row, layer);
    }
  }
  /// Draws the view from above, with the back at the upper end, or from below, with the front there.
  void draw_flat(const DepthMap& map, const BitImage& last, bool top) const {
    for (std::uint32_t v = 0; v < map.rows; ++v) {
      const std::uint32_t row = row_of(top ? map.rows - v - 0.5 : v + 0.5) / step_;
      for (std::uint32_t u = 0; u < map.columns; ++u) {
        const std::uint32_t column = column_of(u) / step_;
        const std::size_t at = std::size_t{row} * cells_ + column;
        if (lowest_[at] == kNever) continue;
        // Columns that are still solid in the last layer end at the top of the grid.
        const bool goes_on = last.at(column * step_, row * step_);
        const std::uint32_t end = goes_on ? extent_.layer_end : highest_[at];
        const std::uint32_t deep = top ? extent_.layer_end - end : lowest_[at] - extent_.layer;
        show(map, u, v, samples(deep, rrep_.grid.layer_height_mm), column * step_, row * step_,
             top ? end - 1 : lowest_[at]);
      }
    }
  }

  const RRep& rrep_;
  const ConfidenceMap& map_;
  const Extent& extent_;
  double samples_per_mm_;
  std::uint32_t step_;   ///< pixels between two heights
  std::uint32_t cells_;  ///< a row of heights
  std::span<std::uint16_t> highest_, lowest_;
  std::span<std::uint32_t> nearest_;  ///< by column
  std::span<std::uint64_t> found_;
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
                       std::span<std::uint64_t> section, Arena& arena, const CoverageViews& views) {
  const ArenaScope scope(arena);
  Surveyor surveyor(rrep, map, extent, layout);
  PLUMBLINE_TRY(surveyor.take(arena));
  surveyor.survey(section, views);
  return {};
}

}  // namespace plumbline::preview
