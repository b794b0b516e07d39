#pragma once
/// The grid of pixels and layers of a print. A ray goes through the centre of each pixel.

#include <cstdint>

namespace plumbline::inline slicer {

/// Print coordinates, mm: x along a row, y from row to row, z up. The origin is the outer corner of pixel (0, 0) on the
/// underside of layer 0. Pixel (i, j) is sampled at its centre ((i + 1/2) pitch_x, (j + 1/2) pitch_y), layer k at height
/// (k + 1/2) layer_height.
struct PrintGrid {
  std::uint32_t columns = 0;      ///< pixels, 1 to 16384
  std::uint32_t rows = 0;         ///< pixels, 1 to 16384
  std::uint32_t layers = 0;       ///< 1 to 65535
  float pitch_x_mm = 0.05F;       ///< mm
  float pitch_y_mm = 0.05F;       ///< mm
  float layer_height_mm = 0.05F;  ///< mm

  /// Of a pixel's centre, mm.
  float x_of(std::uint32_t column) const { return (static_cast<float>(column) + 0.5F) * pitch_x_mm; }
  float y_of(std::uint32_t row) const { return (static_cast<float>(row) + 0.5F) * pitch_y_mm; }

  static constexpr std::uint32_t kMaxSide = 16384;
  static constexpr std::uint32_t kMaxLayers = 65535;
};

/// Rays a side of a square tile. Rays are shot, and crossings stored, a tile at a time: rays of a tile share neighbours.
inline constexpr std::uint32_t kTileSide = 8;
inline constexpr std::uint32_t kRaysPerTile = kTileSide * kTileSide;

}  // namespace plumbline::inline slicer
