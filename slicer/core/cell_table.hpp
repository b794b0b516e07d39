#pragma once
/// Cubic cells in space, and a hash table of those that are occupied.

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Numbers the cubic cells of a box.
class CellGrid {
 public:
  static constexpr int kBitsPerAxis = 21;  ///< of a key: three axes fit a word
  /// Most cells along an axis: half of what a key has room for. A box that would need more gets larger cells.
  static constexpr std::uint32_t kMostCells = 1U << (kBitsPerAxis - 1);

  /// @param edge  of a cell, in the unit of the box, positive
  CellGrid(const Box3f& box, float edge)
      : low_(box.low), inverse_(1 / std::max(edge, box.size().maxCoeff() / static_cast<float>(kMostCells - 4))) {}

  /// Key of the cell that p lies in: its number along x, y and z from 1, kBitsPerAxis each. So no key is 0, and a cell
  /// has neighbours on all sides.
  /// @param p  inside the box
  std::uint64_t key(const Vec3f& p) const {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key = key << kBitsPerAxis | (static_cast<std::uint64_t>((p[axis] - low_[axis]) * inverse_) + 1);
    }
    return key;
  }

  /// Key of one of the 26 neighbours of a cell. Visiting neighbours 14 to 26 of every cell visits each pair once.
  /// @param n  0 to 26; 13 is the cell itself
  static std::uint64_t neighbour(std::uint64_t key, std::uint32_t n) {
    const auto pack = [](std::uint64_t x, std::uint64_t y, std::uint64_t z) {
      return x << 2 * kBitsPerAxis | y << kBitsPerAxis | z;
    };
    return key + pack(n / 9, n / 3 % 3, n % 3) - pack(1, 1, 1);
  }

 private:
  Vec3f low_;
  float inverse_;
};

/// Hash table of occupied cells in the caller's slots: open addressing with linear probing. Entries are never removed.
///
/// @tparam Mark  gives the mark of a slot, which is 0 in an empty one: the slot itself, or a pointer to its member
template <class Slot, auto Mark = std::identity{}>
class CellTable {
 public:
  CellTable() = default;
  /// @param slots  a power of two of them. clear() them before the first search. One must stay empty, or find() does not
  ///               end; above two thirds occupied, searches become long
  explicit CellTable(std::span<Slot> slots) : slots_(slots) { assert(std::has_single_bit(slots.size())); }

  void clear() const { std::fill(slots_.begin(), slots_.end(), Slot{}); }

  std::uint32_t size() const { return static_cast<std::uint32_t>(slots_.size()); }
  Slot& operator[](std::uint32_t i) const { return slots_[i]; }
  bool occupied(std::uint32_t i) const { return mark(i) != 0; }

  /// The slot where the search for a cell begins.
  std::uint32_t first(std::uint64_t hash) const { return static_cast<std::uint32_t>(hash) & (size() - 1); }

  /// The slot that holds a cell, or the empty slot where it belongs.
  /// @param hash     of the cell; its low bits are used
  /// @param is_cell  bool(const Slot&): whether an occupied slot holds the cell
  template <class IsCell>
  std::uint32_t find(std::uint64_t hash, IsCell is_cell) const {
    std::uint32_t i = first(hash);
    while (occupied(i) && !is_cell(slots_[i])) i = first(i + 1);
    return i;
  }
  /// The same for slots whose mark is a key of CellGrid.
  std::uint32_t find_key(std::uint64_t key) const {
    return find(key * kGoldenStep64 >> 32, [key](const Slot& slot) { return std::invoke(Mark, slot) == key; });
  }

 private:
  auto mark(std::uint32_t i) const { return std::invoke(Mark, slots_[i]); }

  std::span<Slot> slots_;
};

}  // namespace plumbline::inline slicer
