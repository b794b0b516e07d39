#pragma once
/// The natural width of the grid of rays (thesis III-2.c).

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline::inline slicer {

/// Grid width w, mm: the length scale of the queries. The rays themselves are the pixels.
///
///   w = sqrt(pi) * min(mean d'(entering), mean d'(exiting))                                  (thesis III-2.c)
///
/// d' is the distance in the plane to the tenth nearest other point of the same class, of which some 8192 are searched. A class of
/// ten points or fewer is left out.
/// @returns mm; 0 if both classes are left out
float grid_width(const Cloud& cloud, const KdTree2& tree);

}  // namespace plumbline::inline slicer
