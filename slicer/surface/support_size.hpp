#pragma once
/// Chooses the support radius of a noisy scan by cross-validation.

#include <cstddef>

#include "slicer/surface/clustering.hpp"

namespace plumbline {

/// Arena bytes that widen_supports() takes.
std::size_t support_size_bytes(std::uint32_t threads);

/// Widens the supports of a noisy scan to the number of points with the least risk: remaining noise and lost detail
/// together.
///
/// The cloud is split into two scans A and B of every other point each. The distance F to the surface (mls.hpp) is
/// evaluated in both at points of the surface, with supports of k points. Both show the same detail with independent
/// noise, so
///
///   variance(k) = E[(F_A - F_B)^2] / 4                     noise left on the surface of all points
///   bias(k)^2   = E[(F_A - F_A,least) (F_B - F_B,least)]   detail lost against supports of min_support points
///
/// with means over the samples of a place. risk(k) is the mean of sqrt(variance + bias^2) over the places; the
/// narrowest supports within 2 % of the least risk are taken. Supports never get narrower: an offset between two views
/// is the same in both halves, so it would count as detail.
///
/// A scan without noise, or with too few points to measure, keeps its supports.
/// @param cloud  in the order of `tree`; radius[] and classes set by cluster(), noise is not used. Its supports grow
/// @param arena  support_size_bytes() from the top, released on return
/// @retval ErrorCode::kOutOfMemory, kCancelled
[[nodiscard]] Status widen_supports(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                    const StageProgress& progress = {});

}  // namespace plumbline
