#include "slicer/implicit/winding_number.hpp"

#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

constexpr std::uint32_t kBaseSamples = 48;  ///< samples a side, over the base plane
/// An opening in the base plane has winding number 1/2 there, a closed underside 0. Not kSurface, which asks inside or outside:
/// this asks open or closed. A larger value misses narrow openings, a smaller one takes noise for an opening.
constexpr float kBaseOpen = 0.1F;
constexpr float kPi = std::numbers::pi_v<float>;

}  // namespace

std::size_t WindingTree::bytes_needed(std::uint32_t points) {
  return Arena::rounded(nodes_needed(points) * sizeof(Node));
}

WindingTree WindingTree::build(const Cloud& cloud, std::span<Node> nodes) {
  WindingTree tree;
  tree.area_factor_ = kPi / cloud.support_points;
  tree.position_ = cloud.position.first(cloud.size);
  tree.normal_ = cloud.normal.first(cloud.size);
  tree.radius_ = cloud.radius.first(cloud.size);
  tree.tree_ = Tree(cloud.size, nodes);
  tree.tree_.build([&](std::uint32_t i, DipoleSum& sum) {
    const float area = tree.area_of(i);
    sum.add(cloud.position[i], area, cloud.normal[i].unpack() * (area * kInverse4Pi));
  });
  return tree;
}

bool WindingTree::set_base(float height, float step, bool always) {
  base_ = height;
  has_base_ = always;
  if (always) return true;
  Box3f box;
  for (const Vec3f& p : position_) box.extend(p);
  const auto sampled = [&](int axis, std::uint32_t i) {
    return box.low[axis] + (static_cast<float>(i) + 0.5F) / kBaseSamples * box.size()[axis];
  };
  has_base_ = is_underside_open([&](std::uint32_t section) {
    const float least = section == 0 ? kBaseOpen : kSurface;
    const float z = height + static_cast<float>(section) * step;
    std::uint32_t count = 0;
#pragma omp parallel for schedule(dynamic, 16) reduction(+ : count)
    for (std::uint32_t i = 0; i < kBaseSamples * kBaseSamples; ++i) {
      count += sum({sampled(0, i % kBaseSamples), sampled(1, i / kBaseSamples), z}) > least ? 1 : 0;
    }
    return count;
  });
  return has_base_;
}

float WindingTree::number(const Vec3f& x, float share) const {
  if (!has_base_) return sum(x, share);
  if (x[2] < base_) return 0;
  // The mirrored surface seen from x is the surface seen from the mirror image of x.
  return sum(x, share) + sum({x[0], x[1], 2 * base_ - x[2]}, share);
}

bool WindingTree::inside(const Vec3f& x, float winding) const {
  if (is_plain(winding)) return winding > kSurface;
  WindingLean lean;
  add_lean(x, lean);
  if (has_base_) add_lean({x[0], x[1], 2 * base_ - x[2]}, lean);
  return lean.inside(winding);
}

float WindingTree::sum(const Vec3f& x, float share) const {
  float w = 0;
  tree_.walk(
      x,
      [&](const Node& node, const Vec3f& d, float distance2) {
        w += node.dipole.dot(d) / (distance2 * std::sqrt(distance2));
      },
      [&](std::uint32_t i) {
        const Vec3f e = position_[i] - x;
        const float area = area_of(i);
        const float softened = e.dot(e) + softening_of(i);
        w += area * kInverse4Pi * normal_[i].unpack().dot(e) / (softened * std::sqrt(softened));
      },
      share);
  return w;
}

void WindingTree::add_lean(const Vec3f& x, WindingLean& lean) const {
  const auto add = [&](float area, float towards, float distance2) {
    const float weight = area / (distance2 * distance2);
    lean.weight += weight;
    lean.outwards += weight * towards * (1 - towards * towards);
  };
  tree_.walk(
      x,
      [&](const Node& node, const Vec3f& d, float distance2) {
        const float area = std::sqrt(node.dipole.dot(node.dipole));
        if (area > 0) add(area, node.dipole.dot(d) / (area * std::sqrt(distance2)), distance2);
      },
      [&](std::uint32_t i) {
        const Vec3f e = position_[i] - x;
        const float area = area_of(i);
        const float softened = e.dot(e) + softening_of(i);
        add(area * kInverse4Pi, normal_[i].unpack().dot(e) / std::sqrt(softened), softened);
      });
}

}  // namespace plumbline
