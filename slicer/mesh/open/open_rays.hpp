#pragma once
/// The rays of a mesh that is not closed.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/mesh/hit_list.hpp"
#include "slicer/mesh/mesh_ray.hpp"
#include "slicer/mesh/ray_solids.hpp"

namespace plumbline::inline slicer {

/// Decides the rays of a block for which the hits alone can't tell what is solid: by the winding number, and by few of them where
/// they are alike.
///
/// Far from triangles the winding number changes slowly. So if the rays in the corners of a square pass the same sheets and are
/// solid in the same stretches, the rays between them that pass the same sheets are, too; where a stretch changes on the way,
/// its layer is interpolated. Rays inside of the square are a test of that; if one disagrees, the square is cut into four.
///
/// The result depends on the block alone. One object a thread.
class OpenRays {
 public:
  static constexpr std::uint32_t kSide = 4 * kTileSide;  ///< rays along each side of a block

  static std::size_t bytes_needed(const MeshField& field) {
    return Arena::rounded(kSide * kSide * sizeof(Ray)) + MeshRay::bytes_needed(field);
  }
  /// @param field  outlives this
  /// @param arena  bytes_needed() from the top
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<OpenRays> create(const MeshField& field, const PrintGrid& grid, Arena& arena);

  /// Whether rays of a tile are asked that have no hits.
  bool is_doubtful(std::uint32_t tile_column, std::uint32_t tile_row) const {
    return field_->doubtful.at(tile_column, tile_row);
  }
  /// Begins a block whose first ray is at that pixel; both are multiples of kTileSide.
  /// @param hits  outlives the block
  void begin(const HitList& hits, std::uint32_t column, std::uint32_t row);
  /// Whether the field decides a stretch of a ray.
  /// @param column, row  of the ray, in the block and in the grid
  bool is_open(std::uint32_t column, std::uint32_t row) const { return ray_at(column, row).kind != 0; }
  /// @param toggles  gets all stretches of an open ray
  void decide(std::uint32_t column, std::uint32_t row, RayToggles& toggles);
  std::uint64_t asked() const { return asked_; }  ///< rays of all blocks along which the field was computed

 private:
  static constexpr std::size_t kMostMarks = 16;

  /// From a layer upwards an open stretch is solid or not.
  struct Mark {
    std::uint16_t layer = 0;
    bool solid = false;
    bool begins = false;  ///< a stretch
  };
  struct Ray {
    RayHits hits;
    std::uint64_t kind =
        0;  ///< equal for rays with the same sequence of stretches; 0: not open, or outside of the grid
    std::array<Mark, kMostMarks> mark;
    std::uint8_t count = 0;  ///< marks
    bool doubtful = false;   ///< the field is asked in long empty stretches, too
    bool known = false;      ///< the marks are
    std::span<const Mark> marks() const { return std::span(mark).first(count); }
  };
  /// A square of rays; c and r count columns and rows from the first ray of the block.
  struct Square {
    std::uint32_t c, r, side;
  };
  using Corners = std::array<const Ray*, 4>;

  OpenRays(const MeshField& field, const PrintGrid& grid, std::span<Ray> rays, const MeshRay& along);
  Ray& at(std::uint32_t c, std::uint32_t r) const { return rays_[r * kSide + c]; }
  const Ray& ray_at(std::uint32_t column, std::uint32_t row) const { return at(column - column_, row - row_); }
  bool asks(const Ray& ray, const RayStretch& stretch) const {
    return !stretch.is_sure() || (ray.doubtful && !stretch.is_solid() && stretch.end - stretch.begin > long_gap_);
  }
  std::uint64_t kind_of(const Ray& ray) const;
  bool ask(std::uint32_t c, std::uint32_t r);
  bool ask_corners(const Square& square, Corners& corners);
  bool foretells(const Square& square, const Corners& corners, std::uint32_t dc, std::uint32_t dr);
  bool lies_between(const Ray& ray, const Corners& corners) const;
  void interpolate(Ray& ray, const Square& square, const Corners& corners, std::uint32_t dc, std::uint32_t dr) const;
  void decide_square(const Square& square);

  const MeshField* field_;
  const PrintGrid* grid_;
  std::span<Ray> rays_;     ///< row by row
  MeshRay along_;           ///< one of them
  std::uint32_t long_gap_;  ///< layers
  std::uint32_t column_ = 0, row_ = 0;
  std::uint64_t asked_ = 0;
};

}  // namespace plumbline::inline slicer
