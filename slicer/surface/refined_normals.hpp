#pragma once
/// Sharpens the scanner's normals.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline::inline slicer {

/// Where most normals of a scan come from.
enum class NormalSource : std::uint8_t {
  kScanner,  ///< the file: evidence of its own beside the points
  kPoints,   ///< estimated from the points themselves
};

/// Fits a plane to the points around each point, in the frame of its normal n, and tilts the normal towards the
/// plane's:
///
///   minimise  sum_j w_j (<d_j, n> - c - a <d_j, t> - b <d_j, s>)^2,   d_j = p_j - p_i
///   w_j = (1 - |d_j|^2 / r_i^2)^2; r_i is the radius that holds m points; t and s are perpendicular to n and each
///   other n_i := n - k (a t + b s), unit length
///
/// For a scanner's normals m = 26 and k = max(0, 1 - (v + V) / (a^2 + b^2 + T)). v is the value of a^2 + b^2 expected
/// from the noise of the points alone; V and T are the sums of v and of a^2 + b^2 over the 32 points that share a
/// search. So a tilt counts as far as noise does not explain it (a Wiener filter with means in place of expectations).
/// Normals estimated from 20 points are no evidence against more points: m = 5/3 support_points and k = 1.
///
/// A scanner computes its normals from several pixels of one range image. These are several times as far apart as the
/// points of all views together, so its normals are smooth, and rounded at edges. Points that face more than 60 degrees
/// away, and noise, don't count; where fewer than six points are left the normal stays.
///
/// A point off the plane of the others that face its way lies beside their sheet: it is on the wall below an edge, where the
/// scanner's window saw more of the face above. Its normal is not used, nor is that of a noise point, which is often noise
/// because of its normal. Both get the normal of TangentPlanes, on the side of the normals around them, if these agree. A point
/// with too few others within kSparseRadius * epsilon keeps its own, and so does one on sparse surface that would be turned over:
/// the plane is that of a thin wall's other side, which more views saw. Noise stays noise; rescue_sparse_surface() tests
/// it again.
///
/// @param cloud    in the order of `tree`, radius[] and classes set by cluster()
/// @param refined  cloud.size normals, output; their classes follow the normals
/// @retval ErrorCode::kCancelled
[[nodiscard]] Status refine_normals(const Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering,
                                    NormalSource source, std::span<PackedNormal> refined,
                                    const StageProgress& progress = {});

}  // namespace plumbline::inline slicer
