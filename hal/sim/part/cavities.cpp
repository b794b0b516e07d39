#include "hal/sim/part/cavities.hpp"

#include <span>
#include <utility>

#include "slicer/core/disjoint_sets.hpp"

namespace plumbline::inline hal::inline sim {

void Cavities::next_layer(const PartRegions& before_layer, const PartRegions& here_layer, bool first,
                          std::uint32_t layer, double pixel_mm3) {
  if (first) cavities_.clear();
  const auto regions = here_layer.black();
  if (cavities_.empty() && regions.size() <= 1) return;

  // Sets of: the outside, the cavities so far, the regions of this layer.
  const auto old = static_cast<std::uint32_t>(cavities_.size());
  const auto count = static_cast<std::uint32_t>(regions.size());
  std::vector<Cavity> all(1 + old + count);
  std::copy(cavities_.begin(), cavities_.end(), all.begin() + 1);
  parents_.resize(all.size());
  DisjointSets sets{std::span(parents_)};
  sets.start_all();
  const auto before = [&](std::uint32_t region) { return region == 0 ? 0 : 1 + of_region_[region]; };
  const auto here = [&](std::uint32_t region) { return region == 0 ? 0 : old + region; };
  for (std::uint32_t i = 1; i < count; ++i) {
    const std::uint32_t pixels = here_layer.runs().area(regions[i]);
    all[here(i)] = {.vented = false,
                    .on_plate = first,
                    .plate_pixels = first ? pixels : 0,
                    .mouth_pixels = pixels,
                    .mm3 = pixels * pixel_mm3};
  }
  if (!first) {
    for_each_contact(before_layer, here_layer, false,
                     [&](std::uint32_t a, std::uint32_t b, std::uint32_t) { sets.unite(before(a), here(b)); });
  }
  sets.flatten(sets.size());

  // The outside vents what it touches: its set is {0, ...}.
  std::vector<Cavity> sums(all.size());
  for (std::uint32_t i = 1; i < all.size(); ++i) {
    Cavity& sum = sums[sets.root(i)];
    sum.vented = sum.vented || all[i].vented || sets.root(i) == 0;
    sum.on_plate = sum.on_plate || all[i].on_plate;
    sum.plate_pixels += all[i].plate_pixels;
    if (i > old) sum.mouth_pixels += all[i].mouth_pixels;
    sum.mm3 += all[i].mm3;
  }
  std::vector<std::uint32_t> cavity_of_root(all.size(), LayerRegions::kNone);
  cavities_.clear();
  of_region_.assign(count, 0);
  for (std::uint32_t i = 1; i < count; ++i) {
    // Regions that meet the outside stay apart from each other: each is vented by itself.
    const std::uint32_t root = sets.root(here(i));
    std::uint32_t& cavity = cavity_of_root[root == 0 ? here(i) : root];
    if (cavity == LayerRegions::kNone) {
      cavity = static_cast<std::uint32_t>(cavities_.size());
      cavities_.push_back(sums[root]);
    }
    of_region_[i] = cavity;
  }
  for (std::uint32_t i = 1; i <= old; ++i) {
    if (sets.root(i) != i || cavity_of_root[i] != LayerRegions::kNone) continue;
    const Cavity& ended = sums[i];
    if (ended.vented || ended.on_plate) continue;
    ++traps_;
    trapped_mm3_ += ended.mm3;
    if (ended.mm3 > largest_.mm3) largest_ = {.layer = layer - 1, .mm3 = ended.mm3};
  }
}

}  // namespace plumbline::inline hal::inline sim
