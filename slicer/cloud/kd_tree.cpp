#include "slicer/cloud/kd_tree.hpp"

// nanoflann has no allocator hook: its pool calls ::malloc and ::free, and its index is a std::vector. Only this file
// includes it. TreeBuilder makes the nodes, so the pool stays empty, and the search is our own, further down. All headers that
// nanoflann needs come first. Then malloc and free are redirected around that one include, and std::allocator is specialised for
// an index type of our own, as the standard allows.
#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <istream>
#include <limits>
#include <new>
#include <numeric>
#include <ostream>
#include <stdexcept>
#include <unordered_set>
#include <vector>

#include "slicer/cloud/tree_builder.hpp"
#include "slicer/core/numbers/mib.hpp"

namespace plumbline {
namespace {

/// Set while a tree is built, in the thread that began it.
thread_local Arena* building = nullptr;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

struct Building {
  explicit Building(Arena& arena) { building = &arena; }
  ~Building() { building = nullptr; }
  Building(const Building&) = delete;
  Building& operator=(const Building&) = delete;
};

void* arena_bytes(std::size_t bytes) {
  if (building == nullptr) return nullptr;
  const auto block = building->take_top<std::byte>(bytes, "kd-tree");
  return block ? block->data() : nullptr;
}

/// A point's index as a type of our own, for which std::allocator may be specialised.
struct PointIndex {
  std::uint32_t value = 0;
  PointIndex() = default;
  template <class Integer>
  // NOLINTNEXTLINE(google-explicit-constructor): nanoflann's use
  requires std::is_integral_v<Integer> PointIndex(Integer v) : value(static_cast<std::uint32_t>(v)) {}
  operator std::uint32_t() const { return value; }  // NOLINT(google-explicit-constructor)
};
static_assert(sizeof(PointIndex) == sizeof(std::uint32_t));

}  // namespace
}  // namespace plumbline

template <>
class std::allocator<plumbline::PointIndex> {
 public:
  using value_type = plumbline::PointIndex;
  using size_type = std::size_t;
  using difference_type = std::ptrdiff_t;
  using propagate_on_container_move_assignment = std::true_type;
  using is_always_equal = std::true_type;
  value_type* allocate(std::size_t count) {
    void* block = plumbline::arena_bytes(count * sizeof(value_type));
    if (block == nullptr) throw std::bad_alloc();
    return static_cast<value_type*>(block);
  }
  void deallocate(value_type* /*block*/, std::size_t /*count*/) {}  // the arena's stack takes it back
  [[maybe_unused]] friend bool operator==(const allocator& /*a*/, const allocator& /*b*/) { return true; }
};

void* plumbline_nanoflann_malloc(std::size_t bytes);
void plumbline_nanoflann_free(void* block);
// nanoflann answers a null pointer with a line on stderr and this exception. Throwing it here keeps stderr clean.
void* plumbline_nanoflann_malloc(std::size_t /*bytes*/) { throw std::bad_alloc(); }
void plumbline_nanoflann_free(void* /*block*/) {}

#define malloc plumbline_nanoflann_malloc
#define free plumbline_nanoflann_free
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <nanoflann.hpp>
#pragma GCC diagnostic pop
#undef malloc
#undef free

namespace plumbline {
namespace {

struct PointSet {
  std::span<const Vec3f> points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(PointIndex i, std::int32_t dimension) const { return points[i.value][dimension]; }
  template <class BoundingBox>
  bool kdtree_get_bbox(BoundingBox& /*box*/) const {
    return false;
  }
};

/// std::nextafter() towards infinity, without a call: the floats from 0 up are in the order of their bits.
/// @param x  0 to infinity
float next_up(float x) {
  return x < std::numeric_limits<float>::infinity() ? std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) + 1) : x;
}

