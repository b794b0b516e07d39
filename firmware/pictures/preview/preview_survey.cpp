#include "firmware/pictures/preview/preview_survey.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "firmware/pictures/preview/preview_nearest.hpp"
#include "firmware/pictures/preview/preview_section.hpp"

namespace plumbline::firmware::inline pictures::preview {
namespace {

/// Cells on a side of the map of the highest surfaces. The picture has 1600 pixels, so more cells would not show.
constexpr std::uint32_t kMostHeights = 2048;

/// What a sample of a depth map shows.
enum class Material : std::uint8_t { kObject, kSupport };

class Surveyor {
 public:
  Surveyor(const RRep& rrep, const Supports& supports, const Extent& extent, const Layout& layout,
           const SurveyScratch& scratch)
      : rrep_(rrep),
        supports_(supports),
        extent_(extent),
        layout_(layout),
        scratch_(scratch),
        shift_(static_cast<std::uint32_t>(std::countr_zero(height_step(rrep.grid)))),
        cells_((rrep.grid.columns + height_step(rrep.grid) - 1) / height_step(rrep.grid)) {}

  /// The view from the front or from the left. The lines of a layer are alike.
  void draw_wall(const DepthMap& map, Beside from) const {
    const bool front = from == Beside::kFront;
    std::array<std::uint32_t, kMostSamples> places;  // of the grid, by sample of a line
    for (std::uint32_t u = 0; u < map.columns; ++u) places[u] = front ? column_of(u) : row_of(u, map.columns);
    Section section(rrep_, scratch_.section);
    NearestSolid object(scratch_.nearest, extent_, from);
    std::int64_t line = std::int64_t{map.rows} - 1;  // from the underside up
    for (std::uint32_t layer = 0; layer < extent_.layer_end && line >= 0; ++layer) {
      section.advance(layer, [&](std::uint32_t column, std::uint32_t row, bool inside) {
        if (inside) object.add(column, row);
      });
      if (layer < extent_.layer || layer_of(line, map.rows) > layer) continue;
      object.settle(section.image());
      see_supports(layer, object);
      const auto first = static_cast<std::uint32_t>(line);
      const auto deep_mm = double{front ? rrep_.grid.pitch_y_mm : rrep_.grid.pitch_x_mm};
      for (std::uint32_t u = 0; u < map.columns; ++u) {
        const std::uint32_t distance = scratch_.seen[places[u]];
        if (distance == object.none()) continue;
        map.show(u, first, depth_of(distance, deep_mm), is_support(scratch_.materials[places[u]]));
      }
      for (--line; line >= 0 && layer_of(line, map.rows) <= layer; --line) {
        map.copy_line(first, static_cast<std::uint32_t>(line));
      }
    }
  }

  /// The view along -z.
  void draw_top(const DepthMap& map) const {
    const std::uint32_t step = height_step(rrep_.grid);
    std::fill(scratch_.heights.begin(), scratch_.heights.end(), std::uint16_t{0});
    Section section(rrep_, scratch_.section);
    // Up to the layer in which the highest surface ends.
    for (std::uint32_t layer = 0; layer < std::min(extent_.layer_end + 1, rrep_.grid.layers); ++layer) {
      // A surface that ends in layer k ends at the underside of k, k layer heights up. 0: nothing has ended here.
      section.advance(layer, [&](std::uint32_t column, std::uint32_t row, bool inside) {
        if (inside || ((column | row) & (step - 1)) != 0) return;
        scratch_.heights[std::size_t{row >> shift_} * cells_ + (column >> shift_)] = static_cast<std::uint16_t>(layer);
      });
    }
    see_supports_from_above();
    show_top(map, section.image());
  }

 private:
  /// Index of the cell at `samples` samples from the low end of a range.
  std::uint32_t cell(double samples, double size_mm, std::uint32_t first, std::uint32_t end) const {
    const auto k = static_cast<std::uint32_t>(samples / (layout_.samples_per_mm() * size_mm));
    return std::min(first + k, end - 1);
  }
  std::uint32_t column_of(std::uint32_t sample) const {
    return cell(sample + 0.5, double{rrep_.grid.pitch_x_mm}, extent_.column, extent_.column_end);
  }
  /// @param sample  counted from the back: the left of the side view, the upper end of the top view
  std::uint32_t row_of(std::uint32_t sample, std::uint32_t samples) const {
    return cell(samples - sample - 0.5, double{rrep_.grid.pitch_y_mm}, extent_.row, extent_.row_end);
  }
  std::uint32_t layer_of(std::int64_t line, std::uint32_t lines) const {
    const double above = static_cast<double>(lines) - static_cast<double>(line) - 0.5;
    return cell(above, double{rrep_.grid.layer_height_mm}, extent_.layer, extent_.layer_end);
  }

