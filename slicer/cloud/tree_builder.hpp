#pragma once
/// Builds a kd-tree in the arena, with several threads. nanoflann divides the points. Its nodes take 32 bytes each, and 64-bit
/// pointers most of that: these take 12.

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

/// A node of a kd-tree.
struct TreeNode {
  static constexpr std::uint32_t kLeaf = 3;  ///< in place of an axis

  struct Split {
    float below;  ///< largest coordinate of the left child's points
    float above;  ///< smallest of the right child's
  };
  struct Leaf {
    std::uint32_t first, last;  ///< of the order; one past the end
  };
  union {
    Split split;
    Leaf leaf;
  };
  /// Two bits: the axis of the split, or kLeaf. The others say where the children are, see TreeNodes.
  std::uint32_t link;

  std::uint32_t axis() const { return link & 3U; }
  bool is_leaf() const { return axis() == kLeaf; }
};
static_assert(sizeof(TreeNode) == 12);

/// The nodes of a tree: the root, and below it in memory the others, children in pairs.
class TreeNodes {
 public:
  TreeNode& root() { return root_; }
  const TreeNode& root() const { return root_; }

  const TreeNode& left_of(const TreeNode& parent) const {
    return *reinterpret_cast<const TreeNode*>(start() - (parent.link & ~kAxis));
  }
  const TreeNode& right_of(const TreeNode& parent) const { return *(&left_of(parent) + 1); }
  /// @param pair  two nodes, less than 4 GiB below the root
  std::uint32_t link(std::uint32_t axis, const TreeNode* pair) const {
    const auto below = static_cast<std::size_t>(start() - reinterpret_cast<const std::byte*>(pair));
    return static_cast<std::uint32_t>(below) | axis;
  }

 private:
  static constexpr std::uint32_t kAxis = 3;  ///< bits of a link; nodes lie a multiple of four bytes apart
  static_assert(alignof(TreeNode) > kAxis);
  const std::byte* start() const { return reinterpret_cast<const std::byte*>(&root_); }

