#pragma once
/// How far a part's surface lies from the true one.

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

}  // namespace plumbline::inline hal::inline sim
