#pragma once
/// The winding number of a surface, from its clustered points.

#include "slicer/implicit/column_winding.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

class WindingField {
 public:
  explicit WindingField(const Surface& surface)
      : arena_(surface.size() * 140 + kMiB), scan_(clustered(surface, *arena_)) {
    auto nodes = value_of(arena_->take_top<WindingTree::Node>(WindingTree::nodes_needed(scan_.cloud.size), "test"));
    tree_ = WindingTree::build(scan_.cloud, nodes);
  }
  const WindingTree& operator*() const { return tree_; }
  WindingTree* operator->() { return &tree_; }
  /// For rays up to `side` mm away from (x, y).
  ColumnWinding column(float x, float y, float side) {
    ColumnWinding column = value_of(ColumnWinding::create(tree_, *arena_));
    column.begin({x - side, y - side}, {x + side, y + side});
    return column;
  }
  double at(const Vec3d& x) const { return tree_(x.cast<float>()); }
  const ClusteredScan& scan() const { return scan_; }

 private:
  ArenaBlock arena_;
  ClusteredScan scan_;
  WindingTree tree_;
};

}  // namespace plumbline::testing
