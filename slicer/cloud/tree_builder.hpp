#pragma once
/// Builds a kd-tree in the arena, with several threads. nanoflann divides the points. Its nodes take 32 bytes each, and 64-bit
/// pointers most of that: these take 8.

#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/progress.hpp"

namespace plumbline {

/// A node of a kd-tree.
struct TreeNode {
  static constexpr std::uint32_t kLeaf = 3;  ///< in place of an axis

  union {
    float cut;            ///< coordinate that no point of the left child is above, and none of the right one below
    std::uint32_t first;  ///< of a leaf: its first point in the order
  };
  /// Two bits: the axis of the cut, or kLeaf. The others say where the children are, see TreeNodes, or how many points a leaf has.
  std::uint32_t link;

  std::uint32_t axis() const { return link & 3U; }
  bool is_leaf() const { return axis() == kLeaf; }
  std::uint32_t last() const { return first + (link >> 2U); }  ///< one past a leaf's points
};
static_assert(sizeof(TreeNode) == 8);

/// The nodes of a tree, in pairs of children that threads take from the upper end of an arena's free room downwards. The root is alone in
/// the first pair.
class TreeNodes {
 public:
  TreeNodes() = default;
  explicit TreeNodes(std::span<std::byte> room)
      : end_(room.data() + room.size()), most_(static_cast<std::uint32_t>(room.size() / kPairBytes)) {}

  const TreeNode& root() const { return *pair(0); }
  const TreeNode* children_of(const TreeNode& parent) const {
    return reinterpret_cast<const TreeNode*>(end_ - (parent.link & ~TreeNode::kLeaf));
  }
  TreeNode* pair(std::uint32_t number) const {
    return reinterpret_cast<TreeNode*>(end_ - (std::size_t{number} + 1) * kPairBytes);
  }
  std::uint32_t link(std::uint32_t axis, std::uint32_t number) const { return (number + 1) * kPairBytes | axis; }
  std::uint32_t most() const { return most_; }  ///< pairs that there is room for

  static constexpr std::uint32_t kPairBytes = 2 * sizeof(TreeNode);

 private:
  std::byte* end_ = nullptr;
  std::uint32_t most_ = 0;
};

/// Builds the nodes that nanoflann would build. It divides the points in place, so the parts of a tree don't share anything: the upper
/// levels are divided one after the other, the parts of a level by all threads, and so are the trees below.
template <class Index>
class TreeBuilder {
 public:
  /// @param expected  pairs of nodes, for the progress
  TreeBuilder(Index& index, const TreeNodes& nodes, const StageProgress& progress, std::size_t expected)
      : index_(index), nodes_(nodes), progress_(progress), expected_(expected) {}

  /// Orders the index's points and fills the nodes.
  /// @returns pairs of nodes; 0 if there was not enough memory, or the build was cancelled
  std::uint32_t run() {
    index_.computeBoundingBox(index_.root_bbox);
    const std::size_t points = index_.vAcc.size();
    const auto threads = static_cast<std::size_t>(omp_get_max_threads());
    if (take_pair() == kNone) return 0;
    parts_[1] = {nodes_.pair(0), 0, points, index_.root_bbox};
    // A team of fewer threads than the others of the job would be taken from the heap.
    if (threads > 1 && points >= threads * kPointsOfThread) {
#pragma omp parallel
      {
        for (std::size_t level = 1; level < kParts; level *= 2) {
#pragma omp for schedule(dynamic, 1)
          for (std::size_t i = level; i < 2 * level; ++i) divide(parts_[i], parts_[2 * i], parts_[2 * i + 1]);
        }
#pragma omp for schedule(dynamic, 1)
        for (std::size_t i = kParts; i < 2 * kParts; ++i) build(parts_[i]);
      }
    } else {
      build(parts_[1]);
    }
    return stopped_ ? 0 : taken_.load();
  }
  bool cancelled() const { return cancelled_; }

 private:
  using Box = typename Index::BoundingBox;

  static constexpr std::size_t kParts = 64;              ///< that threads take as a whole, for any number of threads
  static constexpr std::size_t kPointsOfThread = 32768;  ///< a thread for so many points
  static constexpr std::uint32_t kReportedPairs = 512;   ///< between two reports
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  /// Points that a node is made for. The upper levels are a heap: the children of part i are 2 i and 2 i + 1.
  struct Part {
    TreeNode* node = nullptr;         ///< none: there is no such part
    std::size_t first = 0, last = 0;  ///< of the order
    Box box;                          ///< around the points, or larger
  };

  /// @returns number of a pair, or kNone
  std::uint32_t take_pair() {
    const std::uint32_t number = taken_.fetch_add(1, std::memory_order_relaxed);
    if (number % kReportedPairs == 0 && omp_get_thread_num() == 0 &&
        !progress_.advance(std::min(1.0, static_cast<double>(number) / static_cast<double>(expected_)))) {
      cancelled_ = true;
      stopped_ = true;
    }
    if (number >= nodes_.most()) stopped_ = true;
    return stopped_ ? kNone : number;
  }

  /// Makes the node of a part, and divides its points in two if they are more than a leaf's.
  /// @returns whether there are two halves
  bool divide(const Part& part, Part& left, Part& right) {
    if (part.node == nullptr) return false;
    const std::size_t count = part.last - part.first;
    if (count <= index_.m_leaf_max_size) {
      part.node->first = static_cast<std::uint32_t>(part.first);
      part.node->link = static_cast<std::uint32_t>(count) << 2U | TreeNode::kLeaf;
      return false;
    }
    std::size_t size = 0;
    std::int32_t axis = 0;
    float cut = 0;
    index_.middleSplit_(index_, part.first, count, size, axis, cut, part.box);
    const std::uint32_t pair = take_pair();
    if (pair == kNone) return false;
    part.node->cut = cut;
    part.node->link = nodes_.link(static_cast<std::uint32_t>(axis), pair);
    left = {nodes_.pair(pair), part.first, part.first + size, part.box};
    right = {nodes_.pair(pair) + 1, part.first + size, part.last, part.box};
    left.box[static_cast<std::size_t>(axis)].high = cut;
    right.box[static_cast<std::size_t>(axis)].low = cut;
    return true;
  }
  void build(const Part& part) {
    Part left, right;
    if (!divide(part, left, right)) return;
    build(left);
    build(right);
  }

  Index& index_;
  const TreeNodes& nodes_;
  const StageProgress& progress_;
  std::size_t expected_;
  std::atomic<std::uint32_t> taken_ = 0;  ///< pairs, by all threads
  std::atomic<bool> stopped_ = false;
  bool cancelled_ = false;
  std::array<Part, 2 * kParts> parts_ = {};
};

}  // namespace plumbline
