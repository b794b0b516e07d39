#pragma once
/// Below which sizes what a scan shows cannot be told from what a few strays make.

#include "slicer/core/print_grid.hpp"
#include "slicer/layers/layer_features.hpp"
#include "slicer/rrep/components.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// How many times the points of a support that a scan without noise has; 1: the scan has none to speak of.
float widening(const ClusteringResult& clustering, const ClusteringSettings& settings);

/// What goes by its size alone: specks of solid and of hollow below 50 cubes of epsilon. A stray's support has some six.
/// @param clustering  epsilon in mm
ComponentLimits component_limits(const ClusteringResult& clustering, const PrintGrid& grid);

/// Small features have at most two cubes of epsilon, as many times more as noise has widened the supports, since what one
/// stray does goes farther there. They are narrow, with at most a square of epsilon in any layer and, unless there is such
/// noise, two thirds of epsilon high, or flat: of the area of a support and as high as noise makes a level surface rise and
/// fall, in layers that any part of it reaches. What touches nothing may be as large as a speck.
///
///   support = pi epsilon^2 support_points / (2 minPts)      a disc of radius epsilon has 2 minPts points (thesis III-2.b)
///   flat    = 6 noise / sqrt(support_points)                the surface is a mean over a support
///
/// @param clustering  epsilon and noise in mm, and the points of a support
/// @param settings    that it was made with
FeatureLimits feature_limits(const ClusteringResult& clustering, const ClusteringSettings& settings,
                             const PrintGrid& grid);

}  // namespace plumbline
