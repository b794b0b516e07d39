#pragma once
/// Linked kd-trees (thesis III-2.a): nanoflann in two and in three dimensions over the same point indices, with leaf
/// size 10. nanoflann builds the nodes and searches them. All of their memory is in the arena.

#include <bit>
#include <cstdint>
#include <limits>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

struct Neighbour {
  std::uint32_t index = 0;
  float distance2 = 0;  ///< squared, mm^2

  /// Ascends with the distance, then with the index: squares are not negative, so they are in the order of their bits.
  friend bool operator<(const Neighbour& a, const Neighbour& b) {
    static_assert(std::endian::native == std::endian::little);
    return std::bit_cast<std::uint64_t>(a) < std::bit_cast<std::uint64_t>(b);
  }
};

/// A kd-tree over the first Dimension coordinates of the points. Searches are const and may run in many threads.
///
/// build() puts it at the top of the arena, where it stays until the arena releases it. The points must not move or change,
/// except that they may be permuted by order() if that becomes 0, 1, 2, ...: Cloud::reorder().
template <int Dimension>
class KdTree {
 public:
  static constexpr std::size_t kLeafSize = 10;  ///< points at most; nanoflann's recommendation, and the thesis' choice

  /// Planned bytes of arena a point, its index included. Scans take up to 15.8 in three dimensions and 13.7 in two.
  /// Adversarial points (that a middle split peels off one by one) may take more and get kOutOfMemory.
  static constexpr std::size_t kBytesPerPoint = Dimension == 3 ? 17 : 15;

  /// @param points  at least one, finite
  /// @param stage   named in errors
  /// @retval ErrorCode::kOutOfMemory, kCancelled
  [[nodiscard]] static Expected<KdTree> build(std::span<const Vec3f> points, Arena& arena, const char* stage,
                                              const StageProgress& progress = {});

  /// Indices of the points, leaf by leaf: neighbours in space are mostly neighbours in this order.
  std::span<const std::uint32_t> order() const;
  std::span<std::uint32_t> order();

  /// Finds the `found.size()` nearest points (of those that `accept` returns true for), nearest first, ties by index.
  /// @returns how many it found
  std::uint32_t nearest(const Vec3f& query, std::span<Neighbour> found) const;
  /// @param most2  square of the distance, mm^2, beyond which nothing is looked for; a point at just that distance may be missed
  std::uint32_t nearest(const Vec3f& query, std::span<Neighbour> found, FunctionRef<bool(std::uint32_t)> accept,
                        float most2 = std::numeric_limits<float>::max()) const;

  /// Finds the points within a distance, in the order in which nanoflann meets them.
  /// @param most2  square of the distance, mm^2
  /// @returns how many it found; as many as there is room for: there may be more
  std::size_t within(const Vec3f& query, float most2, std::span<Neighbour> found) const;

  /// Calls `visit(first, last)` for ranges of order() that together hold every point in the box [low, high], and some
  /// outside it. The ranges ascend and don't touch: adjacent leaves are joined.
  void visit_box(const Vec3f& low, const Vec3f& high, FunctionRef<void(std::uint32_t, std::uint32_t)> visit) const;

 private:
  struct Impl;
  Impl* impl_ = nullptr;
};

using KdTree2 = KdTree<2>;
using KdTree3 = KdTree<3>;

}  // namespace plumbline::inline slicer