  TreeNode root_ = {};
};

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
  TreeBuilder(Index& index, TreeNodes& nodes, TreeMemory& memory) : index_(index), nodes_(nodes), memory_(memory) {}

  /// Orders the index's points and fills the nodes.
  /// @returns false if there was not enough memory
  bool run() {
    index_.init_vind();
    index_.computeBoundingBox(index_.root_bbox);
    const std::size_t points = index_.vAcc.size();
    const auto threads = static_cast<std::size_t>(omp_get_max_threads());
    // A team of fewer threads than the others of the job would be taken from the heap.
    const bool shared = threads > 1 && points >= threads * kPointsOfThread;
    parts_[0] = {&nodes_.root(), 0, points, 0, index_.root_bbox, true};
    const std::size_t levels = shared ? kLevels : 0;
    if (shared) {
#pragma omp parallel
      {
        Pairs pairs(memory_);
        for (std::size_t level = 0; level < levels; ++level) {
#pragma omp for schedule(dynamic, 1)
          for (std::size_t i = first_part(level); i < first_part(level + 1); ++i) divide_part(i, pairs);
        }
#pragma omp for schedule(dynamic, 1)
        for (std::size_t i = 0; i < first_part(levels + 1); ++i) build_part(i, pairs);
      }
    } else {
      Pairs pairs(memory_);
      build_part(0, pairs);
    }
    for (std::size_t i = first_part(levels); i-- > 0;) join_part(i);
    index_.root_bbox = parts_[0].box;
    return !full_;
  }

 private:
  using Box = typename Index::BoundingBox;

  static constexpr std::size_t kLevels = 6;  ///< divided before threads take whole parts: 64 for any number of threads
  /// A thread for so many points. A thread wastes less than a block of nodes, so this is a 21st of a byte a point.
  static constexpr std::size_t kPointsOfThread = 32768;
  static constexpr std::size_t kBlockPairs = 64;  ///< pairs of nodes that a thread takes at a time: whole cache lines

  void build_part(std::size_t i, auto& pairs) {
    Part& part = parts_[i];
    if (part.whole && !build(*part.node, part.first, part.last, part.box, pairs)) full_ = true;
  }

  /// A thread's memory for nodes.
  class Pairs {
   public:
    explicit Pairs(TreeMemory& memory) : memory_(memory) {}
    /// @returns two nodes, or nothing
    TreeNode* take() {
      if (left_ == 0) {
        auto* const block = static_cast<std::byte*>(memory_.take(2 * kBlockPairs * sizeof(TreeNode)));
        if (block == nullptr) return nullptr;
        next_ = new (block) TreeNode[2 * kBlockPairs];
        left_ = kBlockPairs;
      }
      --left_;
      next_ += 2;
      return next_ - 2;
    }

   private:
    TreeMemory& memory_;
    TreeNode* next_ = nullptr;
    std::size_t left_ = 0;
  };

  /// A node of the upper levels: those of part i are 2 i + 1 and 2 i + 2.
  struct Part {
    TreeNode* node = nullptr;
    std::size_t first = 0, last = 0;  ///< of the order; equal if there is no such part
    std::int32_t cut = 0;             ///< dimension
    Box box;                          ///< around the points once the node is built; before that, perhaps larger
    bool whole = false;               ///< one thread builds all of it
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

  /// @param children  two nodes
  void join(TreeNode& node, std::int32_t cut, Box& box, const TreeNode* children, const Box& left, const Box& right) {
    const auto axis = static_cast<std::uint32_t>(cut);
    node.split = {left[axis].high, right[axis].low};
    node.link = nodes_.link(axis, children);
    for (std::size_t a = 0; a < box.size(); ++a) {
      box[a].low = std::min(left[a].low, right[a].low);
      box[a].high = std::max(left[a].high, right[a].high);
    }
  }

  void divide_part(std::size_t i, Pairs& pairs) {
    Part& part = parts_[i];
    if (part.first == part.last || is_leaf(part.first, part.last)) return;
    TreeNode* const children = pairs.take();
    part.whole = false;
    if (children == nullptr) {
      full_ = true;
      return;
    }
    Part& left = parts_[2 * i + 1];
    Part& right = parts_[2 * i + 2];
    const std::size_t middle = divide(part.first, part.last, part.cut, part.box, left.box, right.box);
    left.node = children;
    right.node = children + 1;
    left.first = part.first;
    left.last = right.first = middle;
    right.last = part.last;
    left.whole = right.whole = true;
  }

  void join_part(std::size_t i) {
    Part& part = parts_[i];
    const Part& left = parts_[2 * i + 1];
    if (part.whole || left.node == nullptr) return;
    join(*part.node, part.cut, part.box, left.node, left.box, parts_[2 * i + 2].box);
  }

  /// Sets the box to that of the points.
  /// @returns false if there was not enough memory
  bool build(TreeNode& node, std::size_t first, std::size_t last, Box& box, Pairs& pairs) {
    if (is_leaf(first, last)) {
      node.leaf = {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last)};
      node.link = TreeNode::kLeaf;
      for (std::size_t axis = 0; axis < box.size(); ++axis) {
        const auto dimension = static_cast<std::int32_t>(axis);
        index_.computeMinMax(index_, first, last - first, dimension, box[axis].low, box[axis].high);
      }
      return true;
    }
    std::int32_t cut = 0;
    Box left, right;
    const std::size_t middle = divide(first, last, cut, box, left, right);
    TreeNode* const children = pairs.take();
    if (children == nullptr || !build(children[0], first, middle, left, pairs) ||
        !build(children[1], middle, last, right, pairs)) {
      return false;
    }
    join(node, cut, box, children, left, right);
    return true;
  }

  Index& index_;
  TreeNodes& nodes_;
  TreeMemory& memory_;
  std::atomic<bool> full_ = false;
  std::array<Part, first_part(kLevels + 1)> parts_ = {};
};

}  // namespace plumbline
