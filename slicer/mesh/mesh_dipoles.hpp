#pragma once
/// The surface of a mesh as dipoles of the winding number, for meshes that are not closed.

#include <cstdint>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/cell_table.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Cuts triangles into patches no longer than a cell, and adds up the patches of each cell. Far from a cell its sum acts as its
/// patches do; the winding number is trusted about a cell away from the surface.
class MeshDipoles {
 public:
  /// Cells for which there is room, if the arena has it: 5 MiB while triangles are read.
  static constexpr std::uint32_t kMostSlots = 1U << 17U;

  /// Cells in an arena that has `available` bytes left.
  static std::uint32_t slots_in(std::size_t available);
  /// Bytes of the arena: while triangles are read, and for the winding number of that many cells after it.
  static std::size_t reading_bytes(std::uint32_t slots);
  static std::size_t field_bytes(std::uint32_t slots);

  /// @param box    of the surface, mm
  /// @param area   of the surface, mm^2: decides the size of the cells
  /// @param arena  at most a quarter of what is left, from the bottom; the caller releases it
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<MeshDipoles> create(const Box3f& box, double area, Arena& arena);

  /// @param corners  mm, in the box
  /// @returns false if there are more cells than room: double_cells() and begin again
  [[nodiscard]] bool add(const Vec3d& a, const Vec3d& b, const Vec3d& c);
  /// Empties all cells and makes them twice as long.
  void double_cells();
  float cell() const { return cell_; }  ///< side, mm

  /// The cells as points with normals, in the order of a 3D tree. radius[] gives their areas.
  /// @param arena  the cloud stays at the top
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] Expected<Cloud> to_cloud(Arena& arena) const;

 private:
  struct Cell {
    std::uint64_t key = 0;           ///< CellGrid::key(); 0: empty
    float area = 0;                  ///< mm^2
    Vec3f weighted = Vec3f::Zero();  ///< area * position
    Vec3f directed = Vec3f::Zero();  ///< area * normal, mm^2
  };
  using Table = CellTable<Cell, &Cell::key>;

  [[nodiscard]] bool add_patch(const Vec3f& centre, const Vec3f& directed);

  Box3f box_;
  float cell_ = 0;
  std::optional<CellGrid> grid_;
  Table table_;
  std::uint32_t used_ = 0;  ///< cells
};

}  // namespace plumbline::inline slicer
