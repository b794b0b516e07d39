#include "slicer/cloud/cloud.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace plumbline {
namespace {

/// What is moved at a time: a normal, or two numbers.
struct Piece {
  float a, b;
};
static_assert(sizeof(Piece) == sizeof(PackedNormal));

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

std::size_t Cloud::reorder_bytes(std::uint32_t points) { return points * sizeof(Piece); }

Status Cloud::reorder(std::span<const std::uint32_t> order, Arena& arena) {
  const ArenaScope scope(arena);
  const auto room = arena.take_top<Piece>(size, "reordering the cloud");
  PLUMBLINE_TRY(room);
  const auto copy = [&](auto from, auto to) {
#pragma omp parallel for schedule(static)
    for (std::uint32_t i = 0; i < size; ++i) (*room)[i] = from(order[i]);
#pragma omp parallel for schedule(static)
    for (std::uint32_t i = 0; i < size; ++i) to(i, (*room)[i]);
  };
  copy(
      [&](std::uint32_t i) {
        return Piece{position[i][0], position[i][1]};
      },
      [&](std::uint32_t i, const Piece& piece) { position[i].head<2>() << piece.a, piece.b; });
  copy(
      [&](std::uint32_t i) {
        return Piece{position[i][2], radius[i]};
      },
      [&](std::uint32_t i, const Piece& piece) {
        position[i][2] = piece.a;
        radius[i] = piece.b;
      });
  copy([&](std::uint32_t i) { return std::bit_cast<Piece>(normal[i]); },
       [&](std::uint32_t i, const Piece& piece) { normal[i] = std::bit_cast<PackedNormal>(piece); });
  return {};
}

}  // namespace plumbline
