#include "slicer/layers/layer_features.hpp"

#include <algorithm>
#include <utility>

#include "slicer/core/disjoint_sets.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/layers/rrep_edit.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "layer features";

/// Room for the small regions of all layers and for their runs, per row of the grid. The suite's and raw scans need up to 2.1
/// and 18.1.
constexpr std::size_t kRegionsPerRow = 16;
constexpr std::size_t kRunsPerRow = 128;
/// Toggles in one batch, per row of the grid. They reuse the memory of the two layers.
constexpr std::size_t kTogglesPerRow = 256;

/// Small regions of consecutive layers that touch, as a disjoint set with a node for each region.
struct Feature {
  std::uint32_t parent;
  bool white : 1;
  bool continued : 1;         ///< a larger region above or below touches only this feature
  bool below : 1;             ///< it touches a larger region below, or is a hole in the first layer
  bool above : 1;             ///< the same above, or a hole in the last layer
  bool bears : 1;             ///< a larger region touches only small regions on this side
  std::uint16_t first, last;  ///< layers, `last` included
  std::uint32_t largest;      ///< pixels of its largest region
  std::uint64_t voxels;
};

/// A run of pixels to toggle if the feature is removed.
struct FeatureRun {
  std::uint32_t feature;
  std::uint32_t layer;
  std::uint32_t row;
  std::uint16_t first, last;
};

/// What a region touches in the layer above or below.
struct FeatureContact {
  std::uint32_t region = LayerRegions::kNone;
  bool more = false;   ///< more than one region
  bool large = false;  ///< at least one that is not small
  void note(std::uint32_t other) {
    if (region == LayerRegions::kNone) {
      region = other;
    } else if (region != other) {
      more = true;
    }
  }
};

/// The regions of one layer.
struct Layer {
  static std::size_t most_regions(std::uint32_t rows) { return LayerRegions::most_runs(rows, {}); }
  static std::size_t bytes_needed(std::uint32_t rows) {
    return LayerRegions::bytes_needed(rows) + Arena::rounded(most_regions(rows) * sizeof(std::uint32_t)) +
           Arena::rounded(most_regions(rows) * sizeof(FeatureContact));
  }
  static Expected<Layer> create(const PrintGrid& grid, Arena& arena);

  LayerRegions regions;
  std::span<std::uint32_t> feature;   ///< by region; kNone: not small
  std::span<FeatureContact> contact;  ///< by region, with the layer that it is compared with
  std::uint32_t small = 0;            ///< regions
};

Expected<Layer> Layer::create(const PrintGrid& grid, Arena& arena) {
  const auto regions = LayerRegions::create(grid.columns, grid.rows, arena);
  PLUMBLINE_TRY(regions);
  Layer layer{*regions, {}, {}, 0};
  PLUMBLINE_TRY(arena.take_top(layer.feature, most_regions(grid.rows), kStage));
  PLUMBLINE_TRY(arena.take_top(layer.contact, most_regions(grid.rows), kStage));
  return layer;
}

class Sweep {
 public:
  static Expected<Sweep> create(const RRep& rrep, const FeatureLimits& limits, Arena& arena);

  /// Finds the features. Stops where the room ends; features that end below that are complete.
  /// @retval ErrorCode::kOutOfMemory  no room for two layers; nothing was looked at
  Status run(Arena& arena);
  /// Removes the features that run() has found from `rrep`.
  Expected<FeatureCounts> edit(RRep& rrep, Arena& arena);

 private:
  DisjointSets<Feature, &Feature::parent> sets() const { return DisjointSets<Feature, &Feature::parent>(features_); }
  std::uint32_t root(std::uint32_t f) const { return sets().root(f); }
  void unite(std::uint32_t low, std::uint32_t high);
  bool find_small(std::uint32_t layer, Layer& now, ConstBitImage section);
  bool start_feature(std::uint32_t layer, bool white, std::uint32_t area);
  bool record(const FeatureRun& run, bool white, ConstBitImage section);
  void connect(Layer& below, Layer& above);
  bool removable(std::uint32_t f) const {
    const Feature& feature = features_[f];
    if (feature.continued || (feature.white && feature.below && feature.above && feature.bears)) return false;
    // If no layer has a larger island, the object consists of small ones.
    const bool loose = !feature.below && !feature.above && (has_large_island_ || !feature.white);
    if (loose && feature.voxels <= limits_.loose_voxels) return true;
    const bool narrow = feature.largest <= limits_.narrow_pixels;
    const std::uint32_t layers = narrow ? limits_.narrow_layers : limits_.flat_layers;
    return feature.voxels <= limits_.voxels && feature.last - feature.first + 1U <= layers;
  }

