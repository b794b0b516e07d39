#include "slicer/implicit/mls.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr float kAgree = 0.997F;  ///< |sum w n| / sum w above which normals agree: about 4 degrees from their mean
constexpr float kFar = 0.25F;     ///< share of the reach: farther from the surface, a_i does not change the sign
constexpr float kSharpness = 8;   ///< a point counts if the cosine to the mean is above 1 - 1 / kSharpness
constexpr float kUnlike = 0.02F;  ///< weight beyond that; decides where all normals differ from their mean
constexpr float kOpposed = 0.5F;  ///< |sum w n| / sum w below which the points may be those of two faces
constexpr float kApart = 0.05F;   ///< of the reach: sheets whose points are no farther from their mean are one sheet
/// |sum w n| / sum w of a side. Normals that face either way at random have 3/4, since only the points of half a sphere count.
constexpr float kCoherent = 0.85F;

/// Sums over points that make up a value.
struct Sums {
  float weight;
  float distance;
  Vec3f normal;
  Vec3f offset;

  float value() const {
    const float mean_plane = normal[0] * offset[0] + normal[1] * offset[1] + normal[2] * offset[2];
    return 0.5F * (distance + mean_plane / weight) / weight;
  }
  /// Square of off_centre().
  float off_centre2(float reach) const { return offset.dot(offset) / (weight * weight * reach * reach); }
};

/// @param facing     if not null, a unit vector: points that face other ways have less weight
/// @param sharpness  how much less
PLUMBLINE_INLINE void sum_up(const RayPoints& points, RayWindow window, float depth, const Vec3f* facing,
                             float sharpness, Sums& sums) {
  const Lanes z = Lanes{} + depth;
  // Separate variables: some compilers keep an object in memory instead of registers.
  Lanes weights{};
  Lanes distances{};
  Lanes normal_x{};
  Lanes normal_y{};
  Lanes normal_z{};
  Lanes offset_x{};
  Lanes offset_y{};
  Lanes offset_z{};
  // The last step may read past the window: points without weight, or the padding.
  for (std::uint32_t j = window.first; j < window.last; j += kLanes) {
    Lanes at, distance2, inverse2, nx, ny, nz, plane, x, y, mass;
    load(at, points.depth + j);
    load(distance2, points.distance2 + j);
    load(inverse2, points.inverse_radius2 + j);
    load(nx, points.normal_x + j);
    load(ny, points.normal_y + j);
    load(nz, points.slope + j);
    load(plane, points.plane + j);
    load(x, points.offset_x + j);
    load(y, points.offset_y + j);
    load(mass, points.mass + j);
    const Lanes dz = z - at;
    const Lanes t = 1.0F - (dz * dz + distance2) * inverse2;
    Lanes inside;
    choose(inside, t > 0.0F, t, Lanes{});
    Lanes w = inside * inside * mass;
    if (facing != nullptr) {
      const Lanes cosine = (*facing)[0] * nx + (*facing)[1] * ny + (*facing)[2] * nz;
      const Lanes u = sharpness * cosine - (sharpness - 1);
      Lanes likeness;
      choose(likeness, u > 0.0F, u, Lanes{});
      Lanes share;
      choose(share, cosine > 0.0F, likeness * likeness + kUnlike, Lanes{});
      w *= share;
    }
    weights += w;
    distances += w * (plane + nz * z);
    normal_x += w * nx;
    normal_y += w * ny;
    normal_z += w * nz;
    offset_x += w * x;
    offset_y += w * y;
    offset_z += w * dz;
  }
  sums = {sum(weights),
          sum(distances),
          {sum(normal_x), sum(normal_y), sum(normal_z)},
          {sum(offset_x), sum(offset_y), sum(offset_z)}};
}

PLUMBLINE_WIDE void sum_by_distance(const RayPoints& points, RayWindow window, float depth, Sums& sums) {
  sum_up(points, window, depth, nullptr, 0, sums);
}
PLUMBLINE_WIDE void sum_facing(const RayPoints& points, RayWindow window, float depth, const Vec3f& facing,
                               float sharpness, Sums& sums) {
  sum_up(points, window, depth, &facing, sharpness, sums);
}

