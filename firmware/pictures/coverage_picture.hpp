#pragma once
/// A picture of what the print rests on: the scan, or what was put where the scan had nothing.

#include "firmware/pictures/preview.hpp"
#include "slicer/rrep/confidence.hpp"

namespace plumbline {

/// Draws the object from the front, the back, above and below, in one scale, each place in the colour of what it rests on,
/// and a legend with the shares of the surface. As large as the preview.
/// @param rrep     at least one layer
/// @param map      not empty
/// @param text     its captions are not drawn: the legend has their place
/// @param arena    for pictures and depths, from the top, given back
/// @param encoder  made for pictures of at least kPreviewColumns x kPreviewRows
/// @returns the file, in the encoder's memory, valid until its next use
/// @retval ErrorCode::kOutOfMemory  the arena or lodepng found no room
[[nodiscard]] Expected<std::span<const std::byte>> encode_coverage(const RRep& rrep, const ConfidenceMap& map,
                                                                   const PreviewText& text, Arena& arena,
                                                                   PngEncoder& encoder);

}  // namespace plumbline
