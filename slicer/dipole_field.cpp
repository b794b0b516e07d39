#include "slicer/dipole_field.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr float kOpening = 2.0F;  ///< times a node's radius: nearer, and it is opened

std::uint32_t leaves(std::uint32_t points) {
  return (points + DipoleField::kLeafPoints - 1) / DipoleField::kLeafPoints;
}

/// Adds <dipole, e> / |e|^3 and its gradient by x, where e = p - x and |e|^2 is `distance2`.
void add(const Vec3f& dipole, const Vec3f& e, float distance2, DipoleField::Value& value) {
  const float inverse2 = 1 / distance2;
  const float inverse3 = inverse2 * std::sqrt(inverse2);
  const float along = dipole.dot(e);
  value.winding += along * inverse3;
  value.gradient += (e * (3 * along * inverse2) - dipole) * inverse3;
}

}  // namespace

struct DipoleField::Sum {
  Vec3f weighted = Vec3f::Zero();  ///< area * position
  Vec3f dipole = Vec3f::Zero();
  float area = 0;
  Box3f box;
};

std::size_t DipoleField::nodes_needed(std::uint32_t points) {
  return points == 0 ? 0 : std::size_t{leaves(points)} * 2 - 1;
}

void DipoleField::build(Sign sign) {
  if (cloud_.size > 0) build(0, 0, leaves(cloud_.size), sign);
}

DipoleField::Sum DipoleField::build(std::uint32_t at, std::uint32_t first, std::uint32_t last, Sign sign) {
  Sum sum;
  if (last - first == 1) {
    const std::uint32_t end = std::min(cloud_.size, last * kLeafPoints);
    for (std::uint32_t i = first * kLeafPoints; i < end; ++i) {
      const float s = sign(i);
      if (s == 0) continue;
      const float area4pi = cloud_.radius[i] * cloud_.radius[i] * 0.25F;  // over 4 pi, as the dipoles are
      sum.weighted += cloud_.position[i] * area4pi;
      sum.dipole += cloud_.normal[i].unpack() * (s * area4pi);
      sum.area += area4pi;
      sum.box.extend(cloud_.position[i]);
    }
  } else {
    const std::uint32_t middle = first + (last - first) / 2;
    sum = build(at + 1, first, middle, sign);
    const Sum right = build(at + 2 * (middle - first), middle, last, sign);
    sum.weighted += right.weighted;
    sum.dipole += right.dipole;
    sum.area += right.area;
    sum.box.low = sum.box.low.cwiseMin(right.box.low);
    sum.box.high = sum.box.high.cwiseMax(right.box.high);
  }
  Node& node = nodes_[at];
  node.skip = at + 2 * (last - first) - 1;
  node.dipole = sum.dipole;
  node.reach2 = -1;  // nothing in it: never opened, adds nothing
  node.centre = Vec3f::Zero();
  if (!sum.box.empty()) {
    node.centre = sum.area > 0 ? Vec3f(sum.weighted / sum.area) : sum.box.centre();
    // The farthest corner of the box bounds the farthest point.
    const Vec3f far = (sum.box.high - node.centre).cwiseMax(node.centre - sum.box.low);
    node.reach2 = kOpening * kOpening * far.dot(far);
  }
  return sum;
}

DipoleField::Value DipoleField::operator()(const Vec3f& x, Sign sign) const {
  Value value;
  const auto count = static_cast<std::uint32_t>(nodes_.size());
  std::uint32_t leaf = 0;  // leaves before node `at`: a node over n leaves has 2 n - 1 nodes
  for (std::uint32_t at = 0; at < count;) {
    const Node& node = nodes_[at];
    const Vec3f d = node.centre - x;
    const float distance2 = d.dot(d);
    const std::uint32_t under = (node.skip - at + 1) / 2;
    if (distance2 > node.reach2) {
      if (node.reach2 >= 0) add(node.dipole, d, distance2, value);
      leaf += under;
      at = node.skip;
    } else if (under > 1) {
      ++at;
    } else {
      const std::uint32_t last = std::min(cloud_.size, (leaf + 1) * kLeafPoints);
      for (std::uint32_t i = leaf * kLeafPoints; i < last; ++i) {
        const float s = sign(i);
        const float radius2 = cloud_.radius[i] * cloud_.radius[i];
        if (s == 0 || radius2 == 0) continue;
        const Vec3f e = cloud_.position[i] - x;
        // Softened: a disc seen from nearby fills half the sphere and no more.
        add(cloud_.normal[i].unpack() * (s * radius2 * 0.25F), e, e.dot(e) + radius2, value);
      }
      ++leaf;
      ++at;
    }
  }
  return value;
}

}  // namespace plumbline
