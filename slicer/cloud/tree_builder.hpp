#pragma once
/// Builds a kd-tree of nanoflann in the arena, with several threads.

#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>

#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Gives the threads that build a tree memory of the arena, and reports the progress, since they ask for blocks all the time.
/// A cancelled build gets no more memory.
class TreeMemory {
 public:
  /// @param expected  bytes of the finished tree
  TreeMemory(Arena& arena, const StageProgress& progress, std::size_t expected)
      : arena_(arena), progress_(progress), before_(arena.top_used()), expected_(expected) {}

  /// Call from any thread.
  /// @returns nothing if the arena is full or the build was cancelled
  void* take(std::size_t bytes) {
    if (stopped_) return nullptr;
    void* taken = nullptr;
    std::size_t sum = 0;
#pragma omp critical(tree_memory)
    {
      const auto block = arena_.take_top<std::byte>(bytes, "kd-tree");
      if (block) taken = block->data();
      sum = arena_.top_used() - before_;
    }
    if (taken == nullptr) stopped_ = true;
    if (omp_get_thread_num() == 0) report(sum);
    return stopped_ ? nullptr : taken;
  }
  bool cancelled() const { return cancelled_; }
  std::size_t taken() const { return arena_.top_used() - before_; }

 private:
  static constexpr std::size_t kStep = 8192;  ///< bytes between two reports

  void report(std::size_t sum) {
    if (sum < next_) return;
    next_ = sum + kStep;
    if (progress_.advance(std::min(1.0, static_cast<double>(sum) / static_cast<double>(expected_)))) return;
    cancelled_ = true;
    stopped_ = true;
  }

  Arena& arena_;
  const StageProgress& progress_;
  std::size_t before_;
  std::size_t expected_;
  std::size_t next_ = 0;  ///< bytes at which the progress is reported next
  bool cancelled_ = false;
  std::atomic<bool> stopped_ = false;
};

/// Builds the nodes that nanoflann would build. It divides the points in place, so the parts of a tree don't share anything:
/// the upper levels are divided one after the other, the parts of a level by all threads, and so are the trees below.
template <class Index>
class TreeBuilder {
 public:
  TreeBuilder(Index& index, TreeMemory& memory) : index_(index), memory_(memory) {}

  /// Fills the index, whose points are known.
  /// @returns false if there was not enough memory
  bool run() {
    index_.init_vind();
    index_.computeBoundingBox(index_.root_bbox);
    const std::size_t points = index_.vAcc.size();
    const auto threads = static_cast<std::size_t>(omp_get_max_threads());
    // A team of fewer threads than the others of the job would be taken from the heap.
    const bool shared = threads > 1 && points >= threads * kPointsOfThread;
    parts_[0] = {nullptr, 0, points, 0, 0, index_.root_bbox, true};
    const std::size_t levels = shared ? kLevels : 0;
    if (shared) {
#pragma omp parallel
      {
        Nodes nodes(memory_);
        for (std::size_t level = 0; level < levels; ++level) {
#pragma omp for schedule(dynamic, 1)
          for (std::size_t i = first_part(level); i < first_part(level + 1); ++i) divide_part(i, nodes);
        }
#pragma omp for schedule(dynamic, 1)
        for (std::size_t i = 0; i < first_part(levels + 1); ++i) build_part(i, nodes);
      }
    } else {
      Nodes nodes(memory_);
      build_part(0, nodes);
    }
    for (std::size_t i = first_part(levels); i-- > 0;) {
      if (!join_part(i)) return false;
    }
    index_.root_node = parts_[0].node;
    index_.root_bbox = parts_[0].box;
    return index_.root_node != nullptr;
  }

 private:
  using Node = typename Index::Node;
  using Box = typename Index::BoundingBox;

  static constexpr std::size_t kLevels = 6;  ///< divided before threads take whole parts: 64 for any number of threads
  /// A thread for so many points. A thread wastes less than a block of nodes, so this is a 32th of a byte a point.
  static constexpr std::size_t kPointsOfThread = 32768;
  static constexpr std::size_t kBlock = 1024;  ///< bytes of nodes that a thread takes at a time

  void build_part(std::size_t i, auto& nodes) {
    Part& part = parts_[i];
    if (part.whole) part.node = build(part.first, part.last, part.box, nodes);
  }

