#include "slicer/cloud/cloud.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "slicer/cloud/point_groups.hpp"

namespace plumbline::inline slicer {

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

Expected<Cloud> Cloud::create(std::uint32_t capacity, Arena& arena, bool with_views) {
  Cloud cloud;
  if (with_views) {
    PLUMBLINE_TRY(arena.take_top(cloud.views.scanner, kMaxViews, "cloud"));
    PLUMBLINE_TRY(arena.take_top(cloud.views.has_scanner, kMaxViews, "cloud"));
  }
  PLUMBLINE_TRY(arena.take_top(cloud.position, capacity, "cloud"));
  PLUMBLINE_TRY(arena.take_top(cloud.normal, capacity, "cloud"));
  PLUMBLINE_TRY(arena.take_top(cloud.radius, capacity, "cloud"));
  if (with_views) PLUMBLINE_TRY(arena.take_top(cloud.views.of, capacity, "cloud"));
  return cloud;
}

void Cloud::set_runs() {
  const auto first_of = [&](std::uint32_t run) {
    return static_cast<std::size_t>((std::uint64_t{size} * run + kRuns - 1) / kRuns);
  };
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    const std::size_t first = first_of(run);
    std::ranges::fill(views.of.subspan(first, first_of(run + 1) - first), static_cast<std::uint8_t>(run));
  }
  views.count = kRuns;
  std::fill_n(views.has_scanner.begin(), kRuns, false);
  views.are_runs = true;
}

bool Cloud::spans_area() const {
  // Rounding makes a line 1e-6 of its length wide. The thinnest thing that anybody prints is 1e-3.
  constexpr float kLeastWidth = 1e-4F;
  if (size == 0) return false;
  const Vec3f start = position[0];
  Vec3f line = Vec3f::Zero();
  for (const Vec3f& p : positions()) {
    if ((p - start).squaredNorm() > line.squaredNorm()) line = p - start;
  }
  const float length = std::sqrt(line.squaredNorm());
  return std::any_of(positions().begin(), positions().end(), [&](const Vec3f& p) {
    return std::sqrt((p - start).cross(line).squaredNorm()) > kLeastWidth * length * length;
  });
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
  constexpr std::size_t kMost = 4;
  std::uint32_t kept = 0;
  const auto is_group = [](std::span<const Vec3f> points, float /*side*/) { return points.size() <= kMost; };
  for_each_group(position.first(size), std::identity(), is_group, [&](std::span<const Vec3f> group) {
    Vec3f sum = Vec3f::Zero();
    for (const Vec3f& p : group) sum += p - group[0];
    position[kept++] = group[0] + sum / static_cast<float>(group.size());
  });
  size = kept;
  std::ranges::fill(views.of, kNoView);
  views.count = 0;
  std::fill_n(normal.begin(), size, PackedNormal{});
}

void Cloud::keep(FunctionRef<bool(std::uint32_t)> stays) {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (!stays(i)) continue;
    position[kept] = position[i];
    normal[kept] = normal[i];
    radius[kept] = radius[i];
    if (views) views.of[kept] = views.of[i];
    ++kept;
  }
  size = kept;
}

void Cloud::drop_noise() {
  keep([this](std::uint32_t i) { return is_surface(i); });
}

Status Cloud::give_back(Arena& arena, bool with_views) {
  const Cloud before = *this;
  const auto bytes_of = [](auto... column) { return (Arena::rounded(column.size_bytes()) + ...); };
  arena.release_top(arena.top_mark() + bytes_of(position, normal, radius, views.of));
  // The first column lies highest. Each moves up, over room that those above it have left.
  const auto move = [&](auto& column, auto from) -> Status {
    PLUMBLINE_TRY(arena.take_top(column, size, "cloud"));
    std::copy_backward(from.begin(), from.begin() + size, column.begin() + size);
    return {};
  };
  PLUMBLINE_TRY(move(position, before.position));
  PLUMBLINE_TRY(move(normal, before.normal));
  PLUMBLINE_TRY(move(radius, before.radius));
  if (!with_views) views.of = {};
  return views ? move(views.of, before.views.of) : Status();
}

void Cloud::reorder(std::span<std::uint32_t> order) {
  for (std::uint32_t start = 0; start < size; ++start) {
    // Along a cycle of the order each point moves to the place before it. A place that has its point comes from itself.
    const Vec3f first_position = position[start];
    const PackedNormal first_normal = normal[start];
    const float first_radius = radius[start];
    const std::uint8_t first_view = view_of(start);
    std::uint32_t to = start;
    for (std::uint32_t from = order[to]; from != start; from = order[to]) {
      position[to] = position[from];
      normal[to] = normal[from];
      radius[to] = radius[from];
      if (views) views.of[to] = views.of[from];
      order[to] = to;
      to = from;
    }
    position[to] = first_position;
    normal[to] = first_normal;
    radius[to] = first_radius;
    if (views) views.of[to] = first_view;
    order[to] = to;
  }
}

}  // namespace plumbline::inline slicer