/// The k nearest accepted points, in the caller's buffer. Ties are broken by index, so the result does not depend on the order
/// of the leaves.
class NearestSet {
 public:
  NearestSet(std::span<Neighbour> found, float most2, const FunctionRef<bool(std::uint32_t)>* accept)
      : found_(found), beyond2_(next_up(most2)), accept_(accept) {}
  std::size_t size() const { return count_; }
  bool full() const { return count_ == found_.size(); }
  /// Squared distance, mm^2. Only points closer than this can be among the nearest.
  float beyond2() const {
    // The next float up: a point at exactly the worst distance with a smaller index must not be pruned.
    return full() ? next_up(found_[count_ - 1].distance2) : beyond2_;
  }
  void add(const Neighbour& point) {
    if (accept_ != nullptr && !(*accept_)(point.index)) return;
    if (full() && !(point < found_[count_ - 1])) return;
    std::size_t at = full() ? count_ - 1 : count_++;
    for (; at > 0 && point < found_[at - 1]; --at) found_[at] = found_[at - 1];
    found_[at] = point;
  }

 private:
  std::span<Neighbour> found_;
  float beyond2_;  ///< mm^2: the next float above the largest square of a distance that counts
  const FunctionRef<bool(std::uint32_t)>* accept_;
  std::size_t count_ = 0;
};

}  // namespace

template <int Dimension>
struct KdTree<Dimension>::Impl {
  using Metric = nanoflann::L2_Simple_Adaptor<float, PointSet, float, PointIndex>;
  using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, PointSet, Dimension, PointIndex>;

  explicit Impl(std::span<const Vec3f> points)
      : set{points},
        index(Dimension, set, {kLeafSize, nanoflann::KDTreeSingleIndexAdaptorFlags::SkipInitialBuildIndex}) {}

  /// Walks the leaves that overlap a box, and joins adjacent ones before it passes them to `visit`.
  struct Visitor {
    const TreeNodes& nodes;
    const float* low;
    const float* high;
    FunctionRef<void(std::uint32_t, std::uint32_t)> visit;
    std::uint32_t first = 0, last = 0;

    void leaf(std::uint32_t from, std::uint32_t to) {
      if (from == last && last != first) {
        last = to;
        return;
      }
      flush();
      first = from;
      last = to;
    }
    void flush() {
      if (first != last) visit(first, last);
      first = last = 0;
    }
    /// @param open  bits of the box's sides that the node may reach beyond: 2 f and 2 f + 1 for low[f] and high[f]
    void walk(const TreeNode* node, std::uint32_t open) {
      while (!node->is_leaf() && open != 0) {
        const std::uint32_t axis = node->axis();
        const bool left = low[axis] <= node->cut;
        const bool right = high[axis] >= node->cut;
        const TreeNode* const children = nodes.children_of(*node);
        if (left && right) {
          walk(children, open & ~(2U << 2 * axis));
          open &= ~(1U << 2 * axis);
        }
        node = right ? children + 1 : children;
      }
      leaf(first_of(node), last_of(node));
    }
    std::uint32_t first_of(const TreeNode* node) const {
      while (!node->is_leaf()) node = nodes.children_of(*node);
      return node->first;
    }
    /// One past the node's last point.
    std::uint32_t last_of(const TreeNode* node) const {
      while (!node->is_leaf()) node = nodes.children_of(*node) + 1;
      return node->last();
    }
  };

  /// Finds the nearest points of a place, the closer child first.
  struct Search {
    const Impl& tree;
    const float* query;
    NearestSet& found;
    std::array<float, Dimension> gap2 = {};  ///< mm^2, of the node from the query, by axis

    float square(float a, std::size_t axis) const { return (query[axis] - a) * (query[axis] - a); }

    void run() {
      const auto& box = tree.index.root_bbox;
      float sum2 = 0;
      for (std::size_t axis = 0; axis < Dimension; ++axis) {
        if (query[axis] < box[axis].low) gap2[axis] = square(box[axis].low, axis);
        if (query[axis] > box[axis].high) gap2[axis] = square(box[axis].high, axis);
        sum2 += gap2[axis];
      }
      walk(tree.nodes.root(), sum2);
    }
    /// @param sum2  mm^2, of gap2
    void walk(const TreeNode& node, float sum2) {
      if (node.is_leaf()) {
        look(node);
        return;
      }
      const std::uint32_t axis = node.axis();
      const bool left = query[axis] < node.cut;
      const TreeNode* const children = tree.nodes.children_of(node);
      walk(children[left ? 0 : 1], sum2);
      const float other2 = square(node.cut, axis);
      const float before2 = gap2[axis];
      sum2 = sum2 + other2 - before2;
      if (!(sum2 <= found.beyond2())) return;
      gap2[axis] = other2;
      walk(children[left ? 1 : 0], sum2);
      gap2[axis] = before2;
    }
    void look(const TreeNode& leaf) {
      const float beyond2 = found.beyond2();
      for (std::uint32_t k = leaf.first; k < leaf.last(); ++k) {
        const std::uint32_t i = tree.index.vAcc[k];
        float distance2 = 0;
        for (std::size_t axis = 0; axis < Dimension; ++axis) {
          distance2 += square(tree.set.points[i][static_cast<int>(axis)], axis);
        }
        if (distance2 < beyond2) found.add({i, distance2});
      }
    }
  };

