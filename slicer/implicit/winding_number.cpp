#include "slicer/implicit/winding_number.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kBaseSamples = 48;  ///< samples a side, over the base plane
/// An opening in the base plane has winding number 1/2 there, a closed underside 0. Not kSurface, which asks inside or outside:
/// this asks open or closed. A larger value misses narrow openings, a smaller one takes noise for an opening.
constexpr float kBaseOpen = 0.1F;

}  // namespace

std::size_t WindingTree::bytes_needed(std::uint32_t points) {
  return Arena::rounded(nodes_needed(points) * sizeof(Node));
}

WindingTree WindingTree::build(const Cloud& cloud, std::span<Node> nodes) {
  WindingTree tree;
  tree.area_factor_ = std::numbers::pi_v<float> / cloud.support_points;
  tree.cloud_ = cloud;
  tree.tree_ = Tree(cloud.size, nodes);
  tree.tree_.build([&](std::uint32_t i, DipoleSum& sum) {
    const float area = tree.area_of(i);
    sum.add(cloud.position[i], area, cloud.normal[i].unpack() * (area * kInverse4Pi));
  });
  return tree;
}

bool WindingTree::set_base(float height, float reach, bool always) {
  base_ = height;
  has_base_ = always;
  if (always) return true;
  const Box3f box = cloud_.bounds();
  const auto sampled = [&](int axis, std::uint32_t i) {
    return box.low[axis] + (static_cast<float>(i) + 0.5F) / kBaseSamples * box.size()[axis];
  };
  has_base_ = is_underside_open([&](std::uint32_t section) {
    const float least = section == 0 ? kBaseOpen : kSurface;
    const float z = height + 2 * static_cast<float>(section) * reach;
    std::uint32_t count = 0;
#pragma omp parallel for schedule(dynamic, 16) reduction(+ : count)
    for (std::uint32_t i = 0; i < kBaseSamples * kBaseSamples; ++i) {
      count += number({sampled(0, i % kBaseSamples), sampled(1, i / kBaseSamples), z}, 1) > least ? 1 : 0;
    }
    return count;
  });
  return has_base_;
}

float WindingTree::number(const Vec3f& x, float share) const {
  if (x[2] < base()) return 0;
  const auto sum = [&](const Vec3f& from) {
    float w = 0;
    const auto add = [&](const Vec3f& place, const Vec3f& dipole, float softening) {
      const Vec3f e = place - from;
      const float softened = e.dot(e) + softening;
      w += dipole.dot(e) / (softened * std::sqrt(softened));
    };
    walk(from, add, share);
    return w;
  };
  // The mirrored surface seen from x is the surface seen from the mirror image of x: nothing is mirrored for each dipole.
  return has_base_ ? sum(x) + sum(mirrored(x)) : sum(x);
}

bool WindingTree::inside(const Vec3f& x, float winding) const {
  return is_plain(winding) ? winding > kSurface : lean_at(x).inside(winding);
}

WindingLean WindingTree::lean_at(const Vec3f& x) const {
  WindingLean lean;
  for_each_dipole(x, [&](const Vec3f& place, const Vec3f& dipole, float softening) {
    const float area = std::sqrt(dipole.dot(dipole));
    if (!(area > 0)) return;
    const Vec3f e = place - x;
    const float softened = e.dot(e) + softening;
    const float towards = dipole.dot(e) / (area * std::sqrt(softened));
    const float weight = area / (softened * softened);
    lean.weight += weight;
    lean.outwards += weight * towards * (1 - towards * towards);
  });
  return lean;
}

}  // namespace plumbline::inline slicer
