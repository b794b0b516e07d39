#pragma once
/// Decodes a mask from a PNG row by row.

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/pictures/png_rows.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Where the pixels of a file lie on the plate.
struct MaskTurn {
  bool mirror_x = false;  ///< the file's columns run against theirs
  bool mirror_y = false;  ///< the file's rows run against theirs
  bool swaps = false;     ///< then the file's columns are the plate's rows

  bool operator==(const MaskTurn&) const = default;
};

/// Decodes a PNG of any kind. What is transparent shows black. A pixel is white from half of the full level on, as in UVtools; a colour has
/// the level of its luma (ITU-R BT.601).
/// @param most_bytes  of the file; what is longer is refused when so many have come
/// @param out         overwritten, also after an error
/// @retval ErrorCode::kMalformed    no PNG, damaged, cut off, too long, or not of the size of `out`
/// @retval ErrorCode::kOutOfMemory  the heap has no 200 kB; 400 kB with colours
/// @retval any error of `bytes`
[[nodiscard]] Status decode_turned_mask(PngBytes bytes, std::uint64_t most_bytes, const MaskTurn& turn, BitImage out);

/// The same of a file in memory, as it lies.
[[nodiscard]] Status decode_mask(std::span<const std::byte> file, BitImage out);

/// Bytes that no PNG of a mask exceeds: two bytes a channel, four channels, without any compression.
std::uint64_t most_mask_bytes(std::uint32_t columns, std::uint32_t rows);

}  // namespace plumbline
