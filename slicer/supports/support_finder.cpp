#include "slicer/supports/support_finder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>

#include "slicer/layers/layer_stream.hpp"
#include "slicer/supports/held_area.hpp"
#include "slicer/supports/islands.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "supports";

/// Where to put the tip for the first pixel, in reading order, that needs one: in later rows or to the side, so that the tip
/// holds pixels all around it. Offsets and shares are in 64ths of the reach; the fallback is the pixel itself.
struct Offset {
  std::int32_t columns, rows;
};
constexpr std::array<Offset, 4> kDirections = {{{45, 45}, {-45, 45}, {0, 60}, {60, 0}}};
constexpr std::array<std::int32_t, 5> kShares = {64, 48, 32, 16, 8};

/// The sweep; each method is one step.
class Sweep {
 public:
  Sweep(const RRep& rrep, const SupportSettings& settings)
      : grid_(rrep.grid), window_(window_of(rrep)), shape_(settings, rrep.grid) {}

  Status take_memory(const SupportSettings& settings, Arena& arena) {
    auto list = arena.take_top<Support>(most_supports(grid_), kStage);
    PLUMBLINE_TRY(list);
    list_ = *list;
    auto top = arena.take_top<std::uint16_t>(std::size_t{window_.rows()} * window_.columns(), kStage);
    PLUMBLINE_TRY(top);
    top_ = *top;
    std::fill(top_.begin(), top_.end(), std::uint16_t{0});
    for (BitImage* image : {&below_, &fresh_}) {
      auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid_.columns, grid_.rows), kStage);
      PLUMBLINE_TRY(words);
      *image = BitImage(*words, grid_.columns, grid_.rows);
      image->clear();
    }
    auto held = HeldArea::create(grid_, settings, window_, arena);
    PLUMBLINE_TRY(held);
    held_ = *held;
    auto islands = IslandFinder::create(grid_.columns, arena);
    PLUMBLINE_TRY(islands);
    islands_ = *islands;
    return {};
  }

  Status layer(std::uint32_t layer, ConstBitImage mask) {
    if (layer == 0) {
      held_.begin(mask);
    } else if (compare_with_below(layer, mask)) {
      held_.next_layer(layer, mask);
      PLUMBLINE_TRY(hold_islands(layer, mask));
      PLUMBLINE_TRY(hold_overhangs(layer, mask));
    } else {
      held_.next_layer(layer, mask);
    }
    keep_as_below(layer, mask);
    return {};
  }

  /// The supports in the order that the painter needs.
  std::span<const Support> sorted() {
    const auto found = list_.first(count_);
    std::sort(found.begin(), found.end(), [](const Support& a, const Support& b) {
      return std::tie(a.first, a.tip, a.row, a.column) < std::tie(b.first, b.tip, b.row, b.column);
    });
    return found;
  }
  const SupportCounts& counts() const { return counts_; }
  const SupportShape& shape() const { return shape_; }

 private:
  std::uint16_t& top(std::uint32_t column, std::uint32_t row) {
    return top_[std::size_t{row - window_.row} * window_.columns() + column - window_.word * 64];
  }

  /// Finds new pixels, and notes where the object ends.
  /// @returns whether there are new pixels
  bool compare_with_below(std::uint32_t layer, ConstBitImage mask) {
    bool any = false;
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      const auto line = mask.row(r);
      const auto below = below_.row(r);
      const auto fresh = fresh_.row(r);
      for (std::uint32_t w = window_.word; w < window_.word_end; ++w) {
        fresh[w] = line[w] & ~below[w];
        any |= fresh[w] != 0;
        for (std::uint64_t gone = below[w] & ~line[w]; gone != 0; gone &= gone - 1) {
          top(w * 64 + static_cast<std::uint32_t>(std::countr_zero(gone)), r) = static_cast<std::uint16_t>(layer);
        }
      }
    }
    return any;
  }

  Status hold_islands(std::uint32_t layer, ConstBitImage mask) {
    Status done;
    const auto hold = [&](const IslandFinder::Place& place) {
      if (done) done = add_tip(place.column, place.row, layer, mask);
      ++counts_.islands;
    };
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      islands_.next_row(mask, below_, fresh_, r, window_, hold);
    }
    islands_.end(hold);
    return done;
  }

  Status hold_overhangs(std::uint32_t layer, ConstBitImage mask) {
    held_.drop_what_is_near(fresh_);
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      const auto line = fresh_.row(r);
      for (std::uint32_t w = window_.word; w < window_.word_end; ++w) {
        while (line[w] != 0) {
          const auto place = place_for(w * 64 + static_cast<std::uint32_t>(std::countr_zero(line[w])), r);
          PLUMBLINE_TRY(add_tip(place.column, place.row, layer, mask));
          ++counts_.overhangs;
          clear_disc(place);
        }
      }
    }
    return {};
  }

  /// Place for the tip that holds (column, row) and as many pixels beside it as possible.
  IslandFinder::Place place_for(std::uint32_t column, std::uint32_t row) const {
    const auto reach_x = static_cast<std::int64_t>(held_.reach() / shape_.pitch().x);
    const auto reach_y = static_cast<std::int64_t>(held_.reach() / shape_.pitch().y);
    for (const std::int32_t share : kShares) {
      for (const Offset& offset : kDirections) {
        const std::int64_t c = column + reach_x * offset.columns * share / 4096;
        const std::int64_t r = row + reach_y * offset.rows * share / 4096;
        if (c < 0 || c >= grid_.columns || r >= grid_.rows) continue;
        const IslandFinder::Place place{static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(r)};
        if (fresh_.at(place.column, place.row)) return place;
      }
    }
    return {column, row};
  }

  void clear_disc(const IslandFinder::Place& place) {
    for_each_disc_span(shape_.pitch(), place.column, place.row, held_.reach(), grid_.columns, grid_.rows,
                       [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                         const auto line = fresh_.row(row);
                         for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) { line[w] &= ~bits; });
                       });
  }

  Status add_tip(std::uint32_t column, std::uint32_t row, std::uint32_t layer, ConstBitImage mask) {
    if (count_ == list_.size()) {
      return fail(ErrorCode::kOutOfMemory,
                  "%s: more than %zu are needed up to layer %u of %u, the list has room for no more.\tTurn the object, "
                  "allow a smaller support_critical_angle or a larger support_max_bridge_length, or look at the "
                  "preview for outliers in the scan",
                  kStage, list_.size(), layer, grid_.layers);
    }
    Support support;
    support.column = static_cast<std::uint16_t>(column);
    support.row = static_cast<std::uint16_t>(row);
    support.first = top(column, row);
    support.tip = static_cast<std::uint16_t>(layer);
    support.end = static_cast<std::uint16_t>(std::min(layer + shape_.penetration(), grid_.layers));
    if (branch_off(support)) {
      ++counts_.on_supports;
    } else {
      ++(support.on_plate() ? counts_.on_plate : counts_.on_object);
    }
    list_[count_++] = support;
    held_.add_disc(column, row, shape_.head_radius(), mask);
    return {};
  }

  /// Ends a support on the highest layer of an earlier one that contains its axis. Rough undersides are full of islands;
  /// without this each would have a pillar of its own, through and beside the others.
  /// @returns whether there is such a support
  bool branch_off(Support& support) const {
    const std::uint32_t lowest = support.first;
    for (const Support& other : list_.first(count_)) {
      const Nanometres dx = (Nanometres{other.column} - support.column) * shape_.pitch().x;
      const Nanometres dy = (Nanometres{other.row} - support.row) * shape_.pitch().y;
      const Nanometres apart = dx * dx + dy * dy;
      if (apart > shape_.pillar_radius() * shape_.pillar_radius()) continue;
      // The head is narrow at its tip, so look downwards.
      const std::uint32_t down_to = std::max(other.first, support.first);
      for (std::uint32_t k = std::min(other.end, support.tip); k-- > down_to;) {
        const Nanometres radius = shape_.radius(other, k);
        if (radius * radius < apart) continue;
        support.first = static_cast<std::uint16_t>(k + 1);
        break;
      }
    }
    return support.first > lowest;
  }

  /// Keeps the layer as the one below, with the heads in it. A head ends where the object above its tip ends.
  void keep_as_below(std::uint32_t layer, ConstBitImage mask) {
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      const auto from = mask.row(r).subspan(window_.word, window_.word_end - window_.word);
      std::copy(from.begin(), from.end(), below_.row(r).begin() + window_.word);
    }
    while (heads_ < count_ && list_[heads_].tip + shape_.penetration() <= layer) ++heads_;
    for (Support& support : list_.first(count_).subspan(heads_)) {
      if (!support.is_in(layer)) continue;
      if (!mask.at(support.column, support.row)) {
        support.end = static_cast<std::uint16_t>(layer);
        continue;
      }
      for_each_disc_span(shape_.pitch(), support.column, support.row, shape_.head_radius(), grid_.columns, grid_.rows,
                         [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                           if (row < window_.row || row >= window_.row_end) return;
                           const auto line = below_.row(row);
                           for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) { line[w] |= bits; });
                         });
    }
  }

  PrintGrid grid_;
  Window window_;
  SupportShape shape_;
  SupportCounts counts_;
  std::span<Support> list_;  ///< by tip
  std::size_t count_ = 0;
  std::size_t heads_ = 0;         ///< index of the first support whose head may be in the layer
  std::span<std::uint16_t> top_;  ///< per pixel of the window: first layer above the object below it; 0: plate
  BitImage below_;                ///< the layer below, with heads
  BitImage fresh_;                ///< new pixels of the layer, then those that are not held
  HeldArea held_;
  IslandFinder islands_;
};

