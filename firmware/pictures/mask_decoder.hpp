#pragma once
/// Decodes a mask from a PNG row by row.

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/pictures/png.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::firmware::inline pictures {

/// Where the pixels of a file lie on the plate.
struct MaskTurn {
  bool mirror_x = false;  ///< the file's columns run against theirs
  bool mirror_y = false;  ///< the file's rows run against theirs
  bool swaps = false;     ///< then the file's columns are the plate's rows

  bool operator==(const MaskTurn&) const = default;
  /// The same, then turned by 90 degrees as seen from above the plate, x towards y.
  MaskTurn quarter() const {
    return swaps ? MaskTurn{!mirror_x, mirror_y, false} : MaskTurn{mirror_x, !mirror_y, true};
  }
};

/// How much of the masks of a print is grey. On a panel without grey these pixels become white or black.
struct GreyShare {
  std::uint64_t lit = 0;   ///< pixels above black
  std::uint64_t grey = 0;  ///< of them neither black nor white
  std::uint64_t lost = 0;  ///< of them below kLeastCuringLevel: they become black

  /// Of the lit area, 0 to 1.
  double share() const { return lit > 0 ? static_cast<double>(grey) / static_cast<double>(lit) : 0; }
  bool operator==(const GreyShare&) const = default;
};

/// Decodes a PNG of any kind. What is transparent shows black. A pixel is white from kLeastCuringLevel of 255 on, half of the full level as
/// in UVtools; a colour has the level of its luma (ITU-R BT.601).
/// @param most_bytes  of the file; what is longer is refused when so many have come
/// @param out         overwritten, also after an error
/// @param grey        may be null; the pixels of the file are added to it
/// @param greys       may be null; becomes the grey pixels of `out`, in order
/// @retval ErrorCode::kMalformed    no PNG, damaged, cut off, too long, or not of the size of `out`
/// @retval ErrorCode::kOutOfMemory  the heap has no 200 kB; 400 kB with colours
/// @retval any error of `bytes`
[[nodiscard]] Status decode_turned_mask(PngBytes bytes, std::uint64_t most_bytes, const MaskTurn& turn, BitImage out,
                                        GreyShare* grey = nullptr, GreyRuns* greys = nullptr);

/// The same of a file in memory, as it lies.
[[nodiscard]] Status decode_mask(std::span<const std::byte> file, BitImage out);

/// Bytes that no PNG of a mask exceeds: two bytes a channel, four channels, without any compression.
std::uint64_t most_mask_bytes(std::uint32_t columns, std::uint32_t rows);

}  // namespace plumbline::firmware::inline pictures