  PointSet set;
  TreeNodes nodes;
  Index index;
};

template <int Dimension>
Expected<KdTree<Dimension>> KdTree<Dimension>::build(std::span<const Vec3f> points, Arena& arena, const char* stage,
                                                     const StageProgress& progress) {
  using Storage = std::aligned_storage_t<sizeof(Impl), alignof(Impl)>;
  const auto place = arena.take_top<Storage>(1, stage);
  PLUMBLINE_TRY(place);
  const std::size_t left = arena.available();
  KdTree tree;
  std::uint32_t pairs = 0;
  try {
    const Building here(arena);
    tree.impl_ = new (place->data()) Impl(points);
    tree.impl_->index.init_vind();
    TreeNodes& nodes = tree.impl_->nodes = TreeNodes(arena.free_room());
    const std::size_t expected = points.size() * (kBytesPerPoint - sizeof(PointIndex)) / TreeNodes::kPairBytes;
    TreeBuilder builder(tree.impl_->index, nodes, progress, std::max<std::size_t>(expected, 1));
    pairs = builder.run();
    if (builder.cancelled()) return fail(ErrorCode::kCancelled, "%s: cancelled while building a tree", stage);
  } catch (const std::bad_alloc&) {  // of the order of the points
  }
  if (pairs == 0) {
    return fail(
        ErrorCode::kOutOfMemory,
        "%s: the %dD tree of %zu points needs more than the %.1f MiB that were left of the arena's %.1f MiB.\tUse a "
        "larger arena or fewer points",
        stage, Dimension, points.size(), mib(left), mib(arena.capacity()));
  }
  PLUMBLINE_TRY(arena.take_top<std::byte>(std::size_t{pairs} * TreeNodes::kPairBytes, stage));
  return tree;
}

template <int Dimension>
std::span<std::uint32_t> KdTree<Dimension>::order() {
  auto& index = impl_->index.vAcc;
  return {reinterpret_cast<std::uint32_t*>(index.data()), index.size()};
}

template <int Dimension>
std::span<const std::uint32_t> KdTree<Dimension>::order() const {
  return KdTree(*this).order();
}

template <int Dimension>
std::uint32_t KdTree<Dimension>::nearest(const Vec3f& query, std::span<Neighbour> found) const {
  NearestSet set(found, std::numeric_limits<float>::max(), nullptr);
  typename Impl::Search{*impl_, query.data(), set}.run();
  return static_cast<std::uint32_t>(set.size());
}

template <int Dimension>
std::uint32_t KdTree<Dimension>::nearest(const Vec3f& query, std::span<Neighbour> found,
                                         FunctionRef<bool(std::uint32_t)> accept, float most2) const {
  NearestSet set(found, most2, &accept);
  typename Impl::Search{*impl_, query.data(), set}.run();
  return static_cast<std::uint32_t>(set.size());
}

template <int Dimension>
void KdTree<Dimension>::visit_box(const Vec3f& low, const Vec3f& high,
                                  FunctionRef<void(std::uint32_t, std::uint32_t)> visit) const {
  typename Impl::Visitor visitor{impl_->nodes, low.data(), high.data(), visit};
  visitor.walk(&impl_->nodes.root(), (1U << 2 * Dimension) - 1);
  visitor.flush();
}

template class KdTree<2>;
template class KdTree<3>;

}  // namespace plumbline
