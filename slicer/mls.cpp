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

constexpr float kAgree = 0.99F;   ///< |sum of w n| over sum of w: normals some 8 degrees from their mean
constexpr float kSharpness = 2;   ///< a point counts where the cosine to the mean is above 1 - 1 / this
constexpr float kUnlike = 0.02F;  ///< what it counts beyond that

/// The sums of a value, each in four lanes.
struct Sums {
  Lanes weights{};
  Lanes distances{};
  Lanes normal_x{};
  Lanes normal_y{};
  Lanes normal_z{};
  Lanes offset_x{};
  Lanes offset_y{};
  Lanes offset_z{};

  void add(const RayPoints& points, std::uint32_t j, Lanes w, Lanes z, Lanes dz) {
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
  Vec3f normal() const { return {sum(normal_x), sum(normal_y), sum(normal_z)}; }
  float distance() const {
    const float weight = sum(weights);
    const float mean_plane =
        sum(normal_x) * sum(offset_x) + sum(normal_y) * sum(offset_y) + sum(normal_z) * sum(offset_z);
    return 0.5F * (sum(distances) + mean_plane / weight) / weight;
  }
};

std::size_t padded(std::uint32_t capacity) {
  // Room for the padding, in whole cache lines.
  return (std::size_t{capacity} + RayPoints::kLanes + 15) / 16 * 16;
}
constexpr std::size_t kColumns = 9;

}  // namespace

std::size_t RayPoints::bytes_needed(std::uint32_t capacity) {
  return Arena::rounded(kColumns * padded(capacity) * sizeof(float));
}

Expected<RayPoints> RayPoints::create(std::uint32_t capacity, Arena& arena, const char* stage) {
  const std::size_t length = padded(capacity);
  auto columns = arena.take_top<float>(kColumns * length, stage);
  if (!columns) return tl::unexpected<Error>(columns.error());
  RayPoints points;
  float* next = columns->data();
  for (float** column : {&points.depth, &points.distance2, &points.plane, &points.slope, &points.inverse_radius2,
                         &points.normal_x, &points.normal_y, &points.offset_x, &points.offset_y}) {
    *column = next;
    next += length;
  }
  return points;
}

void RayPoints::close() {
  for (std::uint32_t j = size; j < size + kLanes; ++j) {
    depth[j] = plane[j] = slope[j] = 0;
    normal_x[j] = normal_y[j] = offset_x[j] = offset_y[j] = 0;
    distance2[j] = 1;
    inverse_radius2[j] = 2;
  }
}

RayWindow window(const RayPoints& points, float low, float high) {
  const float* begin = points.depth;
  const float* end = points.depth + points.size;
  const float* first = std::lower_bound(begin, end, low - points.reach);
  const float* last = std::upper_bound(first, end, high + points.reach);
  return {static_cast<std::uint32_t>(first - begin), static_cast<std::uint32_t>(last - begin)};
}

MlsValue mls_value(const RayPoints& points, RayWindow window, float depth) {
  const Lanes z = Lanes{} + depth;
  Sums all;
  // The last step may read beyond the window: points of no weight, or the padding.
  for (std::uint32_t j = window.first; j < window.last; j += RayPoints::kLanes) {
    const Lanes dz = z - load(points.depth + j);
    all.add(points, j, weight_of(points, j, dz), z, dz);
  }
  const float weight = sum(all.weights);
  if (!(weight > 0)) return {};
  const Vec3f normal = all.normal();
  const float length2 = normal.dot(normal);
  const float agreed = kAgree * weight;
  if (length2 >= agreed * agreed || !(length2 > 0)) return {all.distance(), weight};

  const Vec3f mean = normal * (kSharpness / std::sqrt(length2));
  Sums alike;
  for (std::uint32_t j = window.first; j < window.last; j += RayPoints::kLanes) {
    const Lanes dz = z - load(points.depth + j);
    const Lanes t = mean[0] * load(points.normal_x + j) + mean[1] * load(points.normal_y + j) +
                    mean[2] * load(points.slope + j) - (kSharpness - 1);
    const Lanes likeness = t > 0.0F ? t : Lanes{};
    alike.add(points, j, weight_of(points, j, dz) * (likeness * likeness + kUnlike), z, dz);
  }
  return {alike.distance(), weight};
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
