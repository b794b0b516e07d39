#pragma once
/// Linked kd-trees (thesis III-2.a): nanoflann in two and in three dimensions over the same point indices, leaf size 10,
/// every byte of them in the arena.

#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/core/vec.hpp"

namespace plumbline {

/// A reference to something callable; nothing is copied, nothing allocated.
template <class Signature>
class FunctionRef;
template <class Result, class... Args>
class FunctionRef<Result(Args...)> {
 public:
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, FunctionRef>)
      FunctionRef(F&& f)  // NOLINT(google-explicit-constructor): a view
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(f)))),
        call_([](void* object, Args... args) -> Result {
          return (*static_cast<std::remove_reference_t<F>*>(object))(args...);
        }) {}
  Result operator()(Args... args) const { return call_(object_, args...); }

 private:
  void* object_;
  Result (*call_)(void*, Args...);
};

struct Neighbour {
  std::uint32_t index = 0;
  float distance2 = 0;  ///< squared, mm^2
};

/// A kd-tree over the first Dimension coordinates of the points. Searches are const and may run in many threads.
///
/// Lives in the arena from build() on, at the top; it is gone when the arena releases it. The points must stay where they
/// are; they may be permuted by order() if adopt_order() follows.
template <int Dimension>
class KdTree {
 public:
  static constexpr std::size_t kLeafSize = 10;

  /// What is planned of the arena a point, its index included. Scans and shapes take 12.7 to 14.9 in the plane and 13.0 to
  /// 16.4 in space. Hostile ones (points that a middle split peels off one by one) may take more and then get kOutOfMemory.
  static constexpr std::size_t kBytesPerPoint = Dimension == 2 ? 16 : 18;

  /// @param points  at least one, finite
  /// @param stage   for the error
  /// @retval ErrorCode::kOutOfMemory, kCancelled
  [[nodiscard]] static Expected<KdTree> build(std::span<const Vec3f> points, Arena& arena, const char* stage,
                                              const StageProgress& progress = {});

  /// Indices of the points, leaf after leaf: neighbours in space are mostly neighbours in this order.
  std::span<const std::uint32_t> order() const;

  /// Tells the tree that point order()[i] now stands at i. order() is 0, 1, 2, ... from then on.
  void adopt_order();

  /// The `found.size()` nearest of the points that `accept` lets through, nearest first, equal distances by index.
  /// @returns how many there are
  std::uint32_t nearest(const Vec3f& query, std::span<Neighbour> found) const;
  std::uint32_t nearest(const Vec3f& query, std::span<Neighbour> found, FunctionRef<bool(std::uint32_t)> accept) const;

  /// Calls `visit(first, last)` for ranges of order() that together hold every point in the box [low, high], and some
  /// outside it. In ascending order, adjacent leaves joined.
  void visit_box(const Vec3f& low, const Vec3f& high, FunctionRef<void(std::uint32_t, std::uint32_t)> visit) const;

 private:
  struct Impl;
  Impl* impl_ = nullptr;
};

using KdTree2 = KdTree<2>;
using KdTree3 = KdTree<3>;

}  // namespace plumbline
