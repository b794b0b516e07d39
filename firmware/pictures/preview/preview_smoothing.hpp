#pragma once
/// Smooths a depth map.

#include <span>

#include "firmware/pictures/preview/preview_shading.hpp"

namespace plumbline::firmware::inline pictures {

/// A voxel as a view sees it, in samples of the map.
struct VoxelSize {
  float across = 1;  ///< the larger of its sides in the picture's plane
  float deep = 1;    ///< along the view
};

/// Smooths the steps of pixels and layers, but not across edges of the object.
/// @param map      at most kMostSamples columns
/// @param scratch  as many as map.depth
void smooth_depth(const DepthMap& map, std::span<float> scratch, const VoxelSize& voxel);

}  // namespace plumbline::firmware::inline pictures
