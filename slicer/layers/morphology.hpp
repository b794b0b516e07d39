#pragma once
/// Opens and closes masks, 64 pixels an operation (thesis III-4.b).

#include <cstdint>

#include "slicer/core/bit_image.hpp"

namespace plumbline::inline slicer {

/// A pixel of the result depends on pixels up to this many rows and columns away.
inline constexpr std::uint32_t kOpenCloseReach = 2;

/// A strip is 32 columns from top to bottom: half of each word. With all that it depends on it fits into 64 columns.
inline constexpr std::uint32_t kStripColumns = 32;

/// `out` = closing of the opening of `in`, both with a square of 2 x 2 pixels, in rows [first, last) of a strip and of the
/// kOpenCloseReach columns on either side of it: the pixels that those of the strip affect.
///
/// Opening keeps the pixels that lie in a white square of 2 x 2: single pixels and lines of one pixel go, nothing that is at
/// least two pixels wide in both directions does. Closing does the same for black. Outside of the image all is black.
/// @param strip  at most 2 * in.stride() - 1
/// @param out    same size, separate memory
void open_and_close_rows(ConstBitImage in, BitImage out, std::uint32_t strip, std::uint32_t first, std::uint32_t last);

}  // namespace plumbline::inline slicer
