#pragma once
/// Where the rays of the grid pass a triangle: exact, in whole numbers of 64 bits.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "slicer/core/print_grid.hpp"
#include "slicer/mesh/mesh_lattice.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// A ray passes a triangle.
struct RayHit {
  std::uint32_t column = 0, row = 0;
  CrossingHeight height;  ///< layer grid.layers: above all sampling heights
  bool entering = false;  ///< the triangle faces down
};

/// Twice the signed area of the triangle (a, b, p) in the plane of the plate, as a function of p:
///
///   e(p) = (b_x - a_x) (p_y - a_y) - (b_y - a_y) (p_x - a_x)
///
/// A ray through p passes to the left of the edge if e > 0. Where e = 0, the ray is thought to be moved by (d, d^2) for a d that is
/// smaller than any number (simulation of simplicity; Edelsbrunner and Muecke 1990). So no ray meets an edge or a corner, and of
/// two triangles that share one, exactly one is passed.
class EdgeFunction {
 public:
  EdgeFunction(const LatticePoint& a, const LatticePoint& b)
      : a_(a), dx_(std::int64_t{b.x} - a.x), dy_(std::int64_t{b.y} - a.y) {}

  /// @param column, row  of the pixel whose centre is p
  std::int64_t at(std::int64_t column, std::int64_t row) const {
    return dx_ * (centre(row) - a_.y) - dy_ * (centre(column) - a_.x);
  }
  std::int64_t per_column() const { return -dy_ * kPixelSteps; }
  std::int64_t per_row() const { return dx_ * kPixelSteps; }
  /// The least e that is to the left.
  std::int64_t least() const { return dy_ < 0 || (dy_ == 0 && dx_ > 0) ? 0 : 1; }

  static std::int64_t centre(std::int64_t pixel) { return pixel * kPixelSteps + kPixelSteps / 2; }

 private:
  LatticePoint a_;
  std::int64_t dx_, dy_;
};

/// Sign of sum_i w_i (z_i - z): whether the point with barycentric weights w_i is above, at or below z.
///
/// Splits the weights at bit 31. With sum w_i < 2^62 and |z_i - z| <= 2^30 the sum of the upper parts is below 2^61 and that of the
/// lower parts below 3 * 2^61.
inline int height_sign(const std::array<std::int64_t, 3>& w, const std::array<std::int64_t, 3>& z, std::int64_t at) {
  constexpr int kBits = 31;
  std::int64_t high = 0;
  std::int64_t low = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    high += (w[i] >> kBits) * (z[i] - at);
    low += (w[i] & ((std::int64_t{1} << kBits) - 1)) * (z[i] - at);
  }
  high += low >> kBits;
  low &= (std::int64_t{1} << kBits) - 1;
  return high < 0 ? -1 : high == 0 && low == 0 ? 0 : 1;
}

/// The height of the point with weights w_i >= 0, whose sum is 1 / `scale` in units of a layer.
inline CrossingHeight height_of_hit(const std::array<std::int64_t, 3>& w, const std::array<std::int64_t, 3>& z,
                                    double scale) {
  // All terms are positive, so the estimate is good to 2^-50 of 2^29 steps: to 2^-34 layers. Only closer than kSure to a sampling
  // height it can't decide, and whole numbers do.
  constexpr double kSure = 1.0 / (1 << 20);
  double height = 0;
  for (std::size_t i = 0; i < 3; ++i) height += static_cast<double>(w[i]) * static_cast<double>(z[i]);
  const double above = height * scale - 0.5;  // layers above the first sampling height
  const double nearest = std::floor(above + 0.5);
  auto layer = static_cast<std::int64_t>(std::ceil(above));
  if (std::abs(above - nearest) <= kSure) {
    layer = static_cast<std::int64_t>(nearest);
    if (height_sign(w, z, layer * kLayerSteps + kLayerSteps / 2) > 0) ++layer;
  }
  layer = std::max<std::int64_t>(layer, 0);
  const double part = (above - static_cast<double>(layer - 1)) * CrossingHeight::kParts;
  return CrossingHeight(static_cast<std::uint32_t>(layer),
                        static_cast<std::uint32_t>(std::clamp(part, 0.0, CrossingHeight::kParts - 1.0)));
}

