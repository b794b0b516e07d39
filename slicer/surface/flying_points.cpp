#include "slicer/surface/flying_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "slicer/core/numbers/median.hpp"
#include "slicer/surface/sparse_surface.hpp"
#include "slicer/surface/stray_pieces.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kSheet = 8;  ///< nearest points whose sheet a point must lie on
/// Cosine within which the nearest points lie in one direction: a string of flying pixels. A surface has a tip so thin only
/// if it is a needle of 16 degrees.
constexpr float kInLine = 0.99F;
constexpr float kDeviations = 5;  ///< of the neighbours' own heights; a surface point is rarely higher
/// Epsilons, half the distance of two points: flying points that make an object larger by less stay, since sharp tips look like
/// them.
constexpr float kLeastReach = 0.115F;
constexpr std::uint32_t kMostShare = 20;      ///< at most one point in so many is flying
constexpr std::size_t kFirstCandidates = 64;  ///< sorted at first

/// Room for the nearest points, more than a clump has: a point beside a sheet is above most of them, whatever else hangs there.
using Nearest = std::array<Neighbour, kFewestOfPiece>;

class FlyingPoints {
 public:
  FlyingPoints(Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering, std::span<std::uint32_t> order,
               std::span<std::uint32_t> marked)
      : cloud_(cloud), tree_(tree), clustering_(clustering), order_(order), marked_(marked) {}

  std::uint32_t mark() {
    for (int axis = 0; axis < 3; ++axis) {
      if (!mark_side(axis, -1) || !mark_side(axis, 1)) {
        restore(0);
        return 0;
      }
    }
    return count_;
  }

 private:
  /// Makes the points marked last surface again.
  /// @param count  how many stay marked
  void restore(std::uint32_t count) {
    for (; count_ > count; --count_) {
      PackedNormal& normal = cloud_.normal[marked_[count_ - 1]];
      normal.point_class = orientation_of(normal);
    }
  }