  /// Sees the object, and supports where they are nearer.
  void see_supports(std::uint32_t layer, const NearestSolid& object) const {
    const auto seen = scratch_.seen;
    const auto materials = scratch_.materials;
    for (std::uint32_t place = object.first(); place < object.end(); ++place) {
      seen[place] = object.distances()[place];
      materials[place] = to_byte(Material::kObject);
    }
    const auto see = [&](std::uint32_t place, std::uint32_t distance) {
      if (seen[place] <= distance) return;
      seen[place] = distance;
      materials[place] = to_byte(Material::kSupport);
    };
    for (const Strut& strut : supports_.list) {
      if (!strut.is_in(layer)) continue;
      for_each_span(supports_, strut, layer, rrep_.grid,
                    [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                      if (object.by_row()) return see(row, object.distance(begin, row));
                      for (std::uint32_t column = begin; column < end; ++column)
                        see(column, object.distance(column, row));
                    });
    }
  }
  /// Raises the highest surfaces to the supports' tops where those are higher.
  void see_supports_from_above() const {
    const std::uint32_t low_bits = (std::uint32_t{1} << shift_) - 1;
    std::fill(scratch_.materials.begin(), scratch_.materials.end(), to_byte(Material::kObject));
    for (const Strut& strut : supports_.list) {
      const bool is_upright = strut.column0 == strut.column1 && strut.row0 == strut.row1;
      Nanometres seen = -1;  // a disc no wider than one above it is hidden
      for (std::uint32_t layer = strut.end; layer-- > strut.first;) {
        const Nanometres radius = section_of(strut, layer).radius;
        if (radius <= seen && (is_upright || strut.lies != 0)) continue;
        seen = radius;
        for_each_span(supports_, strut, layer, rrep_.grid,
                      [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                        if ((row & low_bits) != 0) return;
                        const std::size_t line = std::size_t{row >> shift_} * cells_;
                        for (std::uint32_t c = (begin + low_bits) >> shift_; c << shift_ < end; ++c) {
                          if (scratch_.heights[line + c] >= layer + 1) continue;
                          scratch_.heights[line + c] = static_cast<std::uint16_t>(layer + 1);
                          scratch_.materials[line + c] = to_byte(Material::kSupport);
                        }
                      });
      }
    }
  }

  static constexpr std::uint8_t to_byte(Material material) { return static_cast<std::uint8_t>(material); }
  static bool is_support(std::uint8_t material) { return material == to_byte(Material::kSupport); }

  float depth_of(std::uint32_t cells, double size_mm) const {
    return static_cast<float>(cells * size_mm * layout_.samples_per_mm());
  }
  void show_top(const DepthMap& map, const BitImage& last) const {
    std::array<std::uint32_t, kMostSamples> columns;
    for (std::uint32_t u = 0; u < map.columns; ++u) columns[u] = column_of(u) >> shift_;
#pragma omp parallel for schedule(static)
    for (std::uint32_t v = 0; v < map.rows; ++v) {
      const std::uint32_t row = row_of(v, map.rows) >> shift_;
      for (std::uint32_t u = 0; u < map.columns; ++u) {
        const std::uint32_t column = columns[u];
        const std::size_t cell = std::size_t{row} * cells_ + column;
        std::uint32_t height = scratch_.heights[cell];
        bool support = is_support(scratch_.materials[cell]);
        if (last.at(column << shift_, row << shift_)) {
          height = extent_.layer_end;  // continues above the last layer
          support = false;
        }
        if (height == 0) continue;
        map.show(u, v, depth_of(extent_.layer_end - height, double{rrep_.grid.layer_height_mm}), support);
      }
    }
  }

  const RRep& rrep_;
  const Supports& supports_;
  const Extent& extent_;
  const Layout& layout_;
  const SurveyScratch& scratch_;
  std::uint32_t shift_;  ///< of a pixel's column and row to those of its cell in the map of heights
  std::uint32_t cells_;  ///< a row of that map
};

}  // namespace

std::uint32_t height_step(const PrintGrid& grid) {
  std::uint32_t step = 1;
  while (std::max(grid.columns, grid.rows) / step > kMostHeights) step *= 2;
  return step;
}
std::size_t height_cells(const PrintGrid& grid) {
  const std::uint32_t step = height_step(grid);
  return std::size_t{(grid.columns + step - 1) / step} * ((grid.rows + step - 1) / step);
}

void survey(const RRep& rrep, const Supports& supports, const Extent& extent, const Layout& layout,
            const SurveyScratch& scratch, Side side, const DepthMap& map) {
  std::fill(map.depth.begin(), map.depth.end(), DepthMap::kEmpty);
  const Surveyor surveyor(rrep, supports, extent, layout, scratch);
  side == Side::kTop ? surveyor.draw_top(map)
                     : surveyor.draw_wall(map, side == Side::kFront ? Beside::kFront : Beside::kLeft);
}

}  // namespace plumbline::firmware::inline pictures::preview