  /// A thread's memory for nodes.
  class Nodes {
   public:
    explicit Nodes(TreeMemory& memory) : memory_(memory) {}
    Node* take() {
      if (left_ == 0) {
        next_ = static_cast<std::byte*>(memory_.take(kBlock));
        if (next_ == nullptr) return nullptr;
        left_ = kBlock / sizeof(Node);
      }
      --left_;
      Node* const node = new (next_) Node;
      next_ += sizeof(Node);
      return node;
    }

   private:
    TreeMemory& memory_;
    std::byte* next_ = nullptr;
    std::size_t left_ = 0;  ///< nodes
  };

  /// A node of the upper levels: those of part i are 2 i + 1 and 2 i + 2.
  struct Part {
    Node* node = nullptr;
    std::size_t first = 0, last = 0;  ///< of the order; equal if there is no such part
    std::size_t middle = 0;
    std::int32_t cut = 0;  ///< dimension
    Box box;               ///< around the points once the node is built; before that, perhaps larger
    bool whole = false;    ///< one thread builds all of it
  };
  static constexpr std::size_t first_part(std::size_t level) { return (std::size_t{1} << level) - 1; }

  bool is_leaf(std::size_t first, std::size_t last) const { return last - first <= index_.m_leaf_max_size; }

  /// Divides the points of a part in two.
  /// @returns where the second half begins
  std::size_t divide(std::size_t first, std::size_t last, std::int32_t& cut, Box& box, Box& left, Box& right) {
    std::size_t size = 0;
    float value = 0;
    index_.middleSplit_(index_, first, last - first, size, cut, value, box);
    left = right = box;
    left[static_cast<std::size_t>(cut)].high = value;
    right[static_cast<std::size_t>(cut)].low = value;
    return first + size;
  }

  static void join(Node& node, std::int32_t cut, Box& box, const Box& left, const Box& right) {
    node.node_type.sub.divfeat = cut;
    node.node_type.sub.divlow = left[static_cast<std::size_t>(cut)].high;
    node.node_type.sub.divhigh = right[static_cast<std::size_t>(cut)].low;
    for (std::size_t axis = 0; axis < box.size(); ++axis) {
      box[axis].low = std::min(left[axis].low, right[axis].low);
      box[axis].high = std::max(left[axis].high, right[axis].high);
    }
  }

  void divide_part(std::size_t i, Nodes& nodes) {
    Part& part = parts_[i];
    if (part.first == part.last || is_leaf(part.first, part.last)) return;
    part.node = nodes.take();
    part.whole = false;
    Part& left = parts_[2 * i + 1];
    Part& right = parts_[2 * i + 2];
    part.middle = divide(part.first, part.last, part.cut, part.box, left.box, right.box);
    left.first = part.first;
    left.last = right.first = part.middle;
    right.last = part.last;
    left.whole = right.whole = true;
  }

  bool join_part(std::size_t i) {
    Part& part = parts_[i];
    if (part.whole || part.first == part.last) return true;
    const Part& left = parts_[2 * i + 1];
    const Part& right = parts_[2 * i + 2];
    if (part.node == nullptr || left.node == nullptr || right.node == nullptr) return false;
    part.node->child1 = left.node;
    part.node->child2 = right.node;
    join(*part.node, part.cut, part.box, left.box, right.box);
    return true;
  }

  /// Sets the box to that of the points.
  /// @returns nothing if there was not enough memory
  Node* build(std::size_t first, std::size_t last, Box& box, Nodes& nodes) {
    Node* const node = nodes.take();
    if (node == nullptr) return nullptr;
    if (is_leaf(first, last)) {
      node->child1 = node->child2 = nullptr;
      node->node_type.lr.left = first;
      node->node_type.lr.right = last;
      for (std::size_t axis = 0; axis < box.size(); ++axis) {
        const auto dimension = static_cast<std::int32_t>(axis);
        index_.computeMinMax(index_, first, last - first, dimension, box[axis].low, box[axis].high);
      }
      return node;
    }
    std::int32_t cut = 0;
    Box left, right;
    const std::size_t middle = divide(first, last, cut, box, left, right);
    node->child1 = build(first, middle, left, nodes);
    if (node->child1 == nullptr) return nullptr;
    node->child2 = build(middle, last, right, nodes);
    if (node->child2 == nullptr) return nullptr;
    join(*node, cut, box, left, right);
    return node;
  }

  Index& index_;
  TreeMemory& memory_;
  std::array<Part, first_part(kLevels + 1)> parts_ = {};
};

}  // namespace plumbline
