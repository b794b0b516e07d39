#include "slicer/implicit/mls.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace plumbline {
namespace {

/// Four floats: gcc and clang use the vector unit or four scalars, with the same result.
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

constexpr float kAgree = 0.997F;  ///< |sum w n| / sum w above which normals agree: about 4 degrees from their mean
constexpr float kFar = 0.25F;     ///< share of the reach: farther from the surface, a_i does not change the sign
constexpr float kSharpness = 8;   ///< a point counts if the cosine to the mean is above 1 - 1 / kSharpness
constexpr float kUnlike = 0.02F;  ///< weight beyond that; decides where all normals differ from their mean

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
};

constexpr auto kByDistance = [](Lanes w, Lanes, Lanes, Lanes) { return w; };

/// @param weigh  weigh(w, nx, ny, nz) returns the weight of four points, from their weight by distance and their normals
template <class Weigh>
Sums sums_of(const RayPoints& points, RayWindow window, float depth, Weigh weigh) {
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
  for (std::uint32_t j = window.first; j < window.last; j += RayPoints::kLanes) {
    const Lanes dz = z - load(points.depth + j);
    const Lanes nx = load(points.normal_x + j);
    const Lanes ny = load(points.normal_y + j);
    const Lanes nz = load(points.slope + j);
    const Lanes w = weigh(weight_of(points, j, dz), nx, ny, nz);
    weights += w;
    distances += w * (load(points.plane + j) + nz * z);
    normal_x += w * nx;
    normal_y += w * ny;
    normal_z += w * nz;
    offset_x += w * load(points.offset_x + j);
    offset_y += w * load(points.offset_y + j);
    offset_z += w * dz;
  }
  return {sum(weights),
          sum(distances),
          {sum(normal_x), sum(normal_y), sum(normal_z)},
          {sum(offset_x), sum(offset_y), sum(offset_z)}};
}

std::size_t padded(std::uint32_t capacity) {
  // With padding, rounded to whole cache lines.
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
  const Sums all = sums_of(points, window, depth, kByDistance);
  if (!(all.weight > 0)) return {};
  const float value = all.value();
  const float length2 = all.normal.dot(all.normal);
  const float agreed = kAgree * all.weight;
  const bool agree = length2 >= agreed * agreed || !(length2 > 0);
  if (agree || std::abs(value) > kFar * points.reach) return {value, all.weight};

  const Vec3f mean = all.normal * (kSharpness / std::sqrt(length2));
  const Sums alike = sums_of(points, window, depth, [&](Lanes w, Lanes nx, Lanes ny, Lanes nz) {
    const Lanes t = mean[0] * nx + mean[1] * ny + mean[2] * nz - (kSharpness - 1);
    const Lanes likeness = t > 0.0F ? t : Lanes{};
    return w * (likeness * likeness + kUnlike);
  });
  return {alike.value(), all.weight};
}

MlsFrame mls_frame(const RayPoints& points, RayWindow window, float depth) {
  const Sums all = sums_of(points, window, depth, kByDistance);
  const float length = std::sqrt(all.normal.dot(all.normal));
  MlsFrame frame;
  if (length > 0) frame.normal = all.normal / length;
  if (all.weight > 0) frame.off_centre = std::sqrt(all.offset.dot(all.offset)) / (all.weight * points.reach);
  return frame;
}

}  // namespace plumbline
