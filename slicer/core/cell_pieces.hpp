#pragma once
/// Cells that hold points, joined to pieces where they touch.

#include <cstdint>
#include <span>

#include "slicer/core/cell_table.hpp"
#include "slicer/core/disjoint_sets.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Sorts points into cubic cells. Cells that touch at faces, edges or corners form a piece, which a slot of the table stands for.
class CellPieces {
 public:
  struct Cell {
    std::uint64_t key = 0;     ///< 0: empty
    std::uint32_t parent = 0;  ///< slot
    float amount = 0;          ///< sum over its points; after join(), a piece's slot has that of the piece
  };

  /// @param box    around the points
  /// @param slots  a power of two; two thirds of them can be occupied
  CellPieces(const Box3f& box, float edge, std::span<Cell> slots) : grid_(box, edge), table_(slots), sets_(slots) {
    table_.clear();
  }

  /// @param amount  of whatever makes a piece large
  /// @returns false if there is no room for the point's cell
  [[nodiscard]] bool add(const Vec3f& p, float amount) {
    const std::uint64_t key = grid_.key(p);
    const std::uint32_t at = table_.find_key(key);
    if (!table_.occupied(at)) {
      if (++occupied_ > size() * 2 / 3) return false;
      table_[at] = {key, at, 0};
    }
    table_[at].amount += amount;
    return true;
  }
  std::uint32_t occupied() const { return occupied_; }

  /// Call once, after the last point.
  /// @param least  cells of a smaller amount touch nothing
  void join(float least = 0) {
    const auto counts = [&](std::uint32_t i) { return table_.occupied(i) && table_[i].amount >= least; };
    for (std::uint32_t i = 0; i < size(); ++i) {
      for (std::uint32_t n = 14; n < 27 && counts(i); ++n) {
        const std::uint32_t other = table_.find_key(CellGrid::neighbour(table_[i].key, n));
        if (counts(other)) sets_.unite(i, other);
      }
    }
    sets_.flatten(size());
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (table_.occupied(i) && !sets_.is_root(i)) table_[table_[i].parent].amount += table_[i].amount;
    }
  }

  std::uint32_t size() const { return table_.size(); }
  bool is_piece(std::uint32_t slot) const { return table_.occupied(slot) && sets_.is_root(slot); }
  float amount(std::uint32_t piece) const { return table_[piece].amount; }
  /// @param p  a point that was added
  std::uint32_t piece_of(const Vec3f& p) const { return table_[table_.find_key(grid_.key(p))].parent; }

 private:
  CellGrid grid_;
  CellTable<Cell, &Cell::key> table_;
  DisjointSets<Cell, &Cell::parent> sets_;  ///< of the occupied slots
  std::uint32_t occupied_ = 0;
};

}  // namespace plumbline::inline slicer
