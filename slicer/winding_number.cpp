#include "slicer/winding_number.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr float kOpening = 2.0F;            ///< times a node's radius: nearer, and it is opened
constexpr std::uint32_t kBaseSamples = 48;  ///< a side, over the base plane
constexpr float kBaseOpen = 0.1F;           ///< a fifth of what an opening counts there
constexpr float kInverse4Pi = 0.0795774715F;
constexpr float kPi = 3.14159265F;

struct Builder {
  const Cloud& cloud;
  std::span<WindingTree::Node> nodes;
  float area_factor;

  struct Sum {
    Vec3f weighted = Vec3f::Zero();  ///< area * position
    Vec3f dipole = Vec3f::Zero();
    float area = 0;
    Box3f box;
  };

  float area(std::uint32_t i) const { return area_factor * cloud.radius[i] * cloud.radius[i]; }

  /// Builds the node `at` over leaves [first, last) and the ones under it; depth first, so that skipping is one number.
  Sum build(std::uint32_t at, std::uint32_t first, std::uint32_t last) {
    Sum sum;
    if (last - first == 1) {
      const std::uint32_t end = std::min(cloud.size, last * WindingTree::kLeafPoints);
      for (std::uint32_t i = first * WindingTree::kLeafPoints; i < end; ++i) {
        const float a = area(i);
        sum.weighted += cloud.position[i] * a;
        sum.dipole += cloud.normal[i].unpack() * (a * kInverse4Pi);
        sum.area += a;
        sum.box.extend(cloud.position[i]);
      }
    } else {
      const std::uint32_t middle = first + (last - first) / 2;
      sum = build(at + 1, first, middle);
      const Sum right = build(at + 2 * (middle - first), middle, last);
      sum.weighted += right.weighted;
      sum.dipole += right.dipole;
      sum.area += right.area;
      sum.box.extend(right.box.low);
      sum.box.extend(right.box.high);
    }
    WindingTree::Node& node = nodes[at];
    node.centre = sum.area > 0 ? Vec3f(sum.weighted / sum.area) : sum.box.centre();
    node.dipole = sum.dipole;
    // The farthest corner of the box bounds the farthest point.
    const Vec3f far = (sum.box.high - node.centre).cwiseMax(node.centre - sum.box.low);
    node.reach2 = kOpening * kOpening * far.dot(far);
    node.skip = at + 2 * (last - first) - 1;
    return sum;
  }
};

std::uint32_t leaves(std::uint32_t points) {
  return (points + WindingTree::kLeafPoints - 1) / WindingTree::kLeafPoints;
}

}  // namespace

std::size_t WindingTree::nodes_needed(std::uint32_t points) {
  return points == 0 ? 0 : std::size_t{leaves(points)} * 2 - 1;
}

std::size_t WindingTree::bytes_needed(std::uint32_t points) {
  return Arena::rounded(nodes_needed(points) * sizeof(Node));
}

WindingTree WindingTree::build(const Cloud& cloud, float support_points, std::span<Node> nodes) {
  WindingTree tree;
  tree.area_factor_ = kPi / support_points;
  if (cloud.size > 0) Builder{cloud, nodes, tree.area_factor_}.build(0, 0, leaves(cloud.size));
  tree.nodes_ = nodes;
  tree.position_ = cloud.position.first(cloud.size);
  tree.normal_ = cloud.normal.first(cloud.size);
  tree.radius_ = cloud.radius.first(cloud.size);
  return tree;
}

bool WindingTree::set_base(float height) {
  base_ = height;
  has_base_ = false;
  // On the plane itself the surface and its mirror image count the same: half each where it is open, nothing where the
  // surface closes above the plane.
  Box3f box;
  for (const Vec3f& p : position_) box.extend(p);
  const auto sampled = [&](int axis, std::uint32_t i) {
    return box.low[axis] + (static_cast<float>(i) + 0.5F) / kBaseSamples * box.size()[axis];
  };
  for (std::uint32_t i = 0; i < kBaseSamples * kBaseSamples && !has_base_; ++i) {
    const std::uint32_t row = i / kBaseSamples;
    has_base_ = sum({sampled(0, i % kBaseSamples), sampled(1, row), height}) > kBaseOpen;
  }
  return has_base_;
}

float WindingTree::operator()(const Vec3f& x) const {
  if (!has_base_) return sum(x);
  if (x[2] < base_) return 0;
  // The dipoles of the mirrored surface seen from x are those of the surface seen from the mirror image of x.
  return sum(x) + sum({x[0], x[1], 2 * base_ - x[2]});
}

float WindingTree::sum(const Vec3f& x) const {
  float w = 0;
  const auto count = static_cast<std::uint32_t>(nodes_.size());
  std::uint32_t leaf = 0;  // leaves before node `at`: a node over n leaves has 2 n - 1 nodes
  for (std::uint32_t at = 0; at < count;) {
    const Node& node = nodes_[at];
    const Vec3f d = node.centre - x;
    const float distance2 = d.dot(d);
    const std::uint32_t under = (node.skip - at + 1) / 2;
    if (distance2 > node.reach2) {
      w += node.dipole.dot(d) / (distance2 * std::sqrt(distance2));
      leaf += under;
      at = node.skip;
    } else if (under > 1) {
      ++at;
    } else {
      const std::uint32_t first = leaf * kLeafPoints;
      const std::uint32_t last = std::min(static_cast<std::uint32_t>(position_.size()), first + kLeafPoints);
      for (std::uint32_t i = first; i < last; ++i) {
        const Vec3f e = position_[i] - x;
        const float area = area_factor_ * radius_[i] * radius_[i];
        // A disc seen from nearby fills half the sphere and no more; the dipole of a point would grow without bound.
        const float softened = e.dot(e) + area * (1.0F / kPi);
        w += area * kInverse4Pi * normal_[i].unpack().dot(e) / (softened * std::sqrt(softened));
      }
      ++leaf;
      ++at;
    }
  }
  return w;
}

}  // namespace plumbline
