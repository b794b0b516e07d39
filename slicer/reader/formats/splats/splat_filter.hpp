#pragma once
/// Which Gaussian splats are the object's surface.

#include <array>
#include <cstdint>

#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {

/// Reads rows of splats (Kerbl et al., 3D Gaussian Splatting, 2023) with the values that files store: the logit of the
/// opacity, the logarithms of three radii, and a quaternion w, x, y, z that turns their axes.
///
/// Training leaves splats in the air that colour a view and are no surface. So a splat is left out if its opacity is below
/// 0.3, or if its largest radius is more than 10 times that of the median splat, which needs a survey of all of them first.
///
/// Splats of two dimensions (Huang et al., 2D Gaussian Splatting, 2024) have no third radius: theirs is 0.
///
/// A splat that is flat, its shortest radius below half of the next one, has a normal along the shortest axis. Its side is
/// not known, and training leaves many turned anyhow: estimate_normals() keeps those that agree with their neighbours.
class SplatFilter final : public PointFilter {
 public:
  static constexpr double kFaintest = -0.84729786038720345;   ///< ln(0.3 / 0.7): the logit of 0.3
  static constexpr double kLargest = 2.30258509299404568402;  ///< ln 10
  static constexpr double kFlat = 0.69314718055994530942;     ///< ln 2

  /// @param has_third  the rows have a third radius
  explicit SplatFilter(bool has_third = true) : has_third_(has_third) {}

  /// In the survey, counts the row and says kIgnore. After it, makes it a point with a normal.
  Verdict look(SlotValues& row) override;
  /// Only counts the radius of a splat.
  /// @param opacity  logit
  /// @param longest  logarithm of the largest radius
  void survey(double opacity, double longest);
  void end_survey();

 private:
  /// Classes of the logarithm, 1/8 wide: radii of 1e-14 to 1e14.
  static constexpr double kLow = -32;
  static constexpr double kStep = 0.125;
  static constexpr std::size_t kClasses = 512;

  bool has_third_;
  bool surveying_ = true;
  double most_ = 0;  ///< logarithm of the largest radius that is kept
  std::array<std::uint64_t, kClasses> count_ = {};
};

}  // namespace plumbline::inline slicer
