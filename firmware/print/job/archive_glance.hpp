#pragma once
/// A small picture of an archive that somebody else has sliced, before anything else is known of it.

#include "firmware/archive/layer_archive.hpp"
#include "firmware/pictures/job_pictures.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::firmware {

/// Draws the archive's thumbnail, or a coarse print of some of its layers, seen from the front, if it has none.
/// @param printer  whose pixels the layers are said to have, if the archive does not say how wide its panel is
/// @param arena    what it is drawn with is taken from it and not released
/// @retval any error of LayerArchive
/// @retval ErrorCode::kNoPoints     no layer that was looked at has a white pixel
/// @retval ErrorCode::kOutOfMemory  the arena has no room
[[nodiscard]] Status draw_archive_picture(LayerArchive& archive, const PrinterVolume& printer, Arena& arena,
                                          ScanPicture& picture);

}  // namespace plumbline::firmware
