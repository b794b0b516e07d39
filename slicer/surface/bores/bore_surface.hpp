#pragma once
/// The surface of a scan as the search for bores needs it.

#include <algorithm>
#include <array>
#include <optional>

#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// Least inner product of a wall's normal with the direction to the middle of its bore: within 73 degrees.
inline constexpr float kWallCosine = 0.3F;
inline constexpr float kLeastUnseen = 2;  ///< epsilons without wall along a bore; shorter gaps are closed without help

/// A point on a sparse wall that has another wall opposite.
struct BoreEnd {
  std::uint32_t point = 0;
  float width = 0;         ///< distance of the two walls
  bool not_round = false;  ///< no round bore was found from here
};

/// Lengths are in the unit of the cloud.
class BoreSurface {
 public:
  /// Distance between added points, in epsilons. Epsilon is a radius that holds about 60 scanned points, so added walls
  /// are sparser than the scan, but denser than a surface that counts as sparse (BoreSurface::is_sparse).
  static constexpr float kSpacing = 0.5F;

  /// @param cloud  classes and radius[] set; added points become its last
  BoreSurface(Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering);

  float epsilon() const { return clustering_.epsilon; }
  float noise() const { return clustering_.noise; }
  std::uint32_t scanned() const { return scanned_; }  ///< points of the scan, the first of the cloud
  std::uint32_t added() const { return cloud_.size - scanned_; }
  bool full() const { return cloud_.size == cloud_.capacity(); }
  const Vec3f& position(std::uint32_t i) const { return cloud_.position[i]; }
  Vec3f normal(std::uint32_t i) const { return cloud_.normal[i].unpack(); }

  bool is_surface(std::uint32_t i) const { return cloud_.is_surface(i); }

  /// Radius of a disc as large as point i's share of the surface, epsilon at most.
  float share_radius(std::uint32_t i) const { return std::min(cloud_.radius[i] / support_over_share_, epsilon()); }

  /// Whether the surface around point i has less than a fifth of the density that epsilon stands for.
  bool is_sparse(std::uint32_t i) const;

  /// Distance from point i to the wall that faces it; nothing if there is none within eight epsilon.
  std::optional<float> width_at(std::uint32_t i) const;

  /// Squared distance from x to the nearest point of the scanned surface.
  float distance2(const Vec3f& x) const;

  /// Whether `holds` is true for any of the eight surface points nearest to x.
  template <class Holds>
  bool any_near(const Vec3f& x, Holds holds) const {
    std::array<Neighbour, 8> found{};
    const std::uint32_t count = tree_.nearest(x, found, [&](std::uint32_t i) { return is_surface(i); });
    return std::any_of(found.begin(), found.begin() + count, holds);
  }

  /// Calls visit(i) for the points of the scan in a box, noise included, and for some outside it.
  template <class Visit>
  void visit_box(const Vec3f& low, const Vec3f& high, Visit visit) const {
    tree_.visit_box(low, high, [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t i = from; i < to; ++i) visit(i);
    });
  }

  /// Whether x lies within the share of a scanned point of this wall, or closer to one than added points are to each
  /// other.
  bool has_wall(const Vec3f& x, const Vec3f& facing) const;

  /// Adds a point that stands for a square of kSpacing epsilon. Does nothing when the cloud is full.
  void add(const Vec3f& x, const Vec3f& normal);

  /// Sets the normal of a point and makes it part of the surface.
  void set_normal(std::uint32_t i, const Vec3f& normal);
  void mark_noise(std::uint32_t i) { cloud_.normal[i].point_class = PointClass::kNoise; }

 private:
  Cloud& cloud_;
  const KdTree3& tree_;
  const ClusteringResult& clustering_;
  float support_over_share_;  ///< support radius over the radius of one point's share
  std::uint32_t scanned_;
};

}  // namespace plumbline
