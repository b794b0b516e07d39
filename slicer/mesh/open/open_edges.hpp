#pragma once
/// The edges of a mesh that run more often one way than the other, found in one reading of its triangles.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/mesh/mesh_lattice.hpp"

namespace plumbline::inline slicer {

/// An edge between two places of the lattice.
struct OpenEdge {
  LatticePoint low, high;    ///< low < high, in some order of all places
  std::int32_t surplus = 0;  ///< how much more often it runs from low to high than back; 0: an empty slot
};

/// All triangles that have an open edge, whichever way it runs.
struct EdgeUsers {
  std::uint32_t numbers = 0;      ///< their mixed numbers
  Vec3f outward = Vec3f::Zero();  ///< the sum of their normals
};

/// A hash table of open edges. An edge that runs as often one way as the other is removed, so that the table holds no more than the
/// rim of what has been read.
class OpenEdges {
 public:
  /// @param arena  a few KiB from the bottom, and more if there are more edges: up to a quarter of what is left. Nothing else may be
  ///               taken from the bottom while triangles are added
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<OpenEdges> create(Arena& arena);

  /// Adds a triangle's edges, unless the table is full.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] Status add(const LatticeTriangle& triangle);
  /// There are more edges than a quarter of the arena holds: not all have been added.
  bool full() const { return full_; }
  /// After all triangles have been added: the table becomes as small as the edges allow, and gets room for their users.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] Status begin_users();
  /// Tells the open edges of a triangle that it has them.
  /// @param number  of the triangle
  /// @param steps   mm in a step of the lattice
  void add_user(const LatticeTriangle& triangle, std::uint64_t number, const Vec3d& steps);

  std::uint32_t size() const { return used_; }
  std::uint64_t runs() const;  ///< sum of |surplus|
  /// Calls visit(edge, users) for each, in the order of the table.
  template <class Visit>
  void for_each(Visit visit) const {
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      if (slots_[i].surplus != 0) visit(slots_[i], users_[i]);
    }
  }

 private:
  std::size_t slot_of(const OpenEdge& edge) const;
  std::size_t find(const OpenEdge& edge) const;
  void remove(std::size_t slot);
  Status grow();
  Status shrink(std::size_t slots);

  Arena* arena_ = nullptr;
  std::span<OpenEdge> slots_;   ///< a power of two of them, at most three quarters of them used
  std::span<EdgeUsers> users_;  ///< of each slot
  std::size_t mark_ = 0;        ///< of the arena, before the slots
  std::size_t most_ = 0;        ///< slots
  std::uint32_t used_ = 0;
  bool full_ = false;
};

}  // namespace plumbline::inline slicer
