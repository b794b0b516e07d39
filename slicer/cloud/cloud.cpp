#include "slicer/cloud/cloud.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

/// Calls put(mean) for each group of at most four neighbours, and reorders the points.
template <class Put>
void for_each_group(std::span<Vec3f> points, Put put) {
  constexpr std::size_t kMost = 4;
  if (points.size() <= kMost) {
    Vec3f sum = Vec3f::Zero();
    for (const Vec3f& p : points) sum += p - points[0];
    put(points[0] + sum / static_cast<float>(points.size()));
    return;
  }
  Box3f box;
  for (const Vec3f& p : points) box.extend(p);
  Eigen::Index axis = 0;
  box.size().maxCoeff(&axis);
  const std::size_t half = points.size() / 2;
  std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(half), points.end(),
                   [axis](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
  for_each_group(points.first(half), put);
  for_each_group(points.subspan(half), put);
}

}  // namespace

void PackedNormal::set(const Vec3f& n) {
  const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 1e-12F)) {
    x = y = z = 0;
    return;
  }
  const float scale = kScale / length;
  const auto round = [](float v) { return static_cast<std::int16_t>(v < 0 ? v - 0.5F : v + 0.5F); };
  x = round(n[0] * scale);
  y = round(n[1] * scale);
  z = round(n[2] * scale);
}

Expected<Cloud> Cloud::create(std::uint32_t capacity, Arena& arena) {
  Cloud cloud;
  PLUMBLINE_TRY(arena.take_top(cloud.position, capacity, "cloud"));
  PLUMBLINE_TRY(arena.take_top(cloud.normal, capacity, "cloud"));
  PLUMBLINE_TRY(arena.take_top(cloud.radius, capacity, "cloud"));
  return cloud;
}

Box3f Cloud::bounds() const {
  Box3f box;
  for (const Vec3f& p : positions()) box.extend(p);
  return box;
}

void Cloud::set_support_points(float points) {
  const float growth = std::sqrt(points / support_points);
  for (float& r : radius.first(size)) r *= growth;
  support_points = points;
}

void Cloud::average_neighbours() {
  std::uint32_t kept = 0;
  for_each_group(position.first(size), [&](const Vec3f& mean) { position[kept++] = mean; });
  size = kept;
  std::fill_n(normal.begin(), size, PackedNormal{});
}

void Cloud::drop_noise() {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (!is_surface(i)) continue;
    position[kept] = position[i];
    normal[kept] = normal[i];
    radius[kept] = radius[i];
    ++kept;
  }
  size = kept;
}

Status Cloud::give_back(std::uint32_t kept, Arena& arena) {
  const Cloud before = *this;
  const auto bytes_of = [](auto... column) { return (Arena::rounded(column.size_bytes()) + ...); };
  arena.release_top(arena.top_mark() + bytes_of(position, normal, radius));
  // The first column lies highest. Each moves up, over room that those above it have left.
  const auto move = [&](auto& column, auto from) -> Status {
    PLUMBLINE_TRY(arena.take_top(column, kept, "cloud"));
    std::copy_backward(from.begin(), from.begin() + size, column.begin() + size);
    return {};
  };
  PLUMBLINE_TRY(move(position, before.position));
  PLUMBLINE_TRY(move(normal, before.normal));
  return move(radius, before.radius);
}

void Cloud::reorder(std::span<std::uint32_t> order) {
  for (std::uint32_t start = 0; start < size; ++start) {
    // Along a cycle of the order each point moves to the place before it. A place that has its point comes from itself.
    const Vec3f first_position = position[start];
    const PackedNormal first_normal = normal[start];
    const float first_radius = radius[start];
    std::uint32_t to = start;
    for (std::uint32_t from = order[to]; from != start; from = order[to]) {
      position[to] = position[from];
      normal[to] = normal[from];
      radius[to] = radius[from];
      order[to] = to;
      to = from;
    }
    position[to] = first_position;
    normal[to] = first_normal;
    radius[to] = first_radius;
    order[to] = to;
  }
}

}  // namespace plumbline
