#pragma once
/// The object as supports see it: where it is, in coarse voxels.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/disc.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline::inline slicer {

/// Voxels of a quarter of a millimetre, or larger if they would take more than kMostBytes. One is solid if any pixel of any
/// mask in it is. Distances between solid and supports are measured from voxel to voxel and horizontally; they are never
/// overstated by more than a voxel.
class Obstacles {
 public:
  static constexpr double kVoxel_mm = 0.25;
  static constexpr std::size_t kMostBytes = std::size_t{8} << 20;

  /// Makes all masks once.
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena, and a LayerStream's from the bottom
  [[nodiscard]] static Expected<Obstacles> create(const RRep& rrep, Nanometres column_radius, Arena& arena);
  /// @param lift_mm  by which the object may be lifted above the grid's layers
  static std::size_t bytes_needed(const PrintGrid& grid, double lift_mm);

  /// Whether no solid is within `radius` of a pixel, at the height of a layer.
  bool is_clear(std::int64_t column, std::int64_t row, std::int64_t layer, Nanometres radius) const;

  /// Whether no solid is within column_radius of a pixel, from the plate up to the height of a layer.
  bool is_column_clear(std::int64_t column, std::int64_t row, std::int64_t layer) const;

  /// The first layer above the highest solid below a pixel in a layer; 0: there is none down to the plate.
  std::uint32_t floor_below(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const;
  /// Whether the object goes on for a voxel all round a place that it ends below, at most a voxel lower: not on edges, nor on points.
  /// @param floor  floor_below()
  bool is_footing(std::uint32_t column, std::uint32_t row, std::uint32_t floor) const;

  /// The outward normal of the surface at a place: a unit vector from the centre of what is solid around it. The z axis,
  /// downwards, if nothing is.
  /// @param radius  voxels
  Vec3d normal(std::uint32_t column, std::uint32_t row, std::uint32_t layer, std::int32_t radius) const;

  std::uint32_t voxel_columns() const { return columns_; }  ///< pixels
  std::uint32_t voxel_rows() const { return rows_; }
  std::uint32_t voxel_layers() const { return layers_; }

 private:
  BitImage slab(std::uint32_t z) const {
    return BitImage(words_.subspan(std::size_t{z} * slab_words_, slab_words_), nx_, ny_);
  }
  Status take_memory(Arena& arena);
  /// @param window  holds all pixels of all masks
  void add(std::uint32_t layer, ConstBitImage mask, const Window& window);
  Status find_lowest(Nanometres column_radius, Arena& arena);

  std::uint32_t columns_ = 1, rows_ = 1, layers_ = 1;  ///< of a voxel
  std::uint32_t nx_ = 0, ny_ = 0, nz_ = 0;
  PixelPitch pitch_;  ///< of voxels
  std::size_t slab_words_ = 0;
  std::span<std::uint64_t> words_;
  std::span<std::uint16_t> lowest_;  ///< by column of voxels: the lowest that has solid within column_radius
};

}  // namespace plumbline::inline slicer
