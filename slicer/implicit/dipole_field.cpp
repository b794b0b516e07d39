#include "slicer/implicit/dipole_field.hpp"

#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// Adds <dipole, e> / |e|^3 and its gradient in x, with e = p - x and distance2 = |e|^2.
void add(const Vec3f& dipole, const Vec3f& e, float distance2, DipoleField::Value& value) {
  const float inverse2 = 1 / distance2;
  const float inverse3 = inverse2 * std::sqrt(inverse2);
  const float along = dipole.dot(e);
  value.winding += along * inverse3;
  value.gradient += (e * (3 * along * inverse2) - dipole) * inverse3;
}

}  // namespace

void DipoleField::build(Sign sign) {
  tree_.build([&](std::uint32_t i, DipoleSum& sum) {
    const float s = sign(i);
    if (s == 0) return;
    const float area4pi = cloud_.radius[i] * cloud_.radius[i] * 0.25F;  // divided by 4 pi, like the dipoles
    sum.add(cloud_.position[i], area4pi, cloud_.normal[i].unpack() * (s * area4pi));
  });
}

DipoleField::Value DipoleField::operator()(const Vec3f& x, Sign sign, float share) const {
  Value value;
  tree_.walk(
      x,
      [&](const Node& node) {
        const Vec3f e = node.centre - x;
        add(node.dipole, e, e.dot(e), value);
      },
      [&](std::uint32_t i) {
        const float s = sign(i);
        const float radius2 = cloud_.radius[i] * cloud_.radius[i];
        if (s == 0 || radius2 == 0) return;
        const Vec3f e = cloud_.position[i] - x;
        // Softened: a disc seen from nearby fills at most half the sphere, where a dipole would grow without bound.
        add(cloud_.normal[i].unpack() * (s * radius2 * 0.25F), e, e.dot(e) + radius2, value);
      },
      share);
  return value;
}

}  // namespace plumbline::inline slicer
