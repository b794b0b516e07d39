#pragma once
/// Joins neighbouring points, so that rays and winding numbers have fewer to weigh.

#include <cstdint>
#include <limits>

#include "slicer/cloud/cloud.hpp"

namespace plumbline::inline slicer {

/// Joins points that are much closer to each other than their support radii and face the same way. A joined point weighs as
/// much as its points together (PackedNormal::weight), has their mean normal and support, and lies on the surface through them:
///
///   p = mean p_i + 1/2 n mean <n_i, p_i - mean p_i>
///
/// On a curved surface the mean of points lies inside of it, by half of what the last term measures.
///
/// @param cloud  in the order of its 3D tree, so that neighbours follow each other. It shrinks; its order is kept. Weights are
///               set anew: 1 for a point that is joined with no other
/// @param most   points that there is room for. Where more would be left, points farther from each other are joined, up to one
///               support radius
void join_points(Cloud& cloud, std::uint32_t most = std::numeric_limits<std::uint32_t>::max());

}  // namespace plumbline::inline slicer
