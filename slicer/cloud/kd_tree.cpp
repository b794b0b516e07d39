#include "slicer/cloud/kd_tree.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>

#include "slicer/core/numbers/mib.hpp"

namespace plumbline::inline slicer {
namespace {

/// Gives nanoflann the arena's room while a tree is built: first for the indices, then for one node after another. Threads share it.
class TreeRoom {
 public:
  /// @param expected  nodes, for the progress
  TreeRoom(Arena& arena, const StageProgress& progress, std::size_t expected)
      : arena_(arena), progress_(progress), expected_(expected) {}

  void* indices(std::size_t bytes) {
    const auto block = arena_.take_top<std::byte>(bytes, "kd-tree");
    if (!block) throw std::bad_alloc();
    free_ = arena_.free_room();
    return block->data();
  }
  /// From the upper end of the free room downwards. Throws std::bad_alloc if it is full, or the build was cancelled.
  void* node(std::size_t bytes) {
    const std::uint32_t number = taken_.fetch_add(1, std::memory_order_relaxed);
    if (number % kReportedNodes == 0 && omp_get_thread_num() == 0 &&
        !progress_.advance(std::min(1.0, static_cast<double>(number) / static_cast<double>(expected_)))) {
      cancelled_ = true;
    }
    const std::size_t end = (std::size_t{number} + 1) * bytes;
    if (end > free_.size() || cancelled_) throw std::bad_alloc();
    return free_.data() + (free_.size() - end);
  }
  std::uint32_t nodes() const { return taken_; }
  bool cancelled() const { return cancelled_; }

  /// Set in a thread that builds a tree.
  static thread_local TreeRoom* current;

 private:
  static constexpr std::uint32_t kReportedNodes = 1024;  ///< between two reports

  Arena& arena_;
  const StageProgress& progress_;
  std::size_t expected_;
  std::span<std::byte> free_;
  std::atomic<std::uint32_t> taken_ = 0;  ///< nodes
  std::atomic<bool> cancelled_ = false;
};
thread_local TreeRoom* TreeRoom::current = nullptr;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

struct Building {
  explicit Building(TreeRoom& room) { TreeRoom::current = &room; }
  ~Building() { TreeRoom::current = nullptr; }
  Building(const Building&) = delete;
  Building& operator=(const Building&) = delete;
};

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
}  // namespace plumbline::inline slicer

/// nanoflann keeps the indices in a std::vector. It releases nothing: the arena's stack takes all of a tree back.
template <>
class std::allocator<plumbline::PointIndex> {
 public:
  using value_type = plumbline::PointIndex;
  using size_type = std::size_t;
  using difference_type = std::ptrdiff_t;
  using propagate_on_container_move_assignment = std::true_type;
  using is_always_equal = std::true_type;
  value_type* allocate(std::size_t count) {
    return static_cast<value_type*>(plumbline::TreeRoom::current->indices(count * sizeof(value_type)));
  }
  void deallocate(value_type* /*block*/, std::size_t /*count*/) {}
  [[maybe_unused]] friend bool operator==(const allocator& /*a*/, const allocator& /*b*/) { return true; }
};

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <nanoflann.hpp>
#pragma GCC diagnostic pop

namespace plumbline::inline slicer {
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

using Metric = nanoflann::L2_Simple_Adaptor<float, PointSet, float, PointIndex>;
template <int Dimension>
using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, PointSet, Dimension, PointIndex>;
template <int Dimension>
using Node = typename Index<Dimension>::Node;

/// std::nextafter() towards infinity, without a call: the floats from 0 up are in the order of their bits.
/// @param x  0 to infinity
float next_up(float x) {
  return x < std::numeric_limits<float>::infinity() ? std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) + 1) : x;
}

/// nanoflann's result set for the k nearest accepted points, in the caller's buffer. Ties are broken by index, so the result does not
/// depend on the order of the leaves.
class NearestSet {
 public:
  NearestSet(std::span<Neighbour> found, float most2, const FunctionRef<bool(std::uint32_t)>* accept)
      : found_(found), beyond2_(next_up(most2)), accept_(accept) {}
  std::size_t size() const { return count_; }
  bool full() const { return count_ == found_.size(); }
  /// Squared distance, mm^2. Only points closer than this can be among the nearest.
  float worstDist() const {
    // The next float up: a point at exactly the worst distance with a smaller index must not be pruned.
    return full() ? next_up(found_[count_ - 1].distance2) : beyond2_;
  }
  bool addPoint(float distance2, PointIndex index) {
    const Neighbour point{index, distance2};
    if (full() && !(point < found_[count_ - 1])) return true;
    if (accept_ != nullptr && !(*accept_)(index)) return true;
    std::size_t at = full() ? count_ - 1 : count_++;
    for (; at > 0 && point < found_[at - 1]; --at) found_[at] = found_[at - 1];
    found_[at] = point;
    return true;
  }

