#include "slicer/layers/bleed.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/layers/adaptive_layers.hpp"
#include "slicer/layers/floating_edges.hpp"
#include "slicer/rrep/mask_extent.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "bleed";
constexpr std::uint32_t kOutside = 0xFFFFFFFFU;
constexpr std::uint32_t kMostShift = 255;  ///< layers; of the thinnest, 5 um, more than 1 mm

/// The layers of the print that are lit on a ray. All heights are in layers of the R-Rep, above its first.
class LitLayers {
 public:
  /// @param lifted  layers of the R-Rep that the print has below its first
  LitLayers(const CureDepths& depths, double layer_height_mm, std::uint32_t lifted)
      : depths_(depths), layer_height_(layer_height_mm), lifted_(lifted) {}

  /// The layer of the print at a height.
  std::uint32_t at(double height) const {
    return depths_.steps().layer_at(static_cast<std::uint32_t>(std::max(0.0, std::floor(height))) + lifted_);
  }
  double bottom(std::uint32_t lit) const {
    return static_cast<double>(depths_.steps().of(lit).first) - static_cast<double>(lifted_);
  }
  /// Layers of the print below the first that is no longer lit. @param exit  of the ray
  std::uint32_t end(std::uint32_t exit) const { return depths_.steps().layers(exit + lifted_); }
  /// Where the light cures down to if the layers from `lit` to `end` - 1 are lit.
  double front(std::uint32_t lit, std::uint32_t end) const {
    const LayerStep layer = depths_.steps().of(lit);
    return static_cast<double>(layer.end()) - static_cast<double>(lifted_) -
           depths_.below_film_mm(lit, end - lit) / layer_height_;
  }
  /// Where the underside of a thick part is that is lit from `lit` on, so that light cures down to `height`.
  double below_thick(std::uint32_t lit, double height) const {
    return height + depths_.below_film_mm(lit, CureDepths::kThick) / layer_height_ - depths_.steps().of(lit).step;
  }

  /// Layers of the print between two heights. @param above  may be below `height`: less than 0
  double between(double height, double above) const {
    if (depths_.steps().all_one()) return std::floor(above - height + 0.5);
    return static_cast<double>(at(above)) - static_cast<double>(at(height));
  }

 private:
  const CureDepths& depths_;
  double layer_height_;
  std::uint32_t lifted_;
};

/// A stretch of a ray inside the object, in layers of the R-Rep.
struct Stretch {
  std::uint32_t entering = 0;
  double height = 0;        ///< at which the ray enters
  std::uint32_t exit = 0;   ///< the first layer above
  std::uint32_t limit = 0;  ///< the highest layer at which it may begin; below `exit`
};

/// Finds how far the entering crossings are raised.
class Raiser {
 public:
  Raiser(const RRep& rrep, const CureModel& model, std::uint32_t lifted, const LayerSteps& steps)
      : layer_height_(static_cast<double>(rrep.grid.layer_height_mm)),
        depths_(model, layer_height_, steps),
        lit_(depths_, layer_height_, lifted),
        lifted_(lifted) {
    counts_.model = model;
  }
  Raiser(const Raiser&) = delete;
  Raiser& operator=(const Raiser&) = delete;

  struct Raised {
    CrossingHeight height;   ///< at a layer from stretch.entering to stretch.limit
    std::uint32_t less = 0;  ///< layers of the print that it would go up in addition below a thick part
  };
  Raised raised(const Stretch& stretch) {
    const CrossingHeight found = height_at(raised_height(stretch), stretch);
    const double end = found.layer() - 0.5 + found.part() / static_cast<double>(CrossingHeight::kParts);
    const double by = (end - stretch.height) * layer_height_;
    if (by > layer_height_ / CrossingHeight::kParts) {
      ++counts_.moved;
      counts_.mean_mm += by;
      counts_.most_mm = std::max(counts_.most_mm, by);
      counts_.pixels += found.layer() - stretch.entering;
    }
    // Below a thick part it is raised by what is cured below the lowest layer.
    const double thick = lit_.below_thick(lit_.at(found.layer()), stretch.height);
    const double layers = stretch.entering == 0 && lifted_ == 0 ? 0 : lit_.between(end, thick);
    return {found, static_cast<std::uint32_t>(std::clamp(layers, 0.0, static_cast<double>(most_less())))};
  }

