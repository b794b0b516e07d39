#pragma once
/// The coverage picture: which parts of the surface were scanned, and which were closed.

#include "firmware/pictures/preview/preview.hpp"
#include "slicer/rrep/confidence.hpp"

namespace plumbline {

/// Draws the object from the front, the back, above and below, at one scale, coloured by the evidence for each place of the
/// surface, with a legend that gives the share of each colour. As large as the preview.
/// @param rrep     at least one layer
/// @param map      not empty
/// @param text     only its name is drawn
/// @param arena    for pictures and depths: taken from the top and released
/// @param encoder  made for pictures of at least kPreviewColumns x kPreviewRows
/// @returns the file, in the encoder's memory, valid until its next use
/// @retval ErrorCode::kOutOfMemory  the arena or lodepng found no room
[[nodiscard]] Expected<std::span<const std::byte>> encode_coverage(const RRep& rrep, const ConfidenceMap& map,
                                                                   const PreviewText& text, Arena& arena,
                                                                   PngEncoder& encoder);

}  // namespace plumbline