 private:
  std::span<Neighbour> found_;
  float beyond2_;  ///< mm^2: the next float above the largest square of a distance that counts
  const FunctionRef<bool(std::uint32_t)>* accept_;
  std::size_t count_ = 0;
};

/// nanoflann's result set for all points within a distance.
class WithinSet {
 public:
  WithinSet(float most2, std::span<Neighbour> found)
      : most2_(most2), beyond2_(next_up(1.001F * most2)), found_(found) {}
  bool full() const { return false; }
  float worstDist() const { return beyond2_; }
  /// @returns whether to go on
  bool addPoint(float distance2, PointIndex index) {
    if (count_ == found_.size()) return false;
    found_[count_] = {index, distance2};
    count_ += distance2 <= most2_ ? 1 : 0;
    return true;
  }
  std::size_t count() const { return count_; }

 private:
  float most2_;
  float beyond2_;  ///< mm^2: farther than asked for, since nanoflann rounds the distance of a node, and never 0
  std::span<Neighbour> found_;
  std::size_t count_ = 0;
};

}  // namespace
}  // namespace plumbline::inline slicer

// Nodes come from the arena: the pool itself would take blocks from malloc().
template <>
plumbline::Node<2>* nanoflann::PooledAllocator::allocate<plumbline::Node<2>>(std::size_t /*one*/) {
  return static_cast<plumbline::Node<2>*>(plumbline::TreeRoom::current->node(sizeof(plumbline::Node<2>)));
}
template <>
plumbline::Node<3>* nanoflann::PooledAllocator::allocate<plumbline::Node<3>>(std::size_t /*one*/) {
  return static_cast<plumbline::Node<3>*>(plumbline::TreeRoom::current->node(sizeof(plumbline::Node<3>)));
}

namespace plumbline::inline slicer {
namespace {

/// Builds a tree with several threads: nanoflann divides the points into a few large leaves, and then each thread has it divide one of
/// these after another.
template <int Dimension>
class TreeBuilder {
 public:
  TreeBuilder(Index<Dimension>& index, TreeRoom& room) : index_(index), room_(room) {}

  /// Throws std::bad_alloc if the room is full or the build was cancelled.
  void run() {
    const std::size_t leaf = index_.m_leaf_max_size;
    const std::size_t points = index_.vAcc.size();
    const auto threads = static_cast<std::size_t>(omp_get_max_threads());
    // A team of fewer threads than the others of the job would be taken from the heap.
    const bool shared = threads > 1 && points >= threads * kPointsOfThread;
    if (shared) index_.m_leaf_max_size = points / (kPartsOfThread * threads);
    index_.buildIndex();
    index_.m_leaf_max_size = leaf;
    if (!shared) return;
    find_parts(index_.root_node, index_.root_bbox);
    std::atomic<bool> failed = false;
#pragma omp parallel
    {
      const Building here(room_);
#pragma omp for schedule(dynamic, 1)
      for (std::size_t i = 0; i < count_; ++i) {
        try {
          divide(parts_[i]);
        } catch (const std::bad_alloc&) {
          failed = true;
        }
      }
    }
    if (failed) throw std::bad_alloc();
  }

 private:
  using Box = typename Index<Dimension>::BoundingBox;

  static constexpr std::size_t kPartsOfThread = 4;       ///< at least, so that threads end at about the same time
  static constexpr std::size_t kPointsOfThread = 32768;  ///< a thread for so many points

  struct Part {
    Node<Dimension>* leaf;
    Box box;  ///< around the points, or larger
  };

  /// Lists the large leaves below a node. nanoflann does not keep its cuts, but they are as near to the middle of a box as the points of its
  /// two halves allow.
  void find_parts(Node<Dimension>* node, const Box& box) {
    if (node->child1 == nullptr) {
      if (count_ == parts_.size()) divide(parts_[--count_]);
      parts_[count_++] = {node, box};
      return;
    }
    const auto& sub = node->node_type.sub;
    const auto axis = static_cast<std::size_t>(sub.divfeat);
    const float cut = std::clamp((box[axis].low + box[axis].high) / 2, sub.divlow, sub.divhigh);
    Box half = box;
    half[axis].high = cut;
    find_parts(node->child1, half);
    half = box;
    half[axis].low = cut;
    find_parts(node->child2, half);
  }
  void divide(Part& part) {
    const auto points = part.leaf->node_type.lr;
    *part.leaf = *index_.divideTree(index_, points.left, points.right, part.box);
  }

