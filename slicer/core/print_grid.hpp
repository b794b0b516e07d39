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

/// How many rays a pixel has beside the middle one, for full grey. They form a rotated grid: divide the pixel into 4 x 4 squares, and no two rays
/// share a row or a column of these.
inline constexpr std::uint32_t kRaysAround = 4;
/// @param ray  1 to kRaysAround; the middle one is ray 0
constexpr PrintGrid with_ray(PrintGrid grid, std::uint32_t ray) {
  constexpr float kPlaces[kRaysAround][2] = {{0.375F, 0.125F}, {0.875F, 0.375F}, {0.125F, 0.625F}, {0.625F, 0.875F}};
  grid.ray_x = kPlaces[ray - 1][0];
  grid.ray_y = kPlaces[ray - 1][1];
  return grid;
}

/// Rays a side of a square tile. Rays are shot, and crossings stored, a tile at a time: rays of a tile share neighbours.
inline constexpr std::uint32_t kTileSide = 8;
inline constexpr std::uint32_t kRaysPerTile = kTileSide * kTileSide;

}  // namespace plumbline::inline slicer
