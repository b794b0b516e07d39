#pragma once
/// Sizes below which a part of the object looks the same as what a few outliers make.

#include "slicer/core/numbers/length.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/layers/layer_features.hpp"
#include "slicer/rrep/components.hpp"

namespace plumbline::inline slicer {

/// Points within a support radius, relative to a scan without noise. 1 if the scan has little noise.
/// @param support_points  Cloud::support_points
float widening(float support_points);

/// Limits of components: solids and cavities below 50 epsilon^3 go. A single outlier makes about 6 epsilon^3.
ComponentLimits component_limits(PrintLength epsilon, const PrintGrid& grid);

/// Limits of small features. They have at most 2 epsilon^3, times widening(), since an outlier reaches farther with a wider
/// support radius. They are narrow or flat:
///   narrow  at most epsilon^2 in any layer and, without noise, at most 2/3 epsilon high
///   flat    at most the area of a support radius, and as high as noise makes a level surface rise and fall
/// A feature that touches nothing may be as large as a small component.
///
///   area of a support radius = pi epsilon^2 support_points / (2 minPts)      a disc of radius epsilon has 2 minPts points
///                                                                            (thesis III-2.b)
///   height of a flat feature = 6 noise / sqrt(support_points)                the surface is a mean over the support radius
///
/// @param support_points  Cloud::support_points
/// @param noise           ClusteringResult::noise on the print
FeatureLimits feature_limits(float support_points, PrintLength epsilon, PrintLength noise, const PrintGrid& grid);

}  // namespace plumbline::inline slicer
