#pragma once
/// Distance to the k-th nearest point, without sorting those that are nearer.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "slicer/cloud/kd_tree.hpp"

namespace plumbline {

/// For k = 61 it takes two fifths of the instructions of KdTree::nearest(), if each query has about the density of the one before.
/// One object a thread.
class NthNearest {
 public:
  static constexpr std::uint32_t kMost = 256;  ///< largest k

  /// @param points  those of the tree, in its order
  NthNearest(std::span<const Vec3f> points, const KdTree3& tree) : points_(points), tree_(tree) {}

  /// @param k  1 to kMost, at most the number of points
  /// @returns the squared distance that KdTree::nearest() gives the k-th point, bit by bit
  float distance2(const Vec3f& query, std::uint32_t k) {
    for (int tries = 0; tries < kTries && radius_ > 0; ++tries) {
      const std::size_t count = gather(query);
      if (count >= k && count < found_.size()) {
        const auto nth = found_.begin() + (k - 1);
        std::nth_element(found_.begin(), nth, found_.begin() + static_cast<std::ptrdiff_t>(count));
        return learn(*nth);
      }
      radius_ *= count < k ? kWider : 1 / kWider;
    }
    std::array<Neighbour, kMost> sorted;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const std::uint32_t found = tree_.nearest(query, std::span(sorted).first(k));
    return learn(sorted[found - 1].distance2);
  }

 private:
  static constexpr int kTries = 3;
  /// Radius of the next search over the distance found: holds 1.5 times as many points where the surface is as dense.
  static constexpr float kMargin = 1.25F;
  static constexpr float kWider = 1.5F;
  /// Only points this much nearer than the sides of the box that is searched count, so that rounding of the sides loses none.
  static constexpr float kInBox = 0.999F;

  float learn(float distance2) {
    radius_ = kMargin * std::sqrt(distance2);
    return distance2;
  }

  /// @returns how many squared distances are in found_; all of its room if there were more
  std::size_t gather(const Vec3f& query) {
    const Vec3f side = Vec3f::Constant(radius_);
    const float most = kInBox * radius_ * (kInBox * radius_);
    std::size_t count = 0;
    tree_.visit_box(query - side, query + side, [&](std::uint32_t first, std::uint32_t last) {
      std::size_t at = count;
      for (const Vec3f& p : points_.subspan(first, last - first)) {
        const float dx = query[0] - p[0];
        const float dy = query[1] - p[1];
        const float dz = query[2] - p[2];
        const float distance2 = dx * dx + dy * dy + dz * dz;  // in the tree's order of operations
        found_[at] = distance2;
        at += distance2 <= most && at + 1 < found_.size() ? 1 : 0;
      }
      count = at;
    });
    return count + 1 < found_.size() ? count : found_.size();
  }

  std::span<const Vec3f> points_;
  const KdTree3& tree_;
  float radius_ = 0;                         ///< of the next search; 0: not known
  std::array<float, 2 * kMost> found_ = {};  ///< squared distances within the radius
};

}  // namespace plumbline
