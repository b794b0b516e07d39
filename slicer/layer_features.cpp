#include "slicer/layer_features.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "slicer/layer_regions.hpp"
#include "slicer/layer_stream.hpp"
#include "slicer/rrep_edit.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "layer features";

/// Of what the arena has left, for the features; the rest is for their voxels.
constexpr std::size_t kShareOfArena = 4;
constexpr std::size_t kMostRuns = std::size_t{1} << 20;

/// The small regions of consecutive layers that touch; one node a region, joined as a disjoint set.
struct Feature {
  std::uint32_t parent;
  bool white;
  bool continued;  ///< above or below it, a region is nothing but its continuation
  std::uint64_t voxels;
};

/// Pixels of a feature that differ from what they shall be.
struct FeatureRun {
  std::uint32_t feature;
  std::uint32_t layer;
  std::uint32_t row;
  std::uint16_t first, last;
};

/// What a region touches in the next layer on one side.
struct Contact {
  std::uint32_t region = LayerRegions::kNone;
  bool more = false;  ///< than one region
  void note(std::uint32_t other) {
    if (region == LayerRegions::kNone) {
      region = other;
    } else if (region != other) {
      more = true;
    }
  }
};

/// Calls use(a, b) for every pair of runs of one colour that share a column in the same row of both layers.
template <class Use>
void for_each_contact(const LayerRegions& below, const LayerRegions& above, Use use) {
  for (std::uint32_t r = 0; r < below.rows(); ++r) {
    std::uint32_t a = below.row_begin(r);
    std::uint32_t b = above.row_begin(r);
    const std::uint32_t a_end = below.row_begin(r + 1);
    const std::uint32_t b_end = above.row_begin(r + 1);
    while (a < a_end && b < b_end) {
      const LayerRegions::Run ra = below.run(a);
      const LayerRegions::Run rb = above.run(b);
      const bool overlap = ra.first <= rb.last && rb.first <= ra.last && ra.first <= ra.last && rb.first <= rb.last;
      if (overlap && below.white(r, a) == above.white(r, b)) use(below.region(a), above.region(b));
      // An empty run stands only at the start of a row.
      (rb.first > rb.last || (ra.first <= ra.last && rb.last <= ra.last)) ? ++b : ++a;
    }
  }
}

/// One layer with what is known of its regions.
struct Layer {
  LayerRegions regions;
  std::span<std::uint32_t> feature;  ///< by region, kNone: not small
  std::span<Contact> contact;        ///< by region, with the layer it is compared with
  std::uint32_t small = 0;           ///< regions
};

class Sweep {
 public:
  static Expected<Sweep> create(const RRep& rrep, const FeatureLimits& limits, Arena& arena);

  /// Stops where the room does not suffice for all layers; what ends before that is complete.
  void run();
  Expected<FeatureCounts> edit(RRep& rrep, Arena& arena);

 private:
  std::uint32_t root(std::uint32_t f) {
    while (features_[f].parent != f) f = features_[f].parent = features_[features_[f].parent].parent;
    return f;
  }
  void unite(std::uint32_t a, std::uint32_t b);
  bool find_small(std::uint32_t layer, Layer& now, ConstBitImage section);
  bool record(std::uint32_t layer, const Layer& now, ConstBitImage section);
  void connect(Layer& below, Layer& above);
  bool removable(std::uint32_t f) const {
    const Feature& feature = features_[f];
    return !feature.continued && feature.voxels <= limits_.voxels;
  }

  const RRep* rrep_ = nullptr;
  FeatureLimits limits_;
  LayerStream stream_;
  std::array<Layer, 2> layers_;
  std::span<Feature> features_;
  std::span<FeatureRun> runs_;
  std::uint32_t feature_count_ = 0;
  std::uint32_t run_count_ = 0;
};

Expected<Sweep> Sweep::create(const RRep& rrep, const FeatureLimits& limits, Arena& arena) {
  Sweep sweep;
  sweep.rrep_ = &rrep;
  sweep.limits_ = limits;
  auto stream = LayerStream::create(rrep, arena);
  if (!stream) return tl::unexpected<Error>(stream.error());
  sweep.stream_ = *stream;
  for (Layer& layer : sweep.layers_) {
    auto regions = LayerRegions::create(rrep.grid.columns, rrep.grid.rows, arena);
    if (!regions) return tl::unexpected<Error>(regions.error());
    layer.regions = *regions;
    const std::size_t most = std::size_t{rrep.grid.rows} * LayerRegions::kRunsPerRow + 1;
    auto feature = arena.take_top<std::uint32_t>(most, kStage);
    if (!feature) return tl::unexpected<Error>(feature.error());
    layer.feature = *feature;
    auto contact = arena.take_top<Contact>(most, kStage);
    if (!contact) return tl::unexpected<Error>(contact.error());
    layer.contact = *contact;
  }
  const std::size_t count =
      std::min(kMostRuns, arena.available() / kShareOfArena / (sizeof(Feature) + sizeof(FeatureRun)));
  auto features = arena.take_top<Feature>(count, kStage);
  if (!features) return tl::unexpected<Error>(features.error());
  auto runs = arena.take_top<FeatureRun>(count, kStage);
  if (!runs) return tl::unexpected<Error>(runs.error());
  sweep.features_ = *features;
  sweep.runs_ = *runs;
  return sweep;
}

