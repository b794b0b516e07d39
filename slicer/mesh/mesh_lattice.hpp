#pragma once
/// Whole numbers for the coordinates of a placed mesh, so that every decision about its rays is exact.

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>

#include "slicer/core/numbers/vec.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// In steps of the lattice, from the origin of the print.
struct LatticePoint {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const LatticePoint&) const = default;  // NOLINT(modernize-use-nullptr): compares with literal 0
};
using LatticeTriangle = std::array<LatticePoint, 3>;

// Steps in a pixel: 0.8 nm for pixels of 50 um. 2^14 pixels have 2^30 steps, so that the products of two differences, of which an
// edge function is the difference, stay below 2^61 and it below 2^62.
inline constexpr int kPixelBits = 16;
inline constexpr std::int64_t kPixelSteps = std::int64_t{1} << kPixelBits;
// Steps in a layer: 6 nm for layers of 50 um. 2^16 layers have 2^29 steps.
inline constexpr int kLayerBits = 13;
inline constexpr std::int64_t kLayerSteps = std::int64_t{1} << kLayerBits;

static_assert(std::int64_t{PrintGrid::kMaxSide} * kPixelSteps <= std::int64_t{1} << 30);
static_assert((std::int64_t{PrintGrid::kMaxLayers} + 1) * kLayerSteps <= std::int64_t{1} << 29);

/// From scan coordinates to those of the print, as in Placement: scale * rotation * p + shift.
struct MeshTransform {
  Mat3d rotation = Mat3d::Identity();
  double scale = 1;
  Vec3d shift = Vec3d::Zero();

  Vec3d operator()(const Vec3d& p) const { return Vec3d(rotation * p) * scale + shift; }
};

class OutlineShift;

/// Rounds positions of the print to the lattice.
class MeshLattice {
 public:
  /// @param shift  by which corners are moved; null: they stay
  MeshLattice(const PrintGrid& grid, const MeshTransform& transform, const OutlineShift* shift = nullptr)
      : transform_(transform), shift_(shift) {
    steps_ = {static_cast<double>(kPixelSteps) / static_cast<double>(grid.pitch_x_mm),
              static_cast<double>(kPixelSteps) / static_cast<double>(grid.pitch_y_mm),
              static_cast<double>(kLayerSteps) / static_cast<double>(grid.layer_height_mm)};
    last_ = {static_cast<double>(grid.columns * kPixelSteps), static_cast<double>(grid.rows * kPixelSteps),
             static_cast<double>(grid.layers * kLayerSteps)};
  }

  /// @param p  scan coordinates. What place() has let through is in the grid but for rounding, and so is the result.
  LatticePoint operator()(const Vec3d& p) const {
    const Vec3d print = transform_(p);
    const LatticePoint rounded{round(print[0], 0), round(print[1], 1), round(print[2], 2)};
    return shift_ == nullptr ? rounded : moved(rounded);
  }
  /// The same before it is rounded, and where it may lie outside of the grid.
  Vec3d steps_of(const Vec3d& p) const {
    const Vec3d print = transform_(p);
    return {print[0] * steps_[0], print[1] * steps_[1], print[2] * steps_[2]};
  }
  const Vec3d& last() const { return last_; }  ///< steps to the far corner of the grid
  /// mm in a step, on each axis
  Vec3d step() const { return {1 / steps_[0], 1 / steps_[1], 1 / steps_[2]}; }

 private:
  std::int32_t round(double mm, int axis) const {
    return static_cast<std::int32_t>(std::clamp(std::floor(mm * steps_[axis] + 0.5), 0.0, last_[axis]));
  }

  LatticePoint moved(const LatticePoint& p) const;  // outline_shift.cpp

  MeshTransform transform_;
  const OutlineShift* shift_;
  Vec3d steps_;  ///< in a mm
  Vec3d last_;   ///< steps to the far corner of the grid
};

}  // namespace plumbline::inline slicer
