#pragma once
/// The natural width of the grid of rays (thesis III-2.c).

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline {

struct GridWidthSettings {
  std::uint32_t neighbour = 10;  ///< k_2 of the thesis
  std::uint32_t sample = 8192;   ///< points a class whose neighbours are searched, evenly spaced by index
};

/// Grid width w, mm: the length scale of the queries. The rays themselves are the pixels.
///
///   w = sqrt(pi) * min(mean d'(entering), mean d'(exiting))                                  (thesis III-2.c)
///
/// d' is the distance in the plane to the k_2-th nearest other point of the same class. A class with k_2 points or fewer is
/// left out.
/// @returns mm; 0 if both classes are left out
float grid_width(const Cloud& cloud, const KdTree2& tree, const GridWidthSettings& settings);

}  // namespace plumbline