/// The way that the points nearest to the place face, if the points lie on two sides of a thin wall or gap: from their middle to the
/// place, or back if they face their middle.
std::optional<Vec3f> nearest_side(const Sums& all, float reach) {
  const Vec3f from_middle = all.offset / all.weight;
  const float outwards = (all.normal.dot(from_middle) - all.distance) / all.weight;  // of <n_i, p_i - their mean>
  const float length = std::sqrt(from_middle.dot(from_middle));
  if (!(std::abs(outwards) > kApart * reach) || !(length > 0)) return std::nullopt;
  return from_middle / (outwards > 0 ? length : -length);
}

std::size_t padded(std::uint32_t capacity) {
  // With padding, rounded to whole cache lines.
  return (std::size_t{capacity} + kLanes + 15) / 16 * 16;
}

}  // namespace

std::size_t RayPoints::bytes_needed(std::uint32_t capacity) {
  return Arena::rounded(columns().size() * padded(capacity) * sizeof(float));
}

Expected<RayPoints> RayPoints::create(std::uint32_t capacity, Arena& arena, const char* stage) {
  const std::size_t length = padded(capacity);
  const auto block = arena.take_top<float>(columns().size() * length, stage);
  PLUMBLINE_TRY(block);
  RayPoints points;
  float* next = block->data();
  for (const auto column : columns()) {
    points.*column = next;
    next += length;
  }
  return points;
}

void RayPoints::close() {
  for (std::uint32_t j = size; j < size + kLanes; ++j) {
    for (const auto column : columns()) (this->*column)[j] = 0;
    distance2[j] = 1;
    inverse_radius2[j] = 2;
  }
}

RayPoints RayPoints::part(std::ptrdiff_t first, std::uint32_t count) const {
  RayPoints points = *this;
  for (const auto column : columns()) points.*column += first;
  points.size = count;
  return points;
}

RayWindow window(const RayPoints& points, float low, float high, RayWindow hint) {
  RayWindow found = hint;
  while (found.first < points.size && points.depth[found.first] < low - points.reach) ++found.first;
  found.last = std::max(found.first, found.last);
  while (found.last < points.size && points.depth[found.last] <= high + points.reach) ++found.last;
  return found;
}

MlsValue mls_value(const RayPoints& points, RayWindow window, float depth) {
  Sums all;
  sum_by_distance(points, window, depth, all);
  if (!(all.weight > 0)) return {};
  const float value = all.value();
  const float off_centre2 = all.off_centre2(points.reach);
  const float length2 = all.normal.dot(all.normal);
  const float agreed = kAgree * all.weight;
  const bool agree = length2 >= agreed * agreed || !(length2 > 0);
  Vec3f normal = all.normal;
  std::optional<Vec3f> side;
  if (length2 < kOpposed * kOpposed * all.weight * all.weight) side = nearest_side(all, points.reach);
  if (side) {
    Sums near;
    sum_facing(points, window, depth, *side, 1, near);
    const float coherent = kCoherent * near.weight;
    if (near.normal.dot(near.normal) > coherent * coherent) {
      normal = near.normal;
    } else {
      side = {};
    }
  }
  if (!side && (agree || std::abs(value) > kFar * points.reach))
    return {value, all.weight, all.normal[2] / all.weight, off_centre2};

  Sums alike;
  sum_facing(points, window, depth, normal / std::sqrt(normal.dot(normal)), kSharpness, alike);
  return {alike.value(), all.weight, alike.normal[2] / alike.weight, off_centre2};
}

float off_centre(const RayPoints& points, RayWindow window, float depth) {
  Sums all;
  sum_by_distance(points, window, depth, all);
  return all.weight > 0 ? std::sqrt(all.off_centre2(points.reach)) : 0;
}

}  // namespace plumbline::inline slicer