void Sweep::unite(std::uint32_t a, std::uint32_t b) {
  a = root(a);
  b = root(b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  features_[b].parent = a;
  features_[a].voxels += features_[b].voxels;
  features_[a].continued |= features_[b].continued;
}

bool Sweep::find_small(std::uint32_t layer, Layer& now, ConstBitImage section) {
  const LayerRegions& regions = now.regions;
  now.small = 0;
  for (std::uint32_t r = 0; r < regions.rows(); ++r) {
    for (std::uint32_t i = regions.row_begin(r); i < regions.row_begin(r + 1); ++i) {
      if (regions.region(i) != i) continue;
      now.feature[i] = LayerRegions::kNone;
      if (regions.area(i) == 0 || regions.area(i) > limits_.pixels) continue;
      if (feature_count_ == features_.size()) return false;
      now.feature[i] = feature_count_;
      features_[feature_count_] = {feature_count_, regions.white(r, i), false, regions.area(i)};
      ++feature_count_;
      ++now.small;
    }
  }
  now.feature[LayerRegions::kOutside] = LayerRegions::kNone;
  return now.small == 0 || record(layer, now, section);
}

bool Sweep::record(std::uint32_t layer, const Layer& now, ConstBitImage section) {
  const LayerRegions& regions = now.regions;
  for (std::uint32_t r = 0; r < regions.rows(); ++r) {
    for (std::uint32_t i = regions.row_begin(r); i < regions.row_begin(r + 1); ++i) {
      const std::uint32_t feature = now.feature[regions.region(i)];
      const LayerRegions::Run run = regions.run(i);
      if (feature == LayerRegions::kNone || run.first > run.last) continue;
      // Opening and closing have changed some of its pixels; only those that the section has so too are to be toggled.
      for (std::uint32_t c = run.first; c <= run.last; ++c) {
        if (section.at(c, r) != regions.white(r, i)) continue;
        if (run_count_ == runs_.size()) return false;
        const auto first = static_cast<std::uint16_t>(c);
        while (c < run.last && section.at(c + 1, r) == regions.white(r, i)) ++c;
        runs_[run_count_++] = {feature, layer, r, first, static_cast<std::uint16_t>(c)};
      }
    }
  }
  return true;
}

void Sweep::connect(Layer& below, Layer& above) {
  for (Layer* layer : {&below, &above}) std::fill_n(layer->contact.begin(), layer->regions.run_count(), Contact{});
  for_each_contact(below.regions, above.regions, [&](std::uint32_t a, std::uint32_t b) {
    below.contact[a].note(b);
    above.contact[b].note(a);
  });
  const auto continues = [&](std::uint32_t small, const Contact& large) {
    if (!large.more) features_[root(small)].continued = true;
  };
  for_each_contact(below.regions, above.regions, [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t low = below.feature[a];
    const std::uint32_t high = above.feature[b];
    if (low != LayerRegions::kNone && high != LayerRegions::kNone) {
      unite(low, high);
    } else if (low != LayerRegions::kNone) {
      continues(low, above.contact[b]);
    } else if (high != LayerRegions::kNone) {
      continues(high, below.contact[a]);
    }
  });
}

void Sweep::run() {
  for (std::uint32_t k = 0; k < rrep_->grid.layers; ++k) {
    Layer& below = layers_[(k + 1) % 2];
    Layer& now = layers_[k % 2];
    const ConstBitImage mask = stream_.mask(k);
    if (!now.regions.label(mask) || !find_small(k, now, stream_.section())) {
      // Who goes on into the layers that are not looked at must stay.
      for (Feature& feature : features_.first(feature_count_)) features_[root(feature.parent)].continued = true;
      return;
    }
    if (k > 0 && below.small + now.small > 0) connect(below, now);
  }
}

Expected<FeatureCounts> Sweep::edit(RRep& rrep, Arena& arena) {
  FeatureCounts counts;
  counts.counted = true;
  for (std::uint32_t f = 0; f < feature_count_; ++f) {
    if (features_[f].parent != f || !removable(f)) continue;
    ++(features_[f].white ? counts.islands : counts.holes);
    counts.voxels += features_[f].voxels;
  }
  std::size_t toggles = 0;
  for (const FeatureRun& run : runs_.first(run_count_)) {
    if (removable(root(run.feature))) toggles += 2 * (std::size_t{1} + run.last - run.first);
  }
  auto block = arena.take_top<RRepToggle>(toggles, kStage);
  if (!block) return tl::unexpected<Error>(block.error());
  std::size_t at = 0;
  for (const FeatureRun& run : runs_.first(run_count_)) {
    if (!removable(root(run.feature))) continue;
    for (std::uint32_t c = run.first; c <= run.last; ++c) {
      const std::uint32_t pixel = run.row * rrep.grid.columns + c;
      (*block)[at++] = {run.layer, pixel};
      (*block)[at++] = {run.layer + 1, pixel};
    }
  }
  if (auto done = toggle_crossings(rrep, *block, arena); !done) return tl::unexpected<Error>(done.error());
  return counts;
}

}  // namespace

Expected<FeatureCounts> drop_small_features(RRep& rrep, const FeatureLimits& limits, Arena& arena) {
  const ArenaScope scope(arena);
  // The stream of layers stands on the crossings, which need its room when they are edited.
  const std::size_t bottom = arena.bottom_mark();
  auto sweep = Sweep::create(rrep, limits, arena);
  if (sweep) sweep->run();
  arena.release_bottom(bottom);
  return sweep ? sweep->edit(rrep, arena) : FeatureCounts{};
}

}  // namespace plumbline
