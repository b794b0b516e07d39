#include "firmware/print/truth/true_surface.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::firmware {
namespace {

constexpr double kRoom = 0.5;  // mm

/// The distance of a point from a strut, mm; 0 inside.
double distance(const Strut& strut, const PrintGrid& grid, const Vec3d& point) {
  const double low = strut.first * double{grid.layer_height_mm}, high = strut.end * double{grid.layer_height_mm};
  const Vec3d from(double{grid.x_of(strut.column0)}, double{grid.y_of(strut.row0)}, 0);
  const Vec3d way = Vec3d(double{grid.x_of(strut.column1)}, double{grid.y_of(strut.row1)}, 0) - from;
  const Vec3d beside(point[0] - from[0], point[1] - from[1], 0);
  const double height = std::clamp(point[2], low, high), square = way.dot(way);
  double along = (height - low) / (high - low);
  const double radius = (strut.radius0 + (strut.radius1 - strut.radius0) * along) / 1000;
  if (strut.lies != 0) along = square > 0 ? std::clamp(beside.dot(way) / square, 0.0, 1.0) : 0;
  const Vec3d off = beside - along * way;
  const double aside = std::max(0.0, std::sqrt(off.dot(off)) - radius), above = point[2] - height;
  return std::sqrt(aside * aside + above * above);
}

}  // namespace

void leave_out_supports(const Supports& supports, const PrintGrid& grid, std::vector<OrientedPoint>& points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.at[0] < b.at[0]; });
  std::vector<bool> near(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) near[i] = points[i].at[2] < -grid.layer_height_mm / 2;
  for (const Strut& strut : supports.list) {
    if (strut.first == strut.end) continue;
    const double radius = std::max(strut.radius0, strut.radius1) / 1000.0 + kRoom;
    const auto left = static_cast<float>(double{grid.x_of(std::min(strut.column0, strut.column1))} - radius);
    const auto right = static_cast<float>(double{grid.x_of(std::max(strut.column0, strut.column1))} + radius);
    auto at = std::lower_bound(points.begin(), points.end(), left, [](const auto& p, float x) { return p.at[0] < x; });
    for (; at != points.end() && at->at[0] <= right; ++at) {
      const auto i = static_cast<std::size_t>(at - points.begin());
      near[i] = near[i] || distance(strut, grid, at->at.cast<double>()) < kRoom;
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!near[i]) points[kept++] = points[i];
  }
  points.resize(kept);
}

}  // namespace plumbline::firmware
