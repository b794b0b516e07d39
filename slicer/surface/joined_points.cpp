#include "slicer/surface/joined_points.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "slicer/surface/surface_class.hpp"

namespace plumbline::inline slicer {
namespace {

/// Share of its support radius within which a point is joined where there is room. A wider one blurs: with 0.2, gear noisy had a wrong island under
/// it, with 0.25 nefertiti photo had 34 wrong islands and holes instead of 24.
constexpr float kShare = 0.15F;
constexpr float kAlike = 0.9F;    ///< least inner product of the normals of a joined point: 26 degrees
constexpr std::size_t kOpen = 6;  ///< joined points that may still grow: some for each side of a thin wall

/// Sums over points; positions relative to the first.
struct Joined {
  Vec3f first = Vec3f::Zero();
  Vec3f position = Vec3f::Zero();
  Vec3f normal = Vec3f::Zero();
  float along = 0;  ///< of <n_i, p_i>
  float radius2 = 0;
  std::uint32_t points = 0;

  bool accepts(const Vec3f& p, const Vec3f& n, float reach2) const {
    if (points == 0 || points == std::numeric_limits<std::uint8_t>::max()) return false;
    const auto count = static_cast<float>(points);
    const Vec3f d = p - first - position / count;
    const float alike = n.dot(normal);
    return d.dot(d) <= reach2 && alike > 0 && alike * alike > kAlike * kAlike * normal.dot(normal);
  }
  void add(const Vec3f& p, const Vec3f& n, float radius) {
    if (points == 0) first = p;
    const Vec3f d = p - first;
    position += d;
    normal += n;
    along += n.dot(d);
    radius2 += radius * radius;
    ++points;
  }
  void put(Cloud& cloud, std::uint32_t at) const {
    const float each = 1.0F / static_cast<float>(points);
    const Vec3f mean = position * each;
    const float off = 0.5F * (along - normal.dot(mean)) * each;
    PackedNormal& to = cloud.normal[at];
    to.set(normal);
    cloud.position[at] = first + mean + to.unpack() * off;
    cloud.radius[at] = std::sqrt(radius2 * each);
    to.weight = static_cast<std::uint8_t>(points);
    to.point_class = orientation_of(to);
  }
};

/// @param share  of its support radius within which a point is joined
/// @param put    put(joined): each point that is left, in their order
template <class Put>
void join(const Cloud& cloud, float share, Put put) {
  std::array<Joined, kOpen> open;
  std::size_t next = 0;  // the one that began first
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const Vec3f p = cloud.position[i];
    const Vec3f n = cloud.normal[i].unpack();
    const float radius = cloud.radius[i];
    const float reach = share * radius;
    std::size_t at = 0;
    while (at < kOpen && !open[at].accepts(p, n, reach * reach)) ++at;
    if (at == kOpen) {
      at = next;
      next = (next + 1) % kOpen;
      if (open[at].points > 0) put(open[at]);
      open[at] = {};
    }
    open[at].add(p, n, radius);
  }
  for (std::size_t k = 0; k < kOpen; ++k) {
    const Joined& last = open[(next + k) % kOpen];
    if (last.points > 0) put(last);
  }
}

/// @returns the least share, within a sixteenth, that leaves no more than `most` points; at most 1
float share_for(const Cloud& cloud, std::uint32_t most) {
  constexpr int kHalvings = 5;
  const auto fits = [&](float share) {
    std::uint32_t left = 0;
    join(cloud, share, [&](const Joined&) { ++left; });
    return left <= most;
  };
  if (most >= cloud.size || fits(kShare)) return kShare;
  float low = kShare;
  float high = 1;
  for (int step = 0; step < kHalvings; ++step) {
    const float middle = std::sqrt(low * high);
    (fits(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

void join_points(Cloud& cloud, std::uint32_t most) {
  std::uint32_t kept = 0;
  join(cloud, share_for(cloud, most), [&](const Joined& joined) { joined.put(cloud, kept++); });
  cloud.size = kept;
}

}  // namespace plumbline::inline slicer