  Index<Dimension>& index_;
  TreeRoom& room_;
  std::array<Part, 256> parts_;
  std::size_t count_ = 0;
};

/// Walks the leaves that overlap a box, and joins adjacent ones before it passes them to `visit`.
template <int Dimension>
struct Visitor {
  const float* low;
  const float* high;
  FunctionRef<void(std::uint32_t, std::uint32_t)> visit;
  std::uint32_t first = 0, last = 0;

  void leaves(std::size_t from, std::size_t to) {
    if (from != last || last == first) {
      flush();
      first = static_cast<std::uint32_t>(from);
    }
    last = static_cast<std::uint32_t>(to);
  }
  void flush() {
    if (first != last) visit(first, last);
    first = last = 0;
  }
  /// @param open  bits of the box's sides that the node may reach beyond: 2 f and 2 f + 1 for low[f] and high[f]
  void walk(const Node<Dimension>* node, std::uint32_t open) {
    while (node->child1 != nullptr && open != 0) {
      const auto& sub = node->node_type.sub;
      const bool left = low[sub.divfeat] <= sub.divlow;
      const bool right = high[sub.divfeat] >= sub.divhigh;
      if (!left && !right) return;
      if (left && right) {
        walk(node->child1, open & ~(2U << 2 * sub.divfeat));
        open &= ~(1U << 2 * sub.divfeat);
      }
      node = right ? node->child2 : node->child1;
    }
    const Node<Dimension>* end = node;
    while (node->child1 != nullptr) node = node->child1;
    while (end->child2 != nullptr) end = end->child2;
    leaves(node->node_type.lr.left, end->node_type.lr.right);
  }
};

}  // namespace

template <int Dimension>
struct KdTree<Dimension>::Impl {
  explicit Impl(std::span<const Vec3f> points)
      : set{points},
        index(Dimension, set, {kLeafSize, nanoflann::KDTreeSingleIndexAdaptorFlags::SkipInitialBuildIndex}) {}

  std::uint32_t nearest(NearestSet found, const Vec3f& query) const {
    index.findNeighbors(found, query.data(), {});
    return static_cast<std::uint32_t>(found.size());
  }

  PointSet set;
  Index<Dimension> index;
};

template <int Dimension>
Expected<KdTree<Dimension>> KdTree<Dimension>::build(std::span<const Vec3f> points, Arena& arena, const char* stage,
                                                     const StageProgress& progress) {
  using Storage = std::aligned_storage_t<sizeof(Impl), alignof(Impl)>;
  const auto place = arena.take_top<Storage>(1, stage);
  PLUMBLINE_TRY(place);
  const std::size_t left = arena.available();
  constexpr std::size_t kNode = sizeof(Node<Dimension>);
  TreeRoom room(arena, progress, points.size() * (kBytesPerPoint - sizeof(PointIndex)) / kNode + 1);
  KdTree tree;
  try {
    const Building here(room);
    tree.impl_ = new (place->data()) Impl(points);
    tree.impl_->index.init_vind();
    TreeBuilder<Dimension>(tree.impl_->index, room).run();
  } catch (const std::bad_alloc&) {
    if (room.cancelled()) return fail(ErrorCode::kCancelled, "%s: cancelled while building a tree", stage);
    return fail(
        ErrorCode::kOutOfMemory,
        "%s: the %dD tree of %zu points needs more than the %.1f MiB that were left of the arena's %.1f MiB.\tUse a "
        "larger arena or fewer points",
        stage, Dimension, points.size(), mib(left), mib(arena.capacity()));
  }
  PLUMBLINE_TRY(arena.take_top<std::byte>(room.nodes() * kNode, stage));
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
  return impl_->nearest({found, std::numeric_limits<float>::max(), nullptr}, query);
}

template <int Dimension>
std::uint32_t KdTree<Dimension>::nearest(const Vec3f& query, std::span<Neighbour> found,
                                         FunctionRef<bool(std::uint32_t)> accept, float most2) const {
  return impl_->nearest({found, most2, &accept}, query);
}

template <int Dimension>
std::size_t KdTree<Dimension>::within(const Vec3f& query, float most2, std::span<Neighbour> found) const {
  WithinSet set(most2, found);
  impl_->index.findNeighbors(set, query.data(), {});
  return set.count();
}

template <int Dimension>
void KdTree<Dimension>::visit_box(const Vec3f& low, const Vec3f& high,
                                  FunctionRef<void(std::uint32_t, std::uint32_t)> visit) const {
  Visitor<Dimension> visitor{low.data(), high.data(), visit};
  visitor.walk(impl_->index.root_node, (1U << 2 * Dimension) - 1);
  visitor.flush();
}

template class KdTree<2>;
template class KdTree<3>;

}  // namespace plumbline::inline slicer
