#include "slicer/checks/region_columns.hpp"

#include <algorithm>
#include <utility>

namespace plumbline::inline slicer {

void RegionColumn::add(const RegionColumn& other) {
  first_layer = std::min(first_layer, other.first_layer);
  last_layer = std::max(last_layer, other.last_layer);
  voxels += other.voxels;
  // Of equal ones the lower layer's, so that the order of unions does not matter.
  if (!torn && (other.largest > largest || (other.largest == largest && other.largest_layer < largest_layer))) {
    largest = other.largest;
    largest_layer = other.largest_layer;
    column = other.column;
    row = other.row;
  }
  broad_first = std::min(broad_first, other.broad_first);
  broad_last = std::max(broad_last, other.broad_last);
  on_plate |= other.on_plate;
  drains |= other.drains;
  alive |= other.alive;
}

Expected<RegionColumns> RegionColumns::create(std::uint32_t most, Arena& arena) {
  RegionColumns columns;
  for (auto* nodes : {&columns.nodes_, &columns.next_}) {
    auto taken = arena.take_top<RegionColumn>(std::size_t{2} * most, "checks");
    PLUMBLINE_TRY(taken);
    *nodes = *taken;
  }
  columns.clear();
  return columns;
}

void RegionColumns::begin_layer() {
  std::swap(nodes_, next_);
  nodes_[0] = RegionColumn{};
  nodes_[0].drains = true;
  count_ = kept_;
  std::copy_n(nodes_.begin(), count_, next_.begin());
}

void RegionColumns::clear() {
  kept_ = 1;
  begin_layer();
}

}  // namespace plumbline::inline slicer
