#pragma once
/// Whether neighbouring points lie on one sheet, and face the same side of it.

#include <cstdint>
#include <limits>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline::inline slicer {

/// Height of point i over another, the mean of that over the other's tangent plane and of the other's depth below its own, in the unit of
/// the cloud. On a curved surface the two halves cancel; for a point off the surface they add up.
///
///   height = 1/2 <n_i + n_j, p_i - p_j>
float pair_height(const Cloud& cloud, std::uint32_t i, std::uint32_t j);

/// Whether point i and a neighbour could lie on one sheet, by their positions and normals alone.
bool agree(const Cloud& cloud, std::uint32_t i, const Neighbour& other);

/// Whether a point with a normal agrees with others that face its way. Of outliers with normals at random 1 in 100 does.
/// @param reach  in the unit of the cloud: farther ones don't count
bool agrees_with_neighbours(const Cloud& cloud, const KdTree3& tree, std::uint32_t i,
                            float reach = std::numeric_limits<float>::infinity());

/// Where most of a point's nearest neighbours lie, if most of them face the opposite way.
enum class Opposed : std::uint8_t {
  kNowhere,  ///< most do not face the opposite way, or lie in both places
  kBeside,   ///< within 30 degrees of its plane: the point itself faces the wrong way
  kBehind,   ///< above or below its plane: they are the other side of a thin wall, which more views saw
};
Opposed opposed(const Cloud& cloud, const KdTree3& tree, std::uint32_t i);

}  // namespace plumbline::inline slicer
