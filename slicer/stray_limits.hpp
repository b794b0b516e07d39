#pragma once
/// Below which sizes what a scan shows cannot be told from what a few strays make.

#include "slicer/clustering.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/layer_features.hpp"
#include "slicer/pieces.hpp"

namespace plumbline {

/// What goes by its size alone: specks of solid and of hollow below 50 cubes of epsilon. A stray's support has some six.
/// @param clustering  epsilon in mm
PieceLimits piece_limits(const ClusteringResult& clustering, const PrintGrid& grid);

/// Small features have at most two squares of epsilon in a layer and two cubes of it in all.
/// @param clustering        epsilon in mm
/// @param supports_widened  by noise, to so many times the points, 1 or more: what one stray does goes farther, so there are
///                          as many times the cubes
FeatureLimits feature_limits(const ClusteringResult& clustering, float supports_widened, const PrintGrid& grid);

}  // namespace plumbline
