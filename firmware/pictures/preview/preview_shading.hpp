#pragma once
/// Shades a depth map.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/pictures/preview/picture.hpp"

namespace plumbline::firmware::inline pictures {

/// Distance of the object from the viewer's plane, rows from the top. Depths are in samples of the map, so that a slope of 1 is
/// 45 degrees.
struct DepthMap {
  static constexpr float kEmpty = 1e30F;  ///< no object here

  std::span<float> depth;            ///< columns * rows
  std::span<std::uint8_t> material;  ///< columns * rows: index of the material that is seen
  std::uint32_t columns = 0, rows = 0;

  float& at(std::uint32_t column, std::uint32_t row) const { return depth[std::size_t{row} * columns + column]; }
  void show(std::uint32_t column, std::uint32_t row, float depth_in_samples, bool second_material) const {
    const std::size_t sample = std::size_t{row} * columns + column;
    depth[sample] = depth_in_samples;
    material[sample] = second_material ? 1 : 0;
  }
  void copy_line(std::uint32_t from, std::uint32_t to) const {
    const std::size_t source = std::size_t{from} * columns, target = std::size_t{to} * columns;
    std::copy_n(depth.begin() + static_cast<std::ptrdiff_t>(source), columns,
                depth.begin() + static_cast<std::ptrdiff_t>(target));
    std::copy_n(material.begin() + static_cast<std::ptrdiff_t>(source), columns,
                material.begin() + static_cast<std::ptrdiff_t>(target));
  }
};

inline constexpr std::uint32_t kSamplesPerPixel = 2;  ///< of a depth map, on each side of a pixel of the picture

/// Columns that a map has at most: those of a page.
inline constexpr std::size_t kMostSamples = 3200;

/// Draws the object lit from the upper left, with soft shadows and darker creases.
/// @param map        a whole number of pixels
/// @param scratch    as many as map.depth
/// @param left, top  pixel of the picture where the map's first sample goes
/// @param materials  as many as the map has, by index
/// @param shadowless  the material that casts no shadow: thin supports would hide more of the object than they cover
void shade_depth(const DepthMap& map, std::span<float> scratch, const Picture& picture, std::int64_t left,
                 std::int64_t top, std::span<const Rgb> materials, std::optional<std::uint8_t> shadowless = {});

}  // namespace plumbline::firmware::inline pictures
