#pragma once
/// The surface of a scan as those ask it who look for bores.

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// A point of a wall that was hardly seen, with a wall that faces it.
struct BoreEnd {
  std::uint32_t point = 0;
  float width = 0;     ///< from wall to wall
  bool tried = false;  ///< no round bore starts here
};

/// Lengths are in the unit of the cloud.
class BoreSurface {
 public:
  static constexpr float kSpacing = 0.5F;  ///< of epsilon, of the points that are added

  /// @param cloud  classes and radius[] set; points that are added are its last
  BoreSurface(Cloud& cloud, const KdTree3& tree, ClusteringResult& clustering);

  float epsilon() const { return clustering_.epsilon; }
  float noise() const { return clustering_.noise; }
  std::uint32_t seen() const { return seen_; }  ///< points of the scan
  std::uint32_t added() const { return cloud_.size - seen_; }
  bool full() const { return cloud_.size == cloud_.capacity(); }
  const Vec3f& position(std::uint32_t i) const { return cloud_.position[i]; }
  Vec3f normal(std::uint32_t i) const { return cloud_.normal[i].unpack(); }

  bool is_surface(std::uint32_t i) const { return cloud_.normal[i].point_class != PointClass::kNoise; }

  /// Radius of a disc as large as the share of the surface that point i stands for, epsilon at most.
  float share(std::uint32_t i) const { return std::min(cloud_.radius[i] / growth_, epsilon()); }

  /// Whether the surface round point i has less than a fifth of the density that epsilon tells.
  bool hardly_seen(std::uint32_t i) const;

  /// How far off point i the wall is that faces it; nothing if there is none within eight epsilon.
  std::optional<float> width_at(std::uint32_t i) const;

  /// From x to the surface as it was seen, squared.
  float distance2(const Vec3f& x) const;

  /// Whether it holds for one of the eight points of the surface that are nearest to x.
  template <class Holds>
  bool any_near(const Vec3f& x, Holds holds) const {
    std::array<Neighbour, 8> found{};
    const std::uint32_t count = tree_.nearest(x, found, [&](std::uint32_t i) { return is_surface(i); });
    return std::any_of(found.begin(), found.begin() + count, holds);
  }

  /// Calls visit(i) for the points of the scan in a box, noise included, and some outside it.
  template <class Visit>
  void visit_box(const Vec3f& low, const Vec3f& high, Visit visit) const {
    tree_.visit_box(low, high, [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t i = from; i < to; ++i) visit(i);
    });
  }

  /// Whether a point of the wall was seen that x lies in the share of, or so near that none is added.
  bool has_wall(const Vec3f& x, const Vec3f& facing) const;

  /// Adds a point that stands for a square of kSpacing epsilon; not if there is no room.
  void add(const Vec3f& x, const Vec3f& normal);

  void turn(std::uint32_t i, const Vec3f& normal);  ///< and makes it one of the surface
  void drop(std::uint32_t i);                       ///< makes it noise

 private:
  void reclass(std::uint32_t i, PointClass point_class);

  Cloud& cloud_;
  const KdTree3& tree_;
  ClusteringResult& clustering_;
  float growth_;  ///< of a support's radius over that of one point's share
  std::uint32_t seen_;
};

}  // namespace plumbline