  const RRep* rrep_ = nullptr;
  FeatureLimits limits_;
  std::span<Feature> features_;
  std::span<FeatureRun> runs_;
  std::uint32_t feature_count_ = 0;
  std::uint32_t run_count_ = 0;
  LayerTotals totals_;
  bool stopped_ = false;  ///< before the last layer, for want of room
  bool has_large_island_ = false;
};

Expected<Sweep> Sweep::create(const RRep& rrep, const FeatureLimits& limits, Arena& arena) {
  Sweep sweep;
  sweep.rrep_ = &rrep;
  sweep.limits_ = limits;
  PLUMBLINE_TRY(arena.take_top(sweep.features_, rrep.grid.rows * kRegionsPerRow, kStage));
  PLUMBLINE_TRY(arena.take_top(sweep.runs_, rrep.grid.rows * kRunsPerRow, kStage));
  return sweep;
}

void Sweep::unite(std::uint32_t low, std::uint32_t high) {
  const auto [a, b] = sets().unite(low, high);
  if (a == b) return;
  features_[a].voxels += features_[b].voxels;
  features_[a].continued |= features_[b].continued;
  features_[a].below |= features_[b].below;
  features_[a].above |= features_[b].above;
  features_[a].bears |= features_[b].bears;
  features_[a].first = std::min(features_[a].first, features_[b].first);
  features_[a].last = std::max(features_[a].last, features_[b].last);
  features_[a].largest = std::max(features_[a].largest, features_[b].largest);
}

bool Sweep::find_small(std::uint32_t layer, Layer& now, ConstBitImage section) {
  const LayerRegions& regions = now.regions;
  now.small = 0;
  now.feature[LayerRegions::kOutside] = LayerRegions::kNone;
  std::uint64_t white_pixels = 0;
  for (std::uint32_t r = 0; r < regions.rows(); ++r) {
    for (std::uint32_t i = regions.row_begin(r); i < regions.row_begin(r + 1); ++i) {
      const std::uint32_t region = regions.region(i);
      const bool white = regions.white(r, i);
      if (region == i) {  // its first run
        const std::uint32_t area = regions.area(i);
        const bool small = area > 0 && area <= limits_.pixels;
        if (white) white_pixels += area;
        has_large_island_ |= white && area > limits_.pixels;
        now.feature[i] = small ? feature_count_ : LayerRegions::kNone;
        if (small && !start_feature(layer, white, area)) return false;
        now.small += small ? 1 : 0;
      }
      if (now.feature[region] == LayerRegions::kNone) continue;
      if (!record({now.feature[region], layer, r, regions.run(i).first, regions.run(i).last}, white, section))
        return false;
    }
  }
  totals_.add(white_pixels);
  return true;
}

bool Sweep::start_feature(std::uint32_t layer, bool white, std::uint32_t area) {
  if (feature_count_ == features_.size()) return false;
  Feature& feature = features_[feature_count_];
  feature = {};
  feature.parent = feature_count_++;
  feature.white = white;
  feature.below = !white && layer == 0;
  feature.above = !white && layer + 1 == rrep_->grid.layers;
  feature.first = feature.last = static_cast<std::uint16_t>(layer);
  feature.largest = area;
  feature.voxels = area;
  return true;
}

/// Opening and closing have changed some pixels of the region. Only those that the section agrees with are to be toggled.
bool Sweep::record(const FeatureRun& run, bool white, ConstBitImage section) {
  for (std::uint32_t c = run.first; c <= run.last; ++c) {
    if (section.at(c, run.row) != white) continue;
    if (run_count_ == runs_.size()) return false;
    FeatureRun& part = runs_[run_count_++] = run;
    part.first = static_cast<std::uint16_t>(c);
    while (c < run.last && section.at(c + 1, run.row) == white) ++c;
    part.last = static_cast<std::uint16_t>(c);
  }
  return true;
}

