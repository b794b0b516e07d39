#pragma once
/// A picture of a scan in several orientations, drawn from its points.

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "firmware/pictures/job_pictures.hpp"
#include "firmware/pictures/png.hpp"
#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline pictures {

/// One orientation and the lines of text below it. ASCII; lines that are too long are cut.
struct OrientationView {
  std::array<double, 2> degrees = {};  ///< about x, then about y
  std::array<std::string_view, 6> lines;
};

/// Draws up to four views side by side, each from the front (along +y) and at one scale. What needs supports there is drawn in
/// another colour.
/// @param cloud    with normals
/// @param encoder  made for pictures of at least kPreviewColumns x kPreviewRows
/// @returns the file, in the encoder's memory, valid until its next use
/// @retval ErrorCode::kOutOfMemory  the arena has no room
[[nodiscard]] Expected<std::span<const std::byte>> encode_orientations(const Cloud& cloud, std::string_view name,
                                                                       std::span<const OrientationView> views,
                                                                       Arena& arena, PictureEncoder& encoder);

/// Draws the scan in small, as it lies and in each of the best orientations, all at one scale and as above but without texts.
/// @param degrees  about x, then about y; of as many as there are pictures
/// @retval ErrorCode::kOutOfMemory  the arena has no room; there are no pictures then
[[nodiscard]] Status draw_proposal_pictures(const Cloud& cloud, std::span<const std::array<double, 2>> degrees,
                                            Arena& arena, ProposalPictures& pictures);

/// Draws a scan or a mesh from the one of eight sides that shows most of its outer surface, seen from 20 degrees above.
/// @param cloud  not empty; normals need not be known
/// @retval ErrorCode::kOutOfMemory  the arena has no room; there is no picture then
[[nodiscard]] Status draw_scan_picture(const Cloud& cloud, Arena& arena, ScanPicture& picture);

}  // namespace plumbline::firmware::inline pictures
