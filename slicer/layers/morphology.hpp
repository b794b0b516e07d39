#pragma once
/// Opening and closing of masks, 64 pixels an operation (thesis III-4.b).

#include <cstdint>

#include "slicer/core/bit_image.hpp"

namespace plumbline {

/// How far a pixel of the result looks: rows, and columns, on every side.
inline constexpr std::uint32_t kOpenCloseReach = 2;

/// `out` = closing of the opening of `in`, both with a square of 2 x 2 pixels, in words [first, last) of one row.
///
/// Opening keeps exactly the pixels that belong to some white square of 2 x 2: single pixels and lines of one pixel go,
/// and nothing wider than two pixels in every direction does. Closing does the same for the black. Outside of the image
/// all is black.
/// @param out  same size, other memory
void open_and_close_run(ConstBitImage in, BitImage out, std::uint32_t row, std::uint32_t first, std::uint32_t last);

/// The same for the whole image.
void open_and_close(ConstBitImage in, BitImage out);

}  // namespace plumbline
