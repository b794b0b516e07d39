#pragma once
/// Classes of points by the way their surface faces (thesis III-2.b, table 1), and how many points each class has.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"

namespace plumbline::inline slicer {

/// Entering, exiting or neutral, by the angle between the normal and the manufacturing direction +z. Never noise.
PointClass orientation_of(const PackedNormal& normal);

/// Number of points in each class.
struct ClassCounts {
  std::array<std::uint32_t, kPointClassCount> counts = {};

  std::uint32_t& operator[](PointClass c) { return counts[static_cast<std::size_t>(c)]; }
  std::uint32_t operator[](PointClass c) const { return counts[static_cast<std::size_t>(c)]; }
  bool operator==(const ClassCounts&) const = default;

  /// Points that are not noise.
  std::uint32_t surface() const;
  std::uint32_t all() const { return surface() + (*this)[PointClass::kNoise]; }
  /// Whether the class has at most one in a thousand of the surface's points. With entering points negligible a scan is
  /// a height field; with exiting points negligible it lies face down.
  bool is_negligible(PointClass c) const;
};

ClassCounts count_classes(std::span<const PackedNormal> normals);

}  // namespace plumbline::inline slicer