/// Calls visit(RayHit) for each ray that passes a triangle, row by row. Rays that are parallel to it don't pass it.
/// @param corners  in the grid; counter-clockwise seen from outside of the object
template <class Visit>
void for_each_hit(const LatticeTriangle& corners, const PrintGrid& grid, Visit visit) {
  LatticePoint a = corners[0];
  LatticePoint b = corners[1];
  LatticePoint c = corners[2];
  const auto [x_low, x_high] = std::minmax({a.x, b.x, c.x});
  const auto [y_low, y_high] = std::minmax({a.y, b.y, c.y});
  // The pixels whose centres are in the triangle's box.
  const auto first_in = [](std::int64_t low) { return (low + kPixelSteps / 2 - 1) >> kPixelBits; };
  const auto last_in = [](std::int64_t high) { return (high - kPixelSteps / 2) >> kPixelBits; };
  const std::int64_t first_column = first_in(x_low);
  const std::int64_t last_column = std::min<std::int64_t>(last_in(x_high), std::int64_t{grid.columns} - 1);
  const std::int64_t first_row = first_in(y_low);
  const std::int64_t last_row = std::min<std::int64_t>(last_in(y_high), std::int64_t{grid.rows} - 1);
  if (first_column > last_column || first_row > last_row) return;
  std::int64_t area =
      (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - a.y) - (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - a.x);
  if (area == 0) return;
  RayHit hit;
  hit.entering = area < 0;
  if (area < 0) {
    std::swap(b, c);
    area = -area;
  }
  // From the least corner on, so that heights round alike whichever corner a file names first.
  while (b < a || c < a) {
    std::swap(a, b);
    std::swap(b, c);
  }
  const std::array<EdgeFunction, 3> edge = {EdgeFunction(b, c), EdgeFunction(c, a), EdgeFunction(a, b)};
  const std::array<std::int64_t, 3> least = {edge[0].least(), edge[1].least(), edge[2].least()};
  const std::array<std::int64_t, 3> z = {a.z, b.z, c.z};
  const double scale = 1 / (static_cast<double>(area) * static_cast<double>(kLayerSteps));
  const auto pass = [&](std::int64_t column, std::int64_t row, const std::array<std::int64_t, 3>& w) {
    hit.column = static_cast<std::uint32_t>(column);
    hit.row = static_cast<std::uint32_t>(row);
    hit.height = height_of_hit(w, z, scale);
    if (hit.height.layer() > grid.layers) hit.height = CrossingHeight(grid.layers);
    visit(hit);
  };

  std::array<std::int64_t, 3> at_row = {edge[0].at(first_column, first_row), edge[1].at(first_column, first_row),
                                        edge[2].at(first_column, first_row)};
  // In a narrow box, testing every pixel costs less than three divisions a row.
  constexpr std::int64_t kNarrow = 6;  // pixels
  const bool narrow = last_column - first_column < kNarrow;
  for (std::int64_t row = first_row; row <= last_row; ++row) {
    std::int64_t begin = first_column;
    std::int64_t end = last_column;
    for (std::size_t e = 0; e < 3 && !narrow; ++e) {
      // at + slope * i >= least, for the column first_column + i
      const std::int64_t room = at_row[e] - least[e];
      const std::int64_t slope = edge[e].per_column();
      if (slope > 0) {
        if (room < 0) begin = std::max(begin, first_column + (-room + slope - 1) / slope);
      } else if (room < 0) {
        end = first_column - 1;
      } else if (slope < 0) {
        end = std::min(end, first_column + room / -slope);
      }
    }
    std::array<std::int64_t, 3> w = at_row;
    if (begin > first_column && begin <= end) {
      for (std::size_t e = 0; e < 3; ++e) w[e] += edge[e].per_column() * (begin - first_column);
    }
    for (std::int64_t column = begin; column <= end; ++column) {
      if (!narrow || (w[0] >= least[0] && w[1] >= least[1] && w[2] >= least[2])) pass(column, row, w);
      for (std::size_t e = 0; e < 3; ++e) w[e] += edge[e].per_column();
    }
    for (std::size_t e = 0; e < 3; ++e) at_row[e] += edge[e].per_row();
  }
}

}  // namespace plumbline::inline slicer
