#include "slicer/cloud/cloud.hpp"

#include <cmath>

namespace plumbline {

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
  const auto position = arena.take_top<Vec3f>(capacity, "cloud");
  if (!position) return tl::unexpected<Error>(position.error());
  const auto normal = arena.take_top<PackedNormal>(capacity, "cloud");
  if (!normal) return tl::unexpected<Error>(normal.error());
  const auto radius = arena.take_top<float>(capacity, "cloud");
  if (!radius) return tl::unexpected<Error>(radius.error());
  Cloud cloud;
  cloud.position = *position;
  cloud.normal = *normal;
  cloud.radius = *radius;
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

void Cloud::drop_noise() {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (normal[i].point_class == PointClass::kNoise) continue;
    position[kept] = position[i];
    normal[kept] = normal[i];
    radius[kept] = radius[i];
    ++kept;
  }
  size = kept;
}

Status Cloud::reorder(std::span<const std::uint32_t> order, Arena& arena) {
  const ArenaScope scope(arena);
  auto bits = arena.take_top<std::uint64_t>((size + 63) / 64, "reordering the cloud");
  if (!bits) return tl::unexpected<Error>(bits.error());
  std::span<std::uint64_t> done = *bits;
  std::fill(done.begin(), done.end(), 0);
  for (std::uint32_t start = 0; start < size; ++start) {
    if ((done[start / 64] >> (start % 64)) & 1U) continue;
    // Follow the cycle of the permutation that starts here.
    const Vec3f first_position = position[start];
    const PackedNormal first_normal = normal[start];
    const float first_radius = radius[start];
    std::uint32_t at = start;
    for (;;) {
      done[at / 64] |= std::uint64_t{1} << (at % 64);
      const std::uint32_t from = order[at];
      if (from == start) break;
      position[at] = position[from];
      normal[at] = normal[from];
      radius[at] = radius[from];
      at = from;
    }
    position[at] = first_position;
    normal[at] = first_normal;
    radius[at] = first_radius;
  }
  return {};
}

}  // namespace plumbline
