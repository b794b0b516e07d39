#pragma once
/// Which way a panel shows pictures: a picture with a different number of squares in each corner, and what somebody sees of it.

#include <array>
#include <cstdint>

#include "hal/panel_layout.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Squares in each corner: clockwise from the one at the back on the left, for somebody who looks down on the panel from above; of a
/// picture clockwise from the upper left.
using CornerSquares = std::array<unsigned, 4>;

/// What the picture is sent with.
inline constexpr CornerSquares kSentCorners = {1, 2, 3, 4};

/// Side of a square and distance between squares, pixels.
std::uint32_t square_side(std::uint32_t columns, std::uint32_t rows);

/// Draws kSentCorners: rows of squares from each corner inward.
void draw_corners(BitImage picture);

/// The squares in each quarter of a picture, by their area.
CornerSquares squares_in(ConstBitImage picture);

/// Rotation and mirror with which this panel shows a mask as the print needs it: left and right swapped for somebody who looks
/// down on the panel, because the part hangs from the plate upside down.
/// @param sent  the picture that was sent, without rotation or mirror: columns, rows and packing
/// @param seen  what somebody sees of it
/// @returns columns and rows are those of the mask: swapped if the panel is turned by 90 degrees
/// @retval ErrorCode::kBadSetting  no panel shows the picture like that: the corners are not 1 2 3 4, turned or mirrored
[[nodiscard]] Expected<PanelLayout> layout_for(const PanelLayout& sent, const CornerSquares& seen);

}  // namespace plumbline::firmware