void Sweep::connect(Layer& below, Layer& above) {
  for (Layer* layer : {&below, &above})
    std::fill_n(layer->contact.begin(), layer->regions.run_count(), FeatureContact{});
  for_each_contact(below.regions, above.regions, [&](const RegionContact& contact) {
    const auto [a, b] = std::pair(contact.below, contact.above);
    below.contact[a].note(b);
    above.contact[b].note(a);
    below.contact[a].large |= above.feature[b] == LayerRegions::kNone;
    above.contact[b].large |= below.feature[a] == LayerRegions::kNone;
  });
  const auto note_large = [](Feature& small, const FeatureContact& large) {
    small.continued |= !large.more;
    small.bears |= !large.large;
  };
  for_each_contact(below.regions, above.regions, [&](const RegionContact& contact) {
    const auto [a, b] = std::pair(contact.below, contact.above);
    const std::uint32_t low = below.feature[a];
    const std::uint32_t high = above.feature[b];
    if (low != LayerRegions::kNone && high != LayerRegions::kNone) {
      unite(low, high);
    } else if (low != LayerRegions::kNone) {
      features_[root(low)].above = true;
      note_large(features_[root(low)], above.contact[b]);
    } else if (high != LayerRegions::kNone) {
      features_[root(high)].below = true;
      note_large(features_[root(high)], below.contact[a]);
    }
  });
}

Status Sweep::run(Arena& arena) {
  // The layers are released at the end: edit() needs their memory.
  const ArenaScope scope(arena);
  const std::size_t bottom = arena.bottom_mark();
  auto stream = LayerStream::create(*rrep_, arena);
  auto even = stream ? Layer::create(rrep_->grid, arena) : tl::unexpected<Error>(stream.error());
  auto odd = even ? Layer::create(rrep_->grid, arena) : even;
  std::uint32_t first_of_now = 0;  // first feature of the layer
  for (std::uint32_t k = 0; odd && k < rrep_->grid.layers; ++k) {
    Layer& below = k % 2 == 0 ? *odd : *even;
    Layer& now = k % 2 == 0 ? *even : *odd;
    const std::uint32_t first_of_below = std::exchange(first_of_now, feature_count_);
    const ConstBitImage mask = stream->mask(k);
    if (!now.regions.label(mask) || !find_small(k, now, stream->section())) {
      // A feature that may continue into the layers not looked at must stay.
      for (std::uint32_t f = first_of_below; f < feature_count_; ++f) features_[root(f)].continued = true;
      stopped_ = true;
      break;
    }
    if (k > 0 && below.small + now.small > 0) connect(below, now);
  }
  arena.release_bottom(bottom);
  if (!odd) return tl::unexpected<Error>(odd.error());
  return {};
}

Expected<FeatureCounts> Sweep::edit(RRep& rrep, Arena& arena) {
  FeatureCounts counts;
  counts.counted = true;
  for (std::uint32_t f = 0; f < feature_count_; ++f) {
    if (!sets().is_root(f) || !removable(f)) continue;
    ++(features_[f].white ? counts.islands : counts.holes);
    counts.voxels += features_[f].voxels;
  }
  if (counts.voxels == 0 && !stopped_) counts.totals = totals_;
  auto block = arena.take_top<RRepToggle>(rrep.grid.rows * kTogglesPerRow, kStage);
  if (!block) return tl::unexpected<Error>(block.error());
  std::size_t toggles = 0;
  const auto flush = [&] { return toggle_crossings(rrep, block->first(std::exchange(toggles, 0)), arena); };
  for (const FeatureRun& run : runs_.first(run_count_)) {
    if (!removable(root(run.feature))) continue;
    for (std::uint32_t c = run.first; c <= run.last; ++c) {
      if (toggles + 2 > block->size()) PLUMBLINE_TRY(flush());
      const std::uint32_t pixel = run.row * rrep.grid.columns + c;
      (*block)[toggles++] = {run.layer, pixel};
      (*block)[toggles++] = {run.layer + 1, pixel};
    }
  }
  PLUMBLINE_TRY(flush());
  return counts;
}

}  // namespace

std::size_t layer_features_bytes(const PrintGrid& grid) {
  const std::size_t rows = grid.rows;
  const std::size_t found =
      Arena::rounded(rows * kRegionsPerRow * sizeof(Feature)) + Arena::rounded(rows * kRunsPerRow * sizeof(FeatureRun));
  const std::size_t looking = LayerStream::bytes_needed(grid) + 2 * Layer::bytes_needed(grid.rows);
  // A toggle may add a crossing that a later one removes.
  const std::size_t editing = Arena::rounded(rows * kTogglesPerRow * sizeof(RRepToggle)) +
                              Arena::rounded(rows * kTogglesPerRow * sizeof(std::uint32_t));
  return found + std::max(looking, editing);
}

Expected<FeatureCounts> drop_small_features(RRep& rrep, const FeatureLimits& limits, Arena& arena) {
  const ArenaScope scope(arena);
  auto sweep = Sweep::create(rrep, limits, arena);
  if (!sweep || !sweep->run(arena)) return FeatureCounts{};
  return sweep->edit(rrep, arena);
}

}  // namespace plumbline::inline slicer
