#pragma once
/// How far a part's surface lies from the true one.

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "hal/sim/part/dose_field.hpp"
#include "slicer/core/numbers/oriented_point.hpp"

namespace plumbline::inline hal::inline sim {

/// Farther from the true surface the part's is not sought, mm.
inline constexpr double kFarthestDeviation = 0.6;

/// Where the cured part ends on the line through a true point along its normal: mm outwards from the point, to 0.1 um. Outwards to the
/// first place that is not cured; inwards, below 0, to the first that is.
/// @param truth  mm from the corner of pixel (0, 0) and from the plate
/// @returns one for each point; infinity: all is cured up to kFarthestDeviation outside, -infinity: nothing as far inside
std::vector<float> deviations_mm(const CuredPart& part, const DoseModel& model, std::span<const OrientedPoint> truth);

/// Figures of deviations, um; NaN where no point is of the kind.
struct DeviationFigures {
  std::uint64_t points = 0;
  std::uint64_t missing = 0;  ///< without a surface in reach; the figures below leave them out
  std::uint64_t sealed = 0;   ///< of these, cured all along: gaps that have closed
  double rms = kNone;         ///< root of the mean square of all
  double down_mean = kNone;   ///< where the surface faces down, at most 60 degrees off
  double down_rms = kNone;    ///< the same, about its mean
  double wall_mean = kNone;   ///< steeper than 60 degrees
  double wall_rms = kNone;    ///< the same, about its mean
  double top_rms = kNone;     ///< faces up, at most 30 degrees off: about 0

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
};
/// @param deviations_mm  of the same points
DeviationFigures figures_of(std::span<const OrientedPoint> truth, std::span<const float> deviations_mm);

}  // namespace plumbline::inline hal::inline sim
