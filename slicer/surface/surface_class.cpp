#include "slicer/surface/surface_class.hpp"

namespace plumbline::inline slicer {
namespace {

/// A scan of one side has some entering points at its rim and where noise tilts normals: ucicouple_front has at most a
/// thousandth of its points facing down when it lies on its back.
constexpr std::uint64_t kNegligible = 1000;

}  // namespace

PointClass orientation_of(const PackedNormal& normal) {
  const float z = static_cast<float>(normal.z) / PackedNormal::kScale;
  if (z > kNeutralSine) return PointClass::kExiting;
  if (z < -kNeutralSine) return PointClass::kEntering;
  return PointClass::kNeutral;
}

std::uint32_t ClassCounts::surface() const {
  return (*this)[PointClass::kEntering] + (*this)[PointClass::kExiting] + (*this)[PointClass::kNeutral];
}

bool ClassCounts::is_negligible(PointClass c) const { return kNegligible * (*this)[c] <= surface(); }

ClassCounts count_classes(std::span<const PackedNormal> normals) {
  ClassCounts points;
  for (const PackedNormal& normal : normals) ++points[normal.point_class];
  return points;
}

}  // namespace plumbline::inline slicer