  /// @param sign  1: the highest coordinates
  /// @returns false if too many points are flying
  bool mark_side(int axis, float sign) {
    const std::uint32_t count_before = count_;
    std::size_t size = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (cloud_.is_surface(i)) order_[size++] = i;
    }
    const auto farther = [&](std::uint32_t a, std::uint32_t b) {
      const float x = sign * cloud_.position[a][axis];
      const float y = sign * cloud_.position[b][axis];
      return x > y || (x == y && a < b);
    };
    // Sorted in portions that double: a heap of all points takes 3 % of a clean scan's time.
    const auto candidates = order_.first(size);
    std::size_t sorted = 0;
    for (std::size_t k = 0; k < size; ++k) {
      if (k == sorted) {
        sorted = std::min(size, 2 * sorted + kFirstCandidates);
        std::partial_sort(candidates.begin() + static_cast<std::ptrdiff_t>(k),
                          candidates.begin() + static_cast<std::ptrdiff_t>(sorted), candidates.end(), farther);
      }
      const std::uint32_t i = candidates[k];
      if (!is_flying(i)) {
        const float reach = std::abs(cloud_.position[candidates[0]][axis] - cloud_.position[i][axis]);
        if (reach < kLeastReach * clustering_.epsilon) restore(count_before);
        return true;
      }
      if (count_ == marked_.size()) return false;
      cloud_.normal[i].point_class = PointClass::kNoise;
      marked_[count_++] = i;
    }
    return false;
  }

  std::span<const Neighbour> nearest(std::uint32_t i, Nearest& room) const {
    const auto counts = [&](std::uint32_t other) { return other != i && cloud_.is_surface(other); };
    return std::span(room).first(tree_.nearest(cloud_.position[i], room, counts));
  }

  bool is_flying(std::uint32_t i) const {
    Nearest room;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const auto neighbours = nearest(i, room);
    if (neighbours.size() < kSheet) return true;
    return is_above(i, neighbours) || ends_a_string(i, neighbours.first(kSheet)) || !is_together(i);
  }

  /// Height of point i over the tangent plane of another; 0 below it, as beside an edge of the other side.
  float height(std::uint32_t i, std::uint32_t over) const {
    return std::max(0.0F, cloud_.normal[over].unpack().dot(cloud_.position[i] - cloud_.position[over]));
  }

  /// Mean height of a point over the tangent planes of its neighbours.
  float mean_height(std::uint32_t i, std::span<const Neighbour> neighbours) const {
    float sum = 0;
    for (const Neighbour& n : neighbours) sum += height(i, n.index);
    return sum / static_cast<float>(neighbours.size());
  }

  bool is_above(std::uint32_t i, std::span<const Neighbour> neighbours) const {
    float distance = 0;
    for (const Neighbour& n : neighbours) distance += std::sqrt(n.distance2);
    const float height = mean_height(i, neighbours);
    if (!(height * static_cast<float>(neighbours.size()) > kMostHeight * distance)) return false;
    // Curvature makes heights, too, and noise does. Both are the same around the point.
    std::array<float, kFewestOfPiece> heights;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const auto of_neighbours = std::span(heights).first(neighbours.size());
    for (std::size_t k = 0; k < neighbours.size(); ++k) {
      Nearest room;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      of_neighbours[k] = mean_height(neighbours[k].index, nearest(neighbours[k].index, room));
    }
    const float middle = median(of_neighbours);
    for (float& h : of_neighbours) h = std::abs(h - middle);
    const float deviation = static_cast<float>(kMedianToDeviation) * median(of_neighbours);
    return height > middle + kDeviations * deviation;
  }

  bool ends_a_string(std::uint32_t i, std::span<const Neighbour> neighbours) const {
    const auto towards = [&](const Neighbour& n) -> Vec3f {
      return (cloud_.position[n.index] - cloud_.position[i]) / std::sqrt(n.distance2);
    };
    Vec3f mean = Vec3f::Zero();
    for (const Neighbour& n : neighbours) {
      if (!(n.distance2 > 0)) return false;
      mean += towards(n);
    }
    const float length = std::sqrt(mean.dot(mean));
    return std::all_of(neighbours.begin(), neighbours.end(),
                       [&](const Neighbour& n) { return towards(n).dot(mean) > kInLine * length; });
  }

  /// How far apart two points hang together, mm: farther where both belong to a sparse part of the surface.
  float step(std::uint32_t a, std::uint32_t b) const {
    return std::max(kTogetherEpsilons * clustering_.epsilon, std::min(cloud_.radius[a], cloud_.radius[b]));
  }

  /// Whether at least kFewestOfPiece points hang together with point i.
  bool is_together(std::uint32_t i) const {
    std::array<std::uint32_t, kFewestOfPiece> reached = {i};
    std::uint32_t size = 1;
    for (std::uint32_t next = 0; next < size; ++next) {
      Nearest room;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      for (const Neighbour& n : nearest(reached[next], room)) {
        const float most = step(reached[next], n.index);
        if (n.distance2 > most * most) continue;
        if (std::find(reached.begin(), reached.begin() + size, n.index) != reached.begin() + size) continue;
        if (size == kFewestOfPiece) return true;
        reached[size++] = n.index;
      }
    }
    return size == kFewestOfPiece;
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  const ClusteringResult& clustering_;
  std::span<std::uint32_t> order_;
  std::span<std::uint32_t> marked_;
  std::uint32_t count_ = 0;  ///< of marked_
};

}  // namespace

Expected<std::uint32_t> mark_flying_points(Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering,
                                           Arena& arena) {
  const ArenaScope scope(arena);
  std::span<std::uint32_t> order, marked;
  PLUMBLINE_TRY(arena.take_top(order, cloud.size, "flying points"));
  PLUMBLINE_TRY(arena.take_top(marked, cloud.size / kMostShare, "flying points"));
  const std::uint32_t count = FlyingPoints(cloud, tree, clustering, order, marked).mark();
  return count;
}

}  // namespace plumbline::inline slicer
