#pragma once
/// How a panel expects the pixels of a mask.

#include <array>
#include <cmath>
#include <cstdint>

#include "hal/lamp_map.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

/// How much light a panel lets through for the values that it is sent.
struct GreyScale {
  std::uint32_t levels = 2;  ///< that it tells apart, 2 to 256, evenly spaced from 0 to 255. 2: black and white
  double gamma = 1;          ///< measured: light = (value / 255)^gamma
  /// With 2 levels: what is grey gets its share of the light by up to so many exposures of a layer more, 0 to kMostExposures. 0: it is
  /// black or white.
  std::uint32_t exposures = 0;
  static constexpr std::uint32_t kMostExposures = 4;

  /// Whether a mask on the panel can have grey pixels.
  bool has_levels() const { return levels > 2; }
  /// Whether a layer can.
  bool has_grey() const { return has_levels() || exposures > 0; }
  /// @param value  0 to 255
  /// @returns the share of the light, 0 to 1
  double light(std::uint32_t value) const { return std::pow(value / 255.0, gamma); }
  /// The panel's value for each share of the dose, 0 to 255 of 255, at each place of a pattern of 4 x 4 pixels. It is one of the two whose light is
  /// next to the share; the brighter one stands in so many places that the pattern's mean light comes nearest. [share][4 * (row % 4) + column % 4]
  using Values = std::array<std::array<std::uint8_t, 16>, 256>;
  Values values() const {
    // Ordered dither: thresholds of 16ths, neighbours as different as can be (Bayer 1973).
    constexpr std::array<int, 16> kOrder = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
    const auto value = [&](std::uint32_t k) { return (510 * k + levels - 1) / (2 * (levels - 1)); };
    Values values{};
    for (std::uint32_t share = 0, k = 0; share < values.size(); ++share) {
      const double asked = share / 255.0;
      while (k + 2 < levels && light(value(k + 1)) <= asked) ++k;
      const double below = light(value(k)), part = (asked - below) / (light(value(k + 1)) - below);
      for (std::size_t i = 0; i < kOrder.size(); ++i) {
        values[share][i] = static_cast<std::uint8_t>(value(16 * part > kOrder[i] + 0.5 ? k + 1 : k));
      }
    }
    return values;
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
  LampMap lamp = {};  ///< of the mask's rows and columns; needs grey.has_levels()

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