Expected<std::span<const Support>> sweep_layers(const RRep& rrep, Sweep& sweep, Arena& arena, ProgressSink* progress) {
  auto stream = LayerStream::create(rrep, arena);
  PLUMBLINE_TRY(stream);
  const std::uint32_t layers = rrep.grid.layers;
  for (std::uint32_t k = 0; k < layers; ++k) {
    if (progress != nullptr && !progress->advance(Stage::kSupports, static_cast<double>(k) / layers)) {
      return fail(ErrorCode::kCancelled, "stopped while supports were sought, at layer %u of %u", k, layers);
    }
    PLUMBLINE_TRY(sweep.layer(k, stream->mask(k)));
  }
  return sweep.sorted();
}

}  // namespace

Expected<Supports> find_supports(const RRep& rrep, const SupportSettings& settings, Arena& arena,
                                 ProgressSink* progress, SupportCounts& counts) {
  const ArenaScope scope(arena);
  const std::size_t bottom = arena.bottom_mark();
  counts = {};
  Sweep sweep(rrep, settings);
  PLUMBLINE_TRY(sweep.take_memory(settings, arena));
  const auto found = sweep_layers(rrep, sweep, arena, progress);
  arena.release_bottom(bottom);
  PLUMBLINE_TRY(found);
  auto list = arena.take_bottom<Support>(found->size(), kStage);
  PLUMBLINE_TRY(list);
  std::copy(found->begin(), found->end(), list->begin());
  counts = sweep.counts();
  return Supports{*list, sweep.shape()};
}

std::uint32_t most_supports(const PrintGrid& grid) {
  return static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(std::uint64_t{grid.columns} * grid.rows / 64, 256, 16384));
}

std::size_t find_supports_bytes(const PrintGrid& grid) {
  const std::size_t image = Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t));
  const std::size_t columns = (grid.columns + 63) / 64 * std::size_t{64};
  return LayerStream::bytes_needed(grid) + Arena::rounded(most_supports(grid) * sizeof(Support)) +
         Arena::rounded(columns * grid.rows * sizeof(std::uint16_t)) + 2 * image + HeldArea::bytes_needed(grid) +
         IslandFinder::bytes_needed(grid.columns);
}

}  // namespace plumbline