  /// The highest layer up to `layer` whose mask is printed.
  std::uint32_t highest_sampled(std::uint32_t layer) const {
    const LayerSteps& steps = depths_.steps();
    if (steps.all_one()) return layer;
    const std::uint32_t layers = steps.layers(layer + lifted_ + 1);
    const std::uint32_t sampled = layers > 0 ? steps.of(layers - 1).sampled() : 0;
    return sampled > lifted_ ? sampled - lifted_ : 0;
  }
  std::uint32_t most_less() const { return depths_.steps().all_one() ? kMostLess : kMostLessThin; }
  BleedCounts counts() const {
    BleedCounts all = counts_;
    if (all.moved > 0) all.mean_mm /= static_cast<double>(all.moved);
    return all;
  }

 private:
  /// Where the ray is to enter for its front to meet the surface, in layers; the exit or more if it can't.
  double raised_height(const Stretch& stretch) const {
    const double height = stretch.height;
    if (stretch.entering == 0 && lifted_ == 0) return height;
    // The fronts if the lowest lit layer is `lit` and if it is the next one.
    const std::uint32_t end = lit_.end(stretch.exit);
    std::uint32_t lit = lit_.at(height);
    if (lit + 1 >= end) return stretch.exit;
    double front = lit_.front(lit, end);
    if (front > height) return height;
    for (; lit + 1 < end; ++lit) {
      const double next = lit_.front(lit + 1, end);
      if (next > height) {
        const double bottom = lit_.bottom(lit), step = lit_.bottom(lit + 1) - bottom;
        return std::max(height, bottom + (height - front) / (next - front) * step);
      }
      front = next;
    }
    return stretch.exit;
  }
  static CrossingHeight height_at(double height, const Stretch& stretch) {
    const double above = height - 0.5;
    const double layer = std::ceil(above);
    if (layer > stretch.limit) return CrossingHeight(stretch.limit);
    if (layer < stretch.entering) return CrossingHeight(stretch.entering, 0);
    const double part = (above - layer + 1) * CrossingHeight::kParts;
    return CrossingHeight(static_cast<std::uint32_t>(layer),
                          static_cast<std::uint32_t>(std::clamp(part, 0.0, CrossingHeight::kParts - 1.0)));
  }

  double layer_height_;
  CureDepths depths_;
  LitLayers lit_;
  std::uint32_t lifted_;
  BleedCounts counts_;
};

/// Where a ray has entered the object.
struct Entered {
  std::uint32_t crossing = kOutside;
  std::uint32_t limit = 0;  ///< the highest layer in which it and each ray beside it that overlaps are both inside
};

/// Pairs the crossings of a strip of rows, and raises those that enter.
class StripRaiser {
 public:
  /// @param shifts  layers by which each crossing goes up
  StripRaiser(RRep& rrep, const MaskExtent& extent, std::span<std::uint8_t> shifts, std::span<Entered> inside)
      : rrep_(rrep), packing_(rrep.grid), extent_(extent), shifts_(shifts), inside_(inside) {
    packed_ = const_cast<std::uint32_t*>(rrep.packed.data());
    width_ = extent.right - extent.left;
  }

