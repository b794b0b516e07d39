#include "slicer/dose/bleed.hpp"

#include <algorithm>

#include "slicer/dose/adaptive_layers.hpp"
#include "slicer/dose/floating_edges.hpp"
#include "slicer/rrep/mask_extent.hpp"
#include "slicer/rrep/row_walk.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "bleed";
constexpr std::uint16_t kOutside = PrintGrid::kMaxLayers;  ///< no layer
constexpr std::uint32_t kMostShift = 255;                  ///< layers; of the thinnest, 5 um, more than 1 mm

/// The layers of the print that are lit on a ray. All heights are in layers of the R-Rep, above its first.
class LitLayers {
 public:
  /// @param lifted  layers of the R-Rep that the print has below its first
  LitLayers(const CureDepths& depths, double layer_height_mm, std::uint32_t lifted)
      : depths_(depths), layer_height_(layer_height_mm), lifted_(lifted) {}

  /// The layer of the print at a height.
  std::uint32_t at(double height) const {
    return depths_.steps().layer_at(static_cast<std::uint32_t>(std::max(0.0, height)) + lifted_);
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

  /// Layers of the print between two heights, to be rounded down. @param above  may be below `height`: less than 0
  double between(double height, double above) const {
    if (depths_.steps().all_one()) return above - height + 0.5;
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
    const double layers = lit_.between(end, thick);
    return {found, static_cast<std::uint32_t>(std::clamp(layers, 0.0, static_cast<double>(most_less())))};
  }

  /// Whether crossings of a layer stay: the object stands on the plate with it.
  bool is_on_plate(std::uint32_t layer) const { return layer == 0 && lifted_ == 0; }
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
    const auto below = static_cast<std::int32_t>(above);
    const std::int32_t layer = above > below ? below + 1 : below;  // as std::ceil(), in fewer instructions
    if (layer > static_cast<std::int32_t>(stretch.limit)) return CrossingHeight(stretch.limit);
    if (layer < static_cast<std::int32_t>(stretch.entering)) return CrossingHeight(stretch.entering, 0);
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
  std::uint32_t crossing = 0;
  std::uint16_t layer = kOutside;  ///< of the crossing
  std::uint16_t limit = 0;         ///< the first layer in which it or a ray beside it that overlaps is no longer inside
};

/// Pairs the crossings of a strip of rows, and raises those that enter.
class StripRaiser {
 public:
  /// @param layers  those to which the crossings go, modulo 256
  StripRaiser(RRep& rrep, const MaskExtent& extent, std::span<std::uint8_t> layers, std::span<Entered> inside)
      : rrep_(rrep), packing_(rrep.grid), extent_(extent), layers_(layers), inside_(inside) {
    packed_ = const_cast<std::uint32_t*>(rrep.packed.data());
    width_ = extent.right - extent.left;
    for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
      std::ranges::fill(layers.subspan(rrep.first[k], rrep.first[k + 1] - rrep.first[k]), static_cast<std::uint8_t>(k));
    }
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
      const auto start = std::ranges::lower_bound(layer, packing_.packed(top_ * grid.columns, 0)) - layer.begin();
      RowWalk walk(grid.columns, top_);
      for (std::uint32_t i = rrep_.first[k] + static_cast<std::uint32_t>(start); i < rrep_.first[k + 1]; ++i) {
        walk.go_to(packing_.pixel(rrep_.packed[i]));
        const std::uint32_t r = walk.row(), column = walk.column() - extent_.left;
        if (r >= end) break;
        const std::size_t place = std::size_t{r - top_} * width_ + column;
        Entered& entered = strip_[place];
        if (entered.layer == kOutside) {
          entered = {i, static_cast<std::uint16_t>(k), kOutside};
          continue;
        }
        if (r - row < rows) raise_one(entered, k, raiser);
        entered.layer = kOutside;
        limit_beside(place, column, k);
      }
    }
    for (const Entered& entered : strip_.subspan((row - top_) * width_, (std::min(row + rows, end) - row) * width_)) {
      if (entered.layer != kOutside) raise_one(entered, grid.layers, raiser);
    }
  }

 private:
  void raise_one(const Entered& entered, std::uint32_t exit, Raiser& raiser) {
    const std::uint32_t layer = entered.layer;
    std::uint32_t& packed = packed_[entered.crossing];
    if (raiser.is_on_plate(layer)) {
      packed = marked_less(packed, 0, raiser.most_less());
      return;
    }
    const double height = static_cast<double>(packing_.height_mm(packed, layer, rrep_.grid)) /
                          static_cast<double>(rrep_.grid.layer_height_mm);
    const std::uint32_t limit = std::min(std::min<std::uint32_t>(entered.limit, exit) - 1, layer + kMostShift);
    const Raiser::Raised found = raiser.raised({layer, height, exit, std::max(layer, raiser.highest_sampled(limit))});
    packed = marked_less(packing_.packed(packing_.pixel(packed), found.height.part()), found.less, raiser.most_less());
    layers_[entered.crossing] = static_cast<std::uint8_t>(found.height.layer());
  }
  /// Of rays that are inside beside one that exits: both are inside in the layer below its exit.
  void limit_beside(std::size_t place, std::uint32_t column, std::uint32_t exit) {
    const auto limit = [&](std::size_t other) {
      Entered& entered = strip_[other];
      if (entered.layer < exit) entered.limit = std::min(entered.limit, static_cast<std::uint16_t>(exit));
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
  std::span<std::uint8_t> layers_;
  std::span<Entered> inside_;
  std::uint32_t width_ = 0;  ///< of a row of strip_
  std::uint32_t top_ = 0;    ///< the row of its first
  std::span<Entered> strip_;
};

/// Moves each crossing up to its layer, in place.
/// @param layers  those to which the crossings go, modulo 256: none goes further than kMostShift
/// @param room    for crossings; layers to which more move are slower to sort
void sort_again(RRep& rrep, std::span<std::uint8_t> layers, std::span<std::uint32_t> room) {
  std::uint32_t* const packed = const_cast<std::uint32_t*>(rrep.packed.data());
  std::uint32_t* const first = const_cast<std::uint32_t*>(rrep.first.data());
  // Those that go further up wait between what is written and what is not yet read.
  std::uint32_t written = 0, read = 0;
  for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) {
    const auto take = [&](std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t i = begin; i < end; ++i) {
        if (layers[i] != static_cast<std::uint8_t>(k)) continue;
        layers[i] = layers[written];
        std::swap(packed[i], packed[written++]);
      }
    };
    const std::uint32_t begin = written, end = first[k + 1];
    take(begin, read);
    const std::span moved(packed + begin, packed + written);
    take(read, end);
    read = end;
    first[k + 1] = written;
    if (moved.size() > room.size()) {
      std::sort(packed + begin, packed + written);
      continue;
    }
    std::ranges::sort(moved);
    std::ranges::copy(moved, room.begin());
    std::uint32_t own = begin + static_cast<std::uint32_t>(moved.size()), to = begin;
    for (const std::uint32_t crossing : room.first(moved.size())) {
      while (own < written && packed[own] < crossing) packed[to++] = packed[own++];
      packed[to++] = crossing;
    }
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
  return std::max(Arena::rounded(crossings) + Arena::rounded(3 * std::size_t{grid.columns} * sizeof(Entered)),
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
    const auto layers = arena.take_top<std::uint8_t>(rrep.crossings(), kStage);
    PLUMBLINE_TRY(layers);
    const MaskExtent extent = extent_of(rrep);
    const std::size_t columns = extent.right - extent.left;
    const auto fitting = static_cast<std::uint32_t>(
        std::min<std::size_t>(arena.available() / 2 / sizeof(Entered) / columns, extent.bottom - extent.top + 2));
    const std::uint32_t rows = std::max(fitting, 3U) - 2;
    const std::size_t places = (rows + 2) * columns;
    {
      const ArenaScope strip_scope(arena);
      const auto inside = arena.take_top<Entered>(places, kStage);
      PLUMBLINE_TRY(inside);
      StripRaiser strips(rrep, extent, *layers, *inside);
      for (std::uint32_t row = extent.top; row < extent.bottom; row += rows) strips.raise(row, rows, raiser);
    }
    const auto room = arena.take_top<std::uint32_t>(places, kStage);
    PLUMBLINE_TRY(room);
    sort_again(rrep, *layers, *room);
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
