#include "slicer/mls.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace plumbline {
namespace {

/// Four floats side by side: gcc and clang map it to the vector unit, or to four scalars, with the same result.
using Lanes = float __attribute__((vector_size(16)));

Lanes load(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
Lanes weight_of(const RayPoints& p, std::uint32_t j, Lanes dz) {
  const Lanes t = 1.0F - (dz * dz + load(p.distance2 + j)) * load(p.inverse_radius2 + j);
  const Lanes inside = t > 0.0F ? t : Lanes{};
  return inside * inside;
}
float sum(Lanes v) { return (v[0] + v[1]) + (v[2] + v[3]); }

}  // namespace

RayWindow window(const RayPoints& points, float low, float high) {
  const float* begin = points.depth;
  const float* end = points.depth + points.size;
  const float* first = std::lower_bound(begin, end, low - points.reach);
  const float* last = std::upper_bound(first, end, high + points.reach);
  return {static_cast<std::uint32_t>(first - begin), static_cast<std::uint32_t>(last - begin)};
}

MlsValue mls_value(const RayPoints& points, RayWindow window, float depth) {
  const Lanes z = Lanes{} + depth;
  Lanes weights{};
  Lanes distances{};
  Lanes normal_x{};
  Lanes normal_y{};
  Lanes normal_z{};
  Lanes offset_x{};
  Lanes offset_y{};
  Lanes offset_z{};
  // The last step may read beyond the window: points of no weight, or the padding.
  for (std::uint32_t j = window.first; j < window.last; j += RayPoints::kLanes) {
    const Lanes dz = z - load(points.depth + j);
    const Lanes w = weight_of(points, j, dz);
    const Lanes slope = load(points.slope + j);
    weights += w;
    distances += w * (load(points.plane + j) + slope * z);
    normal_x += w * load(points.normal_x + j);
    normal_y += w * load(points.normal_y + j);
    normal_z += w * slope;
    offset_x += w * load(points.offset_x + j);
    offset_y += w * load(points.offset_y + j);
    offset_z += w * dz;
  }
  const float weight = sum(weights);
  if (!(weight > 0)) return {};
  const float mean_plane =
      sum(normal_x) * sum(offset_x) + sum(normal_y) * sum(offset_y) + sum(normal_z) * sum(offset_z);
  return {0.5F * (sum(distances) + mean_plane / weight) / weight, weight};
}

Vec3f mls_normal(const RayPoints& points, RayWindow window, float depth) {
  const Lanes z = Lanes{} + depth;
  Lanes x{};
  Lanes y{};
  Lanes slope{};
  for (std::uint32_t j = window.first; j < window.last; j += RayPoints::kLanes) {
    const Lanes w = weight_of(points, j, z - load(points.depth + j));
    x += w * load(points.normal_x + j);
    y += w * load(points.normal_y + j);
    slope += w * load(points.slope + j);
  }
  const Vec3f n(sum(x), sum(y), sum(slope));
  const float length = std::sqrt(n.dot(n));
  return length > 0 ? Vec3f(n / length) : Vec3f(Vec3f::Zero());
}

}  // namespace plumbline