  /// @param row, rows  a row on each side is looked at, too: inside_ has room for these
  void raise(std::uint32_t row, std::uint32_t rows, Raiser& raiser) {
    top_ = std::max(row, extent_.top + 1) - 1;
    const std::uint32_t end = std::min(row + rows + 1, extent_.bottom);
    strip_ = inside_.first(std::size_t{end - top_} * width_);
    std::ranges::fill(strip_, Entered{});
    const PrintGrid& grid = rrep_.grid;
    for (std::uint32_t k = 0; k < grid.layers; ++k) {
      const auto layer = rrep_.packed.subspan(rrep_.first[k], rrep_.first[k + 1] - rrep_.first[k]);
      for (auto at = std::ranges::lower_bound(layer, packing_.packed(top_ * grid.columns, 0)); at != layer.end();
           ++at) {
        const std::uint32_t pixel = packing_.pixel(*at);
        const std::uint32_t r = pixel / grid.columns, column = pixel % grid.columns - extent_.left;
        if (r >= end) break;
        const std::size_t place = std::size_t{r - top_} * width_ + column;
        if (strip_[place].crossing == kOutside) {
          strip_[place] = {static_cast<std::uint32_t>(at - layer.begin()) + rrep_.first[k], grid.layers};
          continue;
        }
        if (r >= row && r < row + rows) raise_one(strip_[place], k, raiser);
        strip_[place].crossing = kOutside;
        limit_beside(place, column, k);
      }
    }
    for (std::size_t place = (row - top_) * width_; place < std::size_t{std::min(row + rows, end) - top_} * width_;
         ++place) {
      if (strip_[place].crossing != kOutside) raise_one(strip_[place], grid.layers, raiser);
    }
  }

 private:
  void raise_one(const Entered& entered, std::uint32_t exit, Raiser& raiser) {
    const auto layer =
        static_cast<std::uint32_t>(std::ranges::upper_bound(rrep_.first, entered.crossing) - rrep_.first.begin()) - 1;
    std::uint32_t& packed = packed_[entered.crossing];
    const double height = static_cast<double>(packing_.height_mm(packed, layer, rrep_.grid)) /
                          static_cast<double>(rrep_.grid.layer_height_mm);
    const std::uint32_t limit =
        std::max(layer, raiser.highest_sampled(std::min({entered.limit, exit - 1, layer + kMostShift})));
    const Raiser::Raised found = raiser.raised({layer, height, exit, limit});
    packed = marked_less(packing_.packed(packing_.pixel(packed), found.height.part()), found.less, raiser.most_less());
    shifts_[entered.crossing] = static_cast<std::uint8_t>(found.height.layer() - layer);
  }
  /// Of rays that are inside beside one that exits: both are inside in the layer below its exit.
  void limit_beside(std::size_t place, std::uint32_t column, std::uint32_t exit) {
    const auto limit = [&](std::size_t other) {
      Entered& entered = strip_[other];
      if (entered.crossing < rrep_.first[exit]) entered.limit = std::min(entered.limit, exit - 1);
    };
    if (column > 0) limit(place - 1);
    if (column + 1 < width_) limit(place + 1);
    if (place >= width_) limit(place - width_);
    if (place + width_ < strip_.size()) limit(place + width_);
  }

  const RRep& rrep_;
  CrossingPacking packing_;
  MaskExtent extent_;
  std::uint32_t* packed_;
  std::span<std::uint8_t> shifts_;
  std::span<Entered> inside_;
  std::uint32_t width_ = 0;  ///< of a row of strip_
  std::uint32_t top_ = 0;    ///< the row of its first
  std::span<Entered> strip_;
};

/// Moves each crossing up by its shift, in place.
/// @param places  two entries for each layer
void sort_again(RRep& rrep, std::span<const std::uint8_t> shifts, std::span<std::uint32_t> places) {
  const std::uint32_t layers = rrep.grid.layers;
  const auto next = places.first(layers), end = places.subspan(layers, layers);
  const auto layer_of = [&](std::uint32_t place) {
    const auto above = std::ranges::upper_bound(rrep.first, place) - rrep.first.begin();
    return static_cast<std::uint32_t>(above) - 1 + shifts[place];
  };
  std::ranges::fill(end, 0);
  for (std::uint32_t k = 0; k < layers; ++k) {
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) ++end[k + shifts[i]];
  }
  for (std::uint32_t k = 0, sum = 0; k < layers; ++k) {
    next[k] = sum;
    sum = end[k] += sum;
  }
  // Each crossing goes to the next free place of its layer, and the one that was there on to its own (McIlroy et al. 1993).
  std::uint32_t* const packed = const_cast<std::uint32_t*>(rrep.packed.data());
  for (std::uint32_t k = 0; k < layers; ++k) {
    while (next[k] < end[k]) {
      std::uint32_t crossing = packed[next[k]];
      for (std::uint32_t layer = layer_of(next[k]); layer != k;) {
        const std::uint32_t place = next[layer]++;
        std::swap(crossing, packed[place]);
        layer = layer_of(place);
      }
      packed[next[k]++] = crossing;
    }
  }
  std::uint32_t* const first = const_cast<std::uint32_t*>(rrep.first.data());
  for (std::uint32_t k = 0; k < layers; ++k) {
    first[k + 1] = end[k];
    std::sort(packed + first[k], packed + first[k + 1]);
  }
}

}  // namespace

