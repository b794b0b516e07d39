#pragma once
/// The print from a ring of sides, for people who turn it.

#include "firmware/pictures/job_pictures.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures {

/// Bytes that draw_side_pictures() takes at most.
std::size_t side_pictures_bytes(const PrintGrid& grid);

/// Draws the print from kSideCount sides, 20 degrees from above, all at one scale. Side 0 is the front; each next one stands
/// 360 / kSideCount degrees further to the right, seen by somebody in front of the print.
/// @param arena     up to side_pictures_bytes() are taken from its top and released
/// @param pictures  without an object, or after an error, there is none of them
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Status draw_side_pictures(const RRep& rrep, const Supports& supports, Arena& arena,
                                        SidePictures& pictures);

}  // namespace plumbline::firmware::inline pictures
