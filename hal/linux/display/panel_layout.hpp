#pragma once
/// From a mask to the pixels that go over the panel's cable. Pure functions.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// Where each pixel of a mask is on the cable: the mask is turned, then turned over, then packed.
struct PanelLayout {
  enum class Mirror : std::uint8_t {
    kNone,
    kX,  ///< left and right change places
    kY,  ///< top and bottom do
  };

  std::uint32_t columns = 0;       ///< of the mask, 1 to 16384
  std::uint32_t rows = 0;          ///< of the mask, 1 to 16384
  std::uint32_t rotation_deg = 0;  ///< 0, 90, 180, 270, counter-clockwise as one looks at row 0 at the top
  Mirror mirror = Mirror::kNone;
  bool rgb = false;  ///< three neighbours of a row are red, green and blue of one pixel

  /// Pixels of the mode that the panel needs.
  std::uint32_t mode_width() const { return picture_width() / (rgb ? 3 : 1); }
  std::uint32_t mode_height() const { return sideways() ? columns : rows; }

  /// @retval ErrorCode::kBadSetting  packing by three with a turned width that is no multiple of 3
  [[nodiscard]] Status check() const;

 private:
  bool sideways() const { return rotation_deg == 90 || rotation_deg == 270; }
  std::uint32_t picture_width() const { return sideways() ? rows : columns; }
};

/// Writes a mask as XRGB8888, little endian as memory is: a pixel that lets light through is 255 in its colour, or in all three.
/// Every byte of the rows is written once, in order, and none is read: the memory is the display's.
/// @param layout  checked
/// @param mask    layout.columns x layout.rows
/// @param pixels  layout.mode_height() rows of `pitch` words
/// @param pitch   words a row, layout.mode_width() or more
void pack_pixels(const PanelLayout& layout, ConstBitImage mask, std::span<std::uint32_t> pixels, std::size_t pitch);

}  // namespace plumbline
