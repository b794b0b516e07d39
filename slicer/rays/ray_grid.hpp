#pragma once
/// The grid of rays: its natural width, and which rays can meet the object (thesis III-2.c, III-4.a).

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline {

struct RayGridSettings {
  std::uint32_t neighbour = 10;       ///< k_2 of the thesis
  std::uint32_t width_sample = 8192;  ///< points a class whose neighbours are searched, evenly spaced by index
};

/// Grid width w, mm: the length scale of the queries. The rays themselves are the pixels.
///
///   w = sqrt(pi) * min(mean d'(entering), mean d'(exiting))                                  (thesis III-2.c)
///
/// d' is the distance in the plane to the k_2-th nearest other point of the same class. A class with k_2 points or fewer is
/// left out.
/// @returns mm; 0 if both classes are left out
float grid_width(const Cloud& cloud, const KdTree2& tree, const RayGridSettings& settings);

/// Marks the interested rays: passing rays, which have a point of the cloud within sqrt(2) w in the plane, and all rays that
/// they enclose.
/// @param interested  out, grid.columns x grid.rows
/// @retval ErrorCode::kOutOfMemory  no room for another image of that size
[[nodiscard]] Status find_interested_rays(const Cloud& cloud, const PrintGrid& grid, float width, BitImage interested,
                                          Arena& arena);

}  // namespace plumbline
