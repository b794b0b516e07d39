#pragma once
/// Part of a mask, as finely as somebody wants to look at it.

#include <cstdint>
#include <span>

#include "firmware/pictures/job_pictures.hpp"
#include "firmware/pictures/mask_squares.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::firmware::inline pictures {

struct MaskWindow {
  std::uint32_t column = 0, row = 0;  ///< its first pixel
  std::uint32_t step = 0;  ///< pixels along a side of a pixel of the picture; 0: as few as show all from there on
};

/// Red: how much light gets through, green: how much of that only supports need, blue: nothing.
using MaskPicture = FixedPicture<3, MaskSquares::kMost, MaskSquares::kMost>;

/// Draws as much of a mask, from the window's first pixel on, as a picture has room for. Each pixel of the picture is the mean of a square of the
/// mask's; whatever lies beyond the mask is left out.
/// @param greys    of the mask. Exact where a pixel of the picture is one of the mask, else to a few levels
/// @param section  of the object in this layer; empty: there are no supports, or nobody knows
/// @param picture  of 0 columns if the window lies beyond the mask
void draw_mask_window(ConstBitImage mask, std::span<const GreyRun> greys, ConstBitImage section,
                      const MaskWindow& window, MaskPicture& picture);

}  // namespace plumbline::firmware::inline pictures
