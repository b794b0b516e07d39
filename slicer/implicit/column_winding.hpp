#pragma once
/// The winding number at many places in one column of rays.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/implicit/winding_number.hpp"

namespace plumbline::inline slicer {

/// Columns of dipoles, padded to a multiple of kLanes with dipoles that add nothing.
struct DipoleList {
  const float* x;
  const float* y;
  const float* z;
  const float* dipole_x;
  const float* dipole_y;
  const float* dipole_z;
  const float* area;       ///< length of the dipole, mm^2
  const float* softening;  ///< mm^2
  std::uint32_t size;
};

/// WindingTree for a column of rays. The column is cut into cells; the tree is walked once for each of them, and what it meets there
/// is summed up for every place in the cell, several dipoles at a time. A node counts as one dipole if it does so for the whole
/// cell, so the numbers are a little more exact than the tree's.
///
/// One object a thread. The numbers depend on the column and the place only; those of beyond() also on how often it was asked there.
class ColumnWinding {
 public:
  static std::size_t bytes_needed();
  /// @param tree  must outlive this
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<ColumnWinding> create(const WindingTree& tree, Arena& arena);

  const WindingTree& tree() const { return *tree_; }

  /// Begins the column over [low, high], mm.
  void begin(const Vec2f& low, const Vec2f& high);

  // As WindingTree's, for places in the column at any height.
  float operator()(const Vec3f& x);
  /// As exactly as it takes to tell whether the number is farther than `margin` from one half: most cells need no list for that.
  float beyond(const Vec3f& x, float margin);
  bool inside(const Vec3f& x) { return inside(x, operator()(x)); }
  bool inside(const Vec3f& x, float winding);
  /// Depth at which the ray at (x, y) passes the surface between two depths, one of which is inside; by bisection.
  /// @param from, to   mm; either may be the lower
  /// @param tolerance  mm: stops at this distance, or at a 256th of the way
  float surface_between(float x, float y, float from, float to, bool inside_at_from, float tolerance);

 private:
  static constexpr std::uint32_t kPool = 16384;  ///< dipoles of all cells
  static constexpr std::uint32_t kCells = 64;
  static constexpr std::size_t kColumns = 8;
  static constexpr std::uint32_t kMostRough = 8;  ///< rough numbers in a cell; a list takes as long as seven of them
  static constexpr std::int32_t kNoCell = std::numeric_limits<std::int32_t>::min();

  struct Cell {
    std::int32_t number = kNoCell;  ///< from the plate up
    std::uint32_t first = 0;        ///< in the pool
    std::uint32_t size = 0;         ///< 0: too many
    std::uint32_t rough = 0;        ///< numbers given without the list
    bool gathered = false;
  };

  Cell* cell_at(const Vec3f& x);
  std::optional<DipoleList> list_at(const Vec3f& x);
  bool gather(std::int32_t number, Cell& cell);
  void clear();
  float* column(std::size_t i) const { return pool_.data() + i * kPool; }

  const WindingTree* tree_ = nullptr;
  std::span<float> pool_;
  std::array<Cell, kCells> cells_{};
  std::uint32_t used_ = 0;  ///< of the pool
  Vec2f low_ = Vec2f::Zero();
  Vec2f high_ = Vec2f::Zero();
  float cell_height_ = 1;
};

}  // namespace plumbline::inline slicer
