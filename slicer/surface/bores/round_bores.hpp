#pragma once
/// Detects round bores and extends their walls.

#include <span>

#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/bores/bore_surface.hpp"

namespace plumbline {

/// Extends the walls of round bores as cylinders.
///
/// From a point on a sparse wall with another wall opposite, a cylinder is fitted to the points within the width of
/// both, starting with an axis in several directions across the point's normal. Normals of sparse points are not
/// used, since they are the most likely to be wrong. The cylinder is followed both ways and fitted to more and more of the
/// wall, until it meets a face around its mouth, or something inside it. It is a bore if it has wall all around at either end
/// and few points of other walls beside it, and if some of its length was not seen; other bores need no help.
///
/// Then the points on its wall, noise included, get normals towards the axis; sparse points beside the wall become
/// noise, unless they are on the other side of a thin wall; and where it has no wall, points are added.
///
/// @param ends  those on the bores that were found are removed; the others keep their order
/// @returns the ends that are left
/// @retval ErrorCode::kCancelled
[[nodiscard]] Expected<std::span<BoreEnd>> continue_round_bores(BoreSurface& surface, std::span<BoreEnd> ends,
                                                                const StageProgress& progress = {});

}  // namespace plumbline
