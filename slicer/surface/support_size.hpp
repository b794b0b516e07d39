#pragma once
/// How wide supports should be, asked of the scan itself.

#include <cstddef>

#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// Bytes of arena that widen_supports() takes.
std::size_t support_size_bytes();

/// Widens the supports of a noisy scan to as many points as give the surface the least risk: noise that is left over and
/// detail that is lost, together.
///
/// The cloud is taken as two scans, A and B, of every other point each, and the distance F to the surface (mls.hpp) is
/// asked of both at points of the surface, with supports of k points. Both show the same detail with noise of their own, so
///
///   variance(k) = E[(F_A - F_B)^2] / 4                     the noise that the surface of all points is left with
///   bias(k)^2   = E[(F_A - F_A,least) (F_B - F_B,least)]   the detail lost against supports of least_support points
///
/// with means over places of the surface. risk(k) is the mean of sqrt(variance + bias^2) over the places, and the
/// narrowest supports within 2 % of the least risk are taken. None narrower than they were: by as much as views disagree
/// the two halves agree, so that counts as detail, though it is none.
///
/// A scan without noise, or too small to tell, keeps its supports.
/// @param cloud       in the order of `tree`; radius[] and classes set by cluster(), noise is not looked at. radius[] grows
/// @param clustering  support_points grows with it
/// @param arena       support_size_bytes() from the top, given back
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Status widen_supports(Cloud& cloud, const KdTree3& tree, const ClusteringSettings& settings,
                                    ClusteringResult& clustering, Arena& arena, const StageProgress& progress = {});

}  // namespace plumbline
