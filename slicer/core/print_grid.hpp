#pragma once
/// The grid of pixels and layers of a print. A ray goes through each pixel.

#include <cstdint>

namespace plumbline::inline slicer {

/// Print coordinates, mm: x along a row, y from row to row, z up. The origin is the outer corner of pixel (0, 0) on the
/// underside of layer 0. Pixel (i, j) is sampled at ((i + ray_x) pitch_x, (j + ray_y) pitch_y), its centre unless it has several rays, layer k
/// at height (k + 1/2) layer_height.
struct PrintGrid {
  std::uint32_t columns = 0;      ///< pixels, 1 to 16384
  std::uint32_t rows = 0;         ///< pixels, 1 to 16384
  std::uint32_t layers = 0;       ///< 1 to 65535
  float pitch_x_mm = 0.05F;       ///< mm
  float pitch_y_mm = 0.05F;       ///< mm
  float layer_height_mm = 0.05F;  ///< mm
  float ray_x = 0.5F;             ///< where in its pixel a ray is, in pixels
  float ray_y = 0.5F;

  /// Of a pixel's ray, mm.
  float x_of(std::uint32_t column) const { return (static_cast<float>(column) + ray_x) * pitch_x_mm; }
  float y_of(std::uint32_t row) const { return (static_cast<float>(row) + ray_y) * pitch_y_mm; }

  static constexpr std::uint32_t kMaxSide = 16384;
  static constexpr std::uint32_t kMaxLayers = 65535;
};

/// Rays around the middle one of a pixel, where that is not enough: a rotated grid, in which each has a row and a column of quarters of the pixel to
/// itself.
inline constexpr std::uint32_t kRaysAround = 4;
/// @param ray  0: in the middle; 1 to kRaysAround
constexpr PrintGrid with_ray(PrintGrid grid, std::uint32_t ray) {
  constexpr float kPlaces[1 + kRaysAround][2] = {
      {0.5F, 0.5F}, {0.375F, 0.125F}, {0.875F, 0.375F}, {0.125F, 0.625F}, {0.625F, 0.875F}};
  grid.ray_x = kPlaces[ray][0];
  grid.ray_y = kPlaces[ray][1];
  return grid;
}

/// Rays a side of a square tile. Rays are shot, and crossings stored, a tile at a time: rays of a tile share neighbours.
inline constexpr std::uint32_t kTileSide = 8;
inline constexpr std::uint32_t kRaysPerTile = kTileSide * kTileSide;

}  // namespace plumbline::inline slicer