double uncorrected_mm(const CureDepths& depths, const PrintGrid& grid, double height_mm, std::uint32_t layer,
                      std::uint32_t exit) {
  const auto layer_height = static_cast<double>(grid.layer_height_mm);
  const double height = height_mm / layer_height;
  const LitLayers layers(depths, layer_height, 0);
  const std::uint32_t lit = layers.at(height);
  if (layer == 0 || lit + 2 > exit) return height_mm;
  const double front = layers.front(lit, exit);
  return (front + (height - lit) * (layers.front(lit + 1, exit) - front)) * layer_height;
}

std::size_t bleed_bytes(const PrintGrid& grid, std::size_t crossings) {
  return std::max(Arena::rounded(crossings) + Arena::rounded(3 * std::size_t{grid.columns} * sizeof(Entered)) +
                      Arena::rounded(2 * std::size_t{grid.layers} * sizeof(std::uint32_t)),
                  floating_edges_bytes(grid));
}

Expected<BleedCounts> correct_bleed(RRep& rrep, const CureModel& model, std::uint32_t lifted, Arena& arena,
                                    const LayerSteps& steps) {
  Raiser raiser(rrep, model, lifted, steps);
  if (rrep.crossings() == 0) return raiser.counts();
  {
    // Once crossings are moved, nothing may fail any more.
    const ArenaScope scope(arena);
    PLUMBLINE_TRY(arena.take_top<std::byte>(bleed_bytes(rrep.grid, rrep.crossings()), kStage));
  }
  {
    const ArenaScope scope(arena);
    const auto shifts = arena.take_top<std::uint8_t>(rrep.crossings(), kStage);
    PLUMBLINE_TRY(shifts);
    const auto places = arena.take_top<std::uint32_t>(2 * std::size_t{rrep.grid.layers}, kStage);
    PLUMBLINE_TRY(places);
    const MaskExtent extent = extent_of(rrep);
    const std::size_t columns = extent.right - extent.left;
    const auto fitting = static_cast<std::uint32_t>(
        std::min<std::size_t>(arena.available() / 2 / sizeof(Entered) / columns, extent.bottom - extent.top + 2));
    const std::uint32_t rows = std::max(fitting, 3U) - 2;
    const auto inside = arena.take_top<Entered>((rows + 2) * columns, kStage);
    PLUMBLINE_TRY(inside);
    std::ranges::fill(*shifts, 0);
    StripRaiser strips(rrep, extent, *shifts, *inside);
    for (std::uint32_t row = extent.top; row < extent.bottom; row += rows) strips.raise(row, rows, raiser);
    sort_again(rrep, *shifts, *places);
  }
  const bool adaptive = !steps.all_one();
  const PrintLayers counted = adaptive ? count_print_layers(rrep, steps, lifted) : PrintLayers();
  const auto taken = drop_floating_edges(rrep, raiser.most_less(), arena);
  PLUMBLINE_TRY(taken);
  if (adaptive) count_rrep_layers(rrep, counted, steps, lifted);
  BleedCounts counts = raiser.counts();
  counts.pixels += *taken;
  return counts;
}

}  // namespace plumbline::inline slicer
