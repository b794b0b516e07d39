#pragma once
/// How a panel expects the pixels of a mask.

#include <array>
#include <cmath>
#include <cstdint>

#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

/// How much light a panel lets through for the values that it is sent.
struct GreyScale {
  std::uint32_t levels = 2;  ///< that it tells apart, 2 to 256, evenly spaced from 0 to 255. 2: black and white
  double gamma = 1;          ///< measured: light = (value / 255)^gamma

  bool has_grey() const { return levels > 2; }
  /// @param value  0 to 255
  /// @returns the share of the light, 0 to 1
  double light(std::uint32_t value) const { return std::pow(value / 255.0, gamma); }
  /// For each share of the dose, 0 to 255 of 255: that of the panel's values whose light is nearest.
  std::array<std::uint8_t, 256> values() const {
    const auto value = [&](std::uint32_t k) { return (510 * k + levels - 1) / (2 * (levels - 1)); };
    std::array<std::uint8_t, 256> nearest{};
    for (std::uint32_t share = 0, k = 0; share < nearest.size(); ++share) {
      while (k + 1 < levels && light(value(k)) + light(value(k + 1)) < 2 * share / 255.0) ++k;
      nearest[share] = static_cast<std::uint8_t>(value(k));
    }
    return nearest;
  }
};

/// From mask to panel: the mask is rotated, then mirrored, then packed.
struct PanelLayout {
  enum class Mirror : std::uint8_t {
    kNone,
    kX,  ///< swaps left and right
    kY,  ///< swaps top and bottom
  };

  std::uint32_t columns = 0;       ///< of the mask, 1 to 16384
  std::uint32_t rows = 0;          ///< of the mask, 1 to 16384
  std::uint32_t rotation_deg = 0;  ///< 0, 90, 180 or 270, counter-clockwise seen with row 0 at the top
  Mirror mirror = Mirror::kNone;
  /// Three neighbours of a row are red, green and blue of one pixel, as on a monochrome panel made from a colour one.
  bool rgb = false;
  GreyScale grey = {};

  /// Size of the video mode that the panel needs, pixels.
  std::uint32_t mode_width() const { return picture_width() / (rgb ? 3 : 1); }
  std::uint32_t mode_height() const { return sideways() ? columns : rows; }

  struct Pixel {
    std::uint32_t column = 0, row = 0;
    bool operator==(const Pixel&) const = default;
  };
  /// Where a pixel of the mask is in the picture that is sent, before it is packed.
  Pixel sent(Pixel mask) const {
    Pixel to = mask;
    if (rotation_deg == 90) to = {mask.row, columns - 1 - mask.column};
    if (rotation_deg == 180) to = {columns - 1 - mask.column, rows - 1 - mask.row};
    if (rotation_deg == 270) to = {rows - 1 - mask.row, mask.column};
    if (mirror == Mirror::kX) to.column = picture_width() - 1 - to.column;
    if (mirror == Mirror::kY) to.row = mode_height() - 1 - to.row;
    return to;
  }

  /// Width of the picture before it is packed, pixels.
  std::uint32_t picture_width() const { return sideways() ? rows : columns; }

  /// @retval ErrorCode::kBadSetting  rgb, and the rotated width is not a multiple of 3
  [[nodiscard]] Status check() const {
    if (!rgb || picture_width() % 3 == 0) return {};
    return fail(ErrorCode::kBadSetting, "the panel packs three pixels into one, but its rotated width is %u pixels",
                picture_width());
  }

 private:
  bool sideways() const { return rotation_deg == 90 || rotation_deg == 270; }
};

}  // namespace plumbline::inline hal
