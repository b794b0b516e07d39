#include "slicer/kd_tree.hpp"

// nanoflann has no allocator hook: its pool calls ::malloc and ::free, its index is a std::vector. This is the one file
// that includes it. Every header that nanoflann needs comes first; then malloc and free are redirected around that include
// alone, and std::allocator is specialised, as the standard allows, for an index type of our own.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
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

namespace plumbline {
namespace {

/// The arena that nanoflann's memory comes from: set while a tree is built, in the thread that builds it.
thread_local Arena* building_in = nullptr;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

void* arena_bytes(std::size_t bytes) {
  if (building_in == nullptr) return nullptr;
  auto block = building_in->take_top<std::byte>(bytes, "kd-tree");
  return block ? static_cast<void*>(block->data()) : nullptr;
}

class BuildingIn {
 public:
  explicit BuildingIn(Arena& arena) { building_in = &arena; }
  ~BuildingIn() { building_in = nullptr; }
  BuildingIn(const BuildingIn&) = delete;
  BuildingIn& operator=(const BuildingIn&) = delete;
};

/// A point's index, as a type of ours.
struct PointIndex {
  std::uint32_t value = 0;
  PointIndex() = default;
  template <class Integer>
  requires std::is_integral_v<Integer> PointIndex(Integer v)
      : value(static_cast<std::uint32_t>(v)) {}     // NOLINT(google-explicit-constructor): nanoflann's use
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
void* plumbline_nanoflann_malloc(std::size_t bytes) { return plumbline::arena_bytes(bytes); }
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

/// nanoflann's result set for the k nearest that are accepted, in the caller's buffer; equal distances by index, so that
/// the result does not depend on the order of the leaves.
class NearestSet {
 public:
  using DistanceType = float;
  NearestSet(std::span<Neighbour> found, const FunctionRef<bool(std::uint32_t)>* accept)
      : found_(found), accept_(accept) {}
  std::size_t size() const { return count_; }
  bool full() const { return count_ == found_.size(); }
  float worstDist() const {  // NOLINT(readability-identifier-naming): nanoflann's name
    // The next float up: a point at exactly the worst distance with a smaller index must still be seen.
    return full() ? std::nextafter(found_[count_ - 1].distance2, std::numeric_limits<float>::infinity())
                  : std::numeric_limits<float>::max();
  }
  bool addPoint(float distance2, PointIndex index) {  // NOLINT(readability-identifier-naming): nanoflann's name
    if (accept_ != nullptr && !(*accept_)(index.value)) return true;
    const auto before = [&](const Neighbour& other) {
      return distance2 < other.distance2 || (distance2 == other.distance2 && index.value < other.index);
    };
    if (full() && !before(found_[count_ - 1])) return true;
    std::size_t at = full() ? count_ - 1 : count_++;
    for (; at > 0 && before(found_[at - 1]); --at) found_[at] = found_[at - 1];
    found_[at] = {index.value, distance2};
    return true;
  }

 private:
  std::span<Neighbour> found_;
  const FunctionRef<bool(std::uint32_t)>* accept_;
  std::size_t count_ = 0;
};

}  // namespace

template <int Dimension>
struct KdTree<Dimension>::Impl {
  using Metric = nanoflann::L2_Simple_Adaptor<float, PointSet, float, PointIndex>;
  using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, PointSet, Dimension, PointIndex>;
  using Node = typename Index::Node;

  explicit Impl(std::span<const Vec3f> points)
      : set{points}, index(Dimension, set, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

  /// Joins adjacent leaves before it passes them on.
  struct Visitor {
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
    void walk(const Node* node) {
      while (node->child1 != nullptr) {
        const auto& split = node->node_type.sub;
        const bool left = low[split.divfeat] <= split.divlow;
        const bool right = high[split.divfeat] >= split.divhigh;
        if (left && right) walk(node->child1);
        if (!right) {
          if (!left) return;
          node = node->child1;
        } else {
          node = node->child2;
        }
      }
      leaf(static_cast<std::uint32_t>(node->node_type.lr.left), static_cast<std::uint32_t>(node->node_type.lr.right));
    }
  };

  PointSet set;
  Index index;
};

template <int Dimension>
Expected<KdTree<Dimension>> KdTree<Dimension>::build(std::span<const Vec3f> points, Arena& arena, const char* stage) {
  using Storage = std::aligned_storage_t<sizeof(Impl), alignof(Impl)>;
  auto place = arena.take_top<Storage>(1, stage);
  if (!place) return tl::unexpected<Error>(place.error());
  const std::size_t before = arena.top_used();
  const BuildingIn here(arena);
  KdTree tree;
  try {
    tree.impl_ = new (place->data()) Impl(points);
  } catch (const std::bad_alloc&) {
    constexpr double kMiB = 1024.0 * 1024.0;
    return fail(
        ErrorCode::kOutOfMemory,
        "%s: the %dD tree of %zu points has taken %.1f MiB and needs more; the arena has %.1f MiB. Use a larger "
        "arena or fewer points",
        stage, Dimension, points.size(), static_cast<double>(arena.top_used() - before) / kMiB,
        static_cast<double>(arena.capacity()) / kMiB);
  }
  return tree;
}

template <int Dimension>
std::span<const std::uint32_t> KdTree<Dimension>::order() const {
  const auto& index = impl_->index.vAcc;
  return {reinterpret_cast<const std::uint32_t*>(index.data()), index.size()};
}

template <int Dimension>
void KdTree<Dimension>::adopt_order() {
  auto& index = impl_->index.vAcc;
  for (std::uint32_t i = 0; i < index.size(); ++i) index[i] = PointIndex(i);
}

template <int Dimension>
std::uint32_t KdTree<Dimension>::nearest(const Vec3f& query, std::span<Neighbour> found) const {
  NearestSet set(found, nullptr);
  impl_->index.findNeighbors(set, query.data(), nanoflann::SearchParams());
  return static_cast<std::uint32_t>(set.size());
}

template <int Dimension>
std::uint32_t KdTree<Dimension>::nearest(const Vec3f& query, std::span<Neighbour> found,
                                         FunctionRef<bool(std::uint32_t)> accept) const {
  NearestSet set(found, &accept);
  impl_->index.findNeighbors(set, query.data(), nanoflann::SearchParams());
  return static_cast<std::uint32_t>(set.size());
}

template <int Dimension>
void KdTree<Dimension>::visit_box(const Vec3f& low, const Vec3f& high,
                                  FunctionRef<void(std::uint32_t, std::uint32_t)> visit) const {
  if (impl_->index.root_node == nullptr) return;
  typename Impl::Visitor visitor{low.data(), high.data(), visit};
  visitor.walk(impl_->index.root_node);
  visitor.flush();
}

template class KdTree<2>;
template class KdTree<3>;

}  // namespace plumbline
