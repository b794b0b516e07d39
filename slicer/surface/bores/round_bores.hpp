#pragma once
/// Round bores: the part of continue_bore_walls() that knows what it continues.

#include <span>

#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/surface/bores/bore_surface.hpp"

namespace plumbline {

/// Continues the walls of round bores as cylinders.
///
/// From a point of a wall that was hardly seen and has another opposite, a cylinder is fitted to what lies within the width of
/// both, starting with an axis in each of twelve directions across its normal. Of points that were hardly seen the normals are
/// not asked, since they are the first to be wrong. The cylinder is followed both ways, in steps of half its radius, and fitted
/// anew to more and more of the wall, until it comes to a face round its mouth, to something that stands in it, or is eight
/// times as long as wide. It is a bore if
///   - at either end there is wall in seven of eight directions,
///   - it has three points or more of its wall for each of another wall beside it,
///   - between the ends more than two epsilon of its length have wall in fewer than five directions: others need no help.
/// Then the points on it face its axis, noise among them too; what was hardly seen and lies beside its wall is noise, unless it
/// is the other side of a thin one; and it gets points, half an epsilon apart, where it has no wall.
///
/// @param ends  those of such bores are taken out, the others keep their order
/// @returns those left
/// @retval ErrorCode::kCancelled
[[nodiscard]] Expected<std::span<BoreEnd>> continue_round_bores(BoreSurface& surface, std::span<BoreEnd> ends,
                                                                const StageProgress& progress = {});

}  // namespace plumbline
