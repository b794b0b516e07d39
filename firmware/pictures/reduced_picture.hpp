#pragma once
/// A picture that somebody else has drawn, such as the thumbnail of an archive, made smaller while it is decoded.

#include <cstdint>
#include <span>

#include "firmware/pictures/png.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline pictures {

inline constexpr std::uint32_t kMostPictureSide = 4096;  ///< pixels of a file of decode_reduced()

/// Draws a PNG of any colours and depth into the middle of a picture, as large as fits; a smaller one is not enlarged. Each pixel is
/// the mean of those that it shows. Where the file is transparent, what the picture shows stays.
/// @param rgb  3 bytes for each pixel of `size`, row after row from the top; also after an error some of it may be drawn
/// @retval ErrorCode::kUnsupported  a side is above kMostPictureSide, or the file is interlaced
/// @retval any error of PngRows
[[nodiscard]] Status decode_reduced(PngBytes bytes, std::span<std::uint8_t> rgb, const PngSize& size);

}  // namespace plumbline::firmware::inline pictures
