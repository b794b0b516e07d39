#pragma once
/// Normals made sharper than the scanner's.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// Whose most of the normals are that are refined.
enum class NormalSource : std::uint8_t {
  kScanner,  ///< its own: they tell what the points do not
  kPoints,   ///< estimated from the points themselves
};

/// Fits a plane to the points round each point, in the frame of its normal n, and tilts the normal to that of the plane:
///
///   minimise  sum_j w_j (<d_j, n> - c - a <d_j, t> - b <d_j, s>)^2,   d_j = p_j - p_i
///   w_j = (1 - |d_j|^2 / r_i^2)^2, r_i the radius that holds m points; t, s: across n, at right angles
///   n_i := n - k (a t + b s), unit length
///
/// For a scanner's normals m = 26 and k = max(0, 1 - (v + V) / (a^2 + b^2 + T)). v is what a^2 + b^2 comes to by the noise of
/// the points alone, V and T are the sums of both over the 32 points that share a search, so that tilts count as far as noise
/// does not explain them there (Wiener's filter, of means instead of expectations).
/// Normals that were estimated from 20 points are no evidence against more points: m = 5/3 support_points, k = 1.
///
/// A scanner takes its normals from its own range image, several pixels wide, which are several times as far apart as the
/// points of all views together: they are smooth, and round what is sharp. Points that face more than 60 degrees away, and
/// noise, are not counted; where that leaves fewer than six the normal stays.
///
/// A point that lies more than a tenth of epsilon, and than the noise, off the plane of the others that face its way is
/// beside their sheet, not on it: on the wall below an edge, where the scanner's window saw more of what is above. Its
/// normal is not believed, nor that of noise, which is often why it is noise. Such a point gets that of TangentPlanes, on the
/// side that the normals round it are on (their mean inner product at least 0.2). One with fewer than six points within
/// settings.thin_reach * epsilon keeps its own. Noise stays noise: rescue_thin_surface() asks again.
///
/// @param cloud    in the order of `tree`, radius[] and classes set by cluster()
/// @param refined  cloud.size of them, out; the classes follow the normals
/// @retval ErrorCode::kCancelled
[[nodiscard]] Status refine_normals(const Cloud& cloud, const KdTree3& tree, const ClusteringSettings& settings,
                                    const ClusteringResult& clustering, NormalSource source,
                                    std::span<PackedNormal> refined, const StageProgress& progress = {});

}  // namespace plumbline
