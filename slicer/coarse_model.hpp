#pragma once
/// A coarse model of a figure, from patches of its surface: solid enough to find supports on, in any way up.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/orientation/surface_samples.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// The winding number on a lattice round the figure, in the unit of the samples. It is solid where the number is above 1/2.
struct CoarseModel {
  Mat3d turn = Mat3d::Identity();  ///< of the figure as it came
  Vec3f low;                       ///< of the lattice
  float step = 1;
  std::array<std::uint32_t, 3> sides{};  ///< places along each axis
  std::span<float> winding;

  std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{z} * sides[1] + y) * sides[0] + x;
  }
  /// Interpolated between the eight places around; 0 outside the lattice.
  float at(const Vec3f& p) const;
  /// Direction in which the number falls. Not of unit length; zero where it is constant.
  Vec3f outwards(const Vec3f& p) const;
};

/// The model of a figure that is printed turned so: a hole in its underside is closed flat on the plate, others are closed round.
/// @param arena  keeps the model at its top
/// @retval ErrorCode::kOutOfMemory
/// @retval ErrorCode::kCancelled  progress said so
[[nodiscard]] Expected<CoarseModel> build_coarse_model(const SurfaceSamples& samples, const Mat3d& turn, Arena& arena,
                                                       const StageProgress& progress);

/// The voxels of a print of the model: 128 along its longest side, as high as they are wide.
struct CoarseVoxels {
  Mat3d rotation;  ///< model to print
  double unit_mm;  ///< mm of the print in the model's unit
  Vec3d low_mm;    ///< of the grid, in print coordinates
  PrintGrid grid;

  /// @param mm  from the grid's corner
  /// @returns the place in the model
  Vec3f from_print(const Vec3d& mm) const { return (rotation.transpose() * (mm + low_mm) / unit_mm).cast<float>(); }
};

/// @param degrees    about x, then y, of the figure as it came
/// @param beside_mm  room round the object
CoarseVoxels voxels_of(const CoarseModel& model, const std::array<double, 2>& degrees, double unit_mm,
                       double beside_mm);

/// @returns at the bottom of the arena
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<RRep> rrep_of(const CoarseModel& model, const CoarseVoxels& voxels, Arena& arena);

}  // namespace plumbline::inline slicer
