#include "slicer/supports/tips.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "slicer/core/bit_spans.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/layers/morphology.hpp"
#include "slicer/supports/held_area.hpp"
#include "slicer/supports/islands.hpp"
#include "slicer/supports/placed_tips.hpp"
#include "slicer/supports/tip_loads.hpp"
#include "slicer/supports/weak_regions.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "supports";

// The list has room for a tip on every so many pixels or mm2 of the panel, whatever is more.
constexpr double kPixelsPerTip = 64;
/// mm: of specks. The region that grows over a higher one would be held late.
constexpr double kHighestSpeck = 0.2;
/// mm2: larger islands are flats, which their tips hold as they hold other overhangs.
constexpr double kDenseIsland = 12;
constexpr double kPi = 3.14159265358979324;
constexpr double kAreaPerTip = 1;  ///< mm2; on an overhang they share, tips are a few times rarer
constexpr double kMostTips = 16384;
/// mm2: of panels so large that kMostTips would be fewer. The default of area_per_tip.
constexpr double kLargeAreaPerTip = 4;

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
  Sweep(const RRep& rrep, std::uint32_t lifted, const SupportSettings& settings, std::span<Tip> list,
        std::span<SpeckPixel> specks)
      : placed_(settings, rrep.grid),
        grid_(rrep.grid),
        lifted_(lifted),
        window_(window_of(rrep)),
        pitch_(rrep.grid),
        head_(nanometres(settings.head_front_diameter / 2)),
        light_head_(nanometres(settings.head_front_diameter / 2 * kLightTip)),
        list_(list),
        specks_(specks) {
    const auto layer_height = static_cast<double>(grid_.layer_height_mm);
    const double pixel_mm2 = static_cast<double>(grid_.pitch_x_mm) * static_cast<double>(grid_.pitch_y_mm);
    const double light_tip = settings.head_front_diameter * kLightTip;
    dense_pixels_ = kDenseIsland / pixel_mm2;
    speck_pixels_ = kPi / 4 * light_tip * light_tip / pixel_mm2;
    penetration_ = static_cast<std::uint32_t>(std::floor(settings.head_penetration / layer_height + 0.5));
    speck_layers_ = static_cast<std::uint32_t>(std::floor(kHighestSpeck / layer_height + 0.5));
  }

  Status take_memory(const SupportSettings& settings, Arena& arena) {
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
    // One bit for each word of a row.
    auto marks = arena.take_top<std::uint64_t>(BitImage::words_needed(fresh_.stride(), grid_.rows), kStage);
    PLUMBLINE_TRY(marks);
    marks_ = BitImage(*marks, fresh_.stride(), grid_.rows);
    marks_.clear();
    auto held = HeldArea::create(grid_, settings, arena);
    PLUMBLINE_TRY(held);
    held_ = *held;
    // An overhang is at most this far from its tip, so no tip carries more than the disc's area.
    reach_ = std::min(held_.reach(), nanometres(std::sqrt(settings.area_per_tip / kPi)));
    auto islands = IslandFinder::create(grid_.columns, arena);
    PLUMBLINE_TRY(islands);
    islands_ = *islands;
    auto weak = WeakRegions::create(grid_.columns, grid_.rows, arena);
    PLUMBLINE_TRY(weak);
    weak_ = *weak;
    auto loads = TipLoads::create(grid_, settings, list_, arena);
    PLUMBLINE_TRY(loads);
    loads_ = *loads;
    return {};
  }

  /// Finds the surfaces of places, before the first layer is taken.
  void find_placed(LayerStream& stream) {
    if (placed_.empty()) return;
    for (std::uint32_t k = 0; k < grid_.layers; ++k) {
      const ConstBitImage mask = stream.mask(k);
      if (k + lifted_ > 0) placed_.look_at(k + lifted_, mask, below_);
      copy_below(mask);
    }
    below_.clear();
  }

  /// Takes the next layer of the stream.
  Status next_layer(LayerStream& stream) {
    const ConstBitImage mask = stream.mask(index_);
    const std::uint32_t layer = index_ + lifted_;
    const std::size_t lower = count_;
    if (layer == 0) {
      held_.begin(mask);
    } else if (compare_with_below(layer, mask)) {
      held_.next_layer(layer, mask, window_);
      PLUMBLINE_TRY(hold_placed(layer, mask));
      PLUMBLINE_TRY(hold_islands(layer, mask, stream, list_.first(count_).subspan(lower)));
      PLUMBLINE_TRY(hold_overhangs(layer, mask));
      if (islands_.may_be_weak()) PLUMBLINE_TRY(hold_weak_regions(layer, mask, list_.first(count_).subspan(lower)));
      PLUMBLINE_TRY(share_loads(layer, mask));
    } else {
      held_.next_layer(layer, mask, window_);
      PLUMBLINE_TRY(hold_placed(layer, mask));
    }
    keep_as_below(layer, mask);
    ++index_;
    return {};
  }

  /// What was found so far.
  FoundTips found() const { return {list_.first(count_), specks_.first(speck_end_), speck_count_, placed_.missed()}; }

 private:
  std::uint16_t& top(std::uint32_t column, std::uint32_t row) {
    return top_[std::size_t{row - window_.row} * window_.columns() + column - window_.word * 64];
  }

  /// Sets the tips of places, also where others are blocked.
  Status hold_placed(std::uint32_t layer, ConstBitImage mask) {
    for (const PlacedTips::Surface& at : placed_.surfaces()) {
      if (at.layer == layer) PLUMBLINE_TRY(add_tip(at.column, at.row, layer, mask, false, false, true));
    }
    return {};
  }

  /// Finds new pixels, and notes where the object ends.
  /// @returns whether there are new pixels
  bool compare_with_below(std::uint32_t layer, ConstBitImage mask) {
    bool any = false;
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      const auto line = mask.row(r);
      const auto below = below_.row(r);
      const auto fresh = fresh_.row(r);
      const auto marks = marks_.row(r);
      std::ranges::fill(marks, std::uint64_t{0});
      for (std::uint32_t w = window_.word; w < window_.word_end; ++w) {
        fresh[w] = line[w] & ~below[w];
        if (fresh[w] != 0) {
          marks[w / 64] |= std::uint64_t{1} << (w % 64);
          any = true;
        }
        for (std::uint64_t gone = below[w] & ~line[w]; gone != 0; gone &= gone - 1) {
          top(w * 64 + static_cast<std::uint32_t>(std::countr_zero(gone)), r) = static_cast<std::uint16_t>(layer);
        }
      }
    }
    return any;
  }

  /// @param placed  tips of places in this layer
  Status hold_islands(std::uint32_t layer, ConstBitImage mask, LayerStream& stream, std::span<Tip> placed) {
    Status done;
    specks_below_ = specks_here_;
    specks_here_ = speck_end_;
    const auto hold = [&](const IslandFinder::Place& place) {
      if (!placed.empty() && is_held_by(placed, place)) return;
      if (place.pixels <= speck_pixels_ && leave_out(place, stream)) return;
      if (done) done = add_tip(place.column, place.row, layer, mask, true, place.pixels <= dense_pixels_);
    };
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      Window with_fresh = window_;
      with_fresh.word = with_fresh.word_end;
      for_each_marked(marks_.row(r), [&](std::uint32_t w) {
        with_fresh.word = std::min(with_fresh.word, w);
        with_fresh.word_end = w + 1;
      });
      if (with_fresh.word == window_.word_end && !islands_.any_open() && r != window_.row) continue;
      islands_.next_row(mask, below_, fresh_, r, with_fresh, hold);
    }
    islands_.end(hold);
    return done;
  }

  /// Whether tips of places are in an island: it needs no other, and they carry what its tip would.
  bool is_held_by(std::span<Tip> placed, const IslandFinder::Place& place) {
    const auto pixels = take_island(place);
    bool held = false;
    for (Tip& tip : placed) {
      const auto is_here = [&](const SpeckPixel& p) { return p.pixel == tip.row * grid_.columns + tip.column; };
      if (std::ranges::none_of(pixels, is_here)) continue;
      held = tip.island = true;
      tip.dense = place.pixels <= dense_pixels_;
    }
    put_back(pixels);
    return held;
  }

  /// Takes an island out of fresh_.
  /// @returns its pixels, which lie behind the specks; none if there is no room for them
  std::span<SpeckPixel> take_island(const IslandFinder::Place& place) {
    if (place.pixels > specks_.size() - speck_end_) return {};
    // All pixels of an island are new, and so are none beside it. The list is the queue of the flood fill.
    std::size_t end = speck_end_;
    const auto take = [&](std::uint32_t column, std::uint32_t row) {
      if (column >= grid_.columns || row >= grid_.rows || !fresh_.at(column, row)) return;
      fresh_.row(row)[column / 64] &= ~(std::uint64_t{1} << (column % 64));
      specks_[end++] = {row * grid_.columns + column, static_cast<std::uint16_t>(index_), 1, true};
    };
    take(place.column, place.row);
    for (std::size_t i = speck_end_; i < end; ++i) {
      const std::uint32_t column = specks_[i].pixel % grid_.columns;
      const std::uint32_t row = specks_[i].pixel / grid_.columns;
      take(column - 1, row);
      take(column + 1, row);
      take(column, row - 1);
      take(column, row + 1);
    }
    return specks_.subspan(speck_end_, end - speck_end_);
  }
  void put_back(std::span<const SpeckPixel> pixels) {
    for (const SpeckPixel& pixel : pixels) fresh_.set(pixel.pixel % grid_.columns, pixel.pixel / grid_.columns);
  }

  /// Leaves an island out of the layer if it is a speck.
  /// @returns whether it is one
  bool leave_out(const IslandFinder::Place& place, LayerStream& stream) {
    const auto pixels = take_island(place);
    std::uint16_t depth = 1;
    for (const SpeckPixel& here : pixels) {
      for (const SpeckPixel& below : specks_.subspan(specks_below_, specks_here_ - specks_below_)) {
        const bool is_below = below.pixel == here.pixel && below.layer + 1U == index_;
        if (is_below) depth = std::max(depth, static_cast<std::uint16_t>(below.depth + 1));
      }
    }
    if (pixels.empty() || depth > speck_layers_) {
      put_back(pixels);
      return false;
    }
    stream.draw_on_mask([&](BitImage mask, BitImage drawn) {
      for (SpeckPixel& speck : pixels) {
        const std::uint32_t column = speck.pixel % grid_.columns;
        const std::uint32_t row = speck.pixel / grid_.columns;
        mask.row(row)[column / 64] &= ~(std::uint64_t{1} << (column % 64));
        drawn.set(row, column / kStripColumns);
        held_.take_out(column, row);
        speck.depth = depth;
        speck.in_section = stream.section().at(column, row);
      }
    });
    speck_end_ += pixels.size();
    if (depth == 1) ++speck_count_;
    return true;
  }

  /// @param tips  of this layer
  Status hold_weak_regions(std::uint32_t layer, ConstBitImage mask, std::span<const Tip> tips) {
    weak_.look_at(mask, below_, tips);
    Status done;
    weak_.for_each(mask, below_, [&](const WeakRegions::Place& place) {
      if (done) done = add_tip(place.column, place.row, layer, mask, true, place.pixels <= dense_pixels_);
    });
    return done;
  }

  Status hold_overhangs(std::uint32_t layer, ConstBitImage mask) {
    held_.drop_what_is_near(fresh_, marks_);
    Status done;
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      const auto line = fresh_.row(r);
      for_each_marked(marks_.row(r), [&](std::uint32_t w) {
        while (line[w] != 0 && done) {
          const std::uint32_t column = w * 64 + static_cast<std::uint32_t>(std::countr_zero(line[w]));
          if (placed_.is_blocked(column, r, layer)) {
            line[w] &= line[w] - 1;
            continue;
          }
          const auto place = place_for(column, r, layer);
          done = add_tip(place.column, place.row, layer, mask, false, false);
          clear_disc(place);
        }
      });
    }
    return done;
  }

  /// Place for the tip that holds (column, row) and as many pixels beside it as possible.
  IslandFinder::Place place_for(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const {
    const auto reach_x = static_cast<std::int64_t>(reach_ / pitch_.x);
    const auto reach_y = static_cast<std::int64_t>(reach_ / pitch_.y);
    for (const std::int32_t share : kShares) {
      for (const Offset& offset : kDirections) {
        const std::int64_t c = column + reach_x * offset.columns * share / 4096;
        const std::int64_t r = row + reach_y * offset.rows * share / 4096;
        if (c < 0 || c >= grid_.columns || r >= grid_.rows) continue;
        const IslandFinder::Place place{static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(r)};
        if (fresh_.at(place.column, place.row) && !placed_.is_blocked(place.column, place.row, layer)) return place;
      }
    }
    return {column, row};
  }

  void clear_disc(const IslandFinder::Place& place) {
    for_each_disc_span(pitch_, place.column, place.row, reach_, grid_.columns, grid_.rows,
                       [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                         const auto line = fresh_.row(row);
                         for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) { line[w] &= ~bits; });
                       });
  }

  /// Gives the new pixels that nothing holds to their nearest tips, and puts more tips where one has too much.
  Status share_loads(std::uint32_t layer, ConstBitImage mask) {
    Status done;
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      const auto line = mask.row(r);
      const auto below = below_.row(r);
      for_each_marked(marks_.row(r), [&](std::uint32_t w) {
        std::uint64_t rest = held_.unheld(r, w, line[w] & ~below[w]);
        while (rest != 0 && done) {
          const auto first = static_cast<std::uint32_t>(std::countr_zero(rest));
          const std::uint32_t length =
              std::min(static_cast<std::uint32_t>(std::countr_one(rest >> first)), TipLoads::kMostPixels);
          const std::uint32_t column = w * 64 + first + length / 2;
          if (const Tip* const full = loads_.carry(column, r, layer, length)) {
            done = add_tip(column, r, layer, mask, false, full->dense && full->layer == layer);
            if (!done) return;
            loads_.carry(column, r, layer, length);
          }
          rest &= ~(((std::uint64_t{1} << length) - 1) << first);
        }
      });
    }
    return done;
  }

  /// The layer in which a foot below a tip can stand: the highest that the object below reaches in half of the foot's pixels. A foot on fewer, such as
  /// the edge of a thin wall, would be torn off or an island; it passes them by.
  std::uint16_t floor_below(std::uint32_t column, std::uint32_t row) {
    std::uint32_t floor = 0;
    for (std::uint32_t step = 1U << 15; step != 0; step /= 2) {
      if (floor + step <= top(column, row) && is_footing(column, row, floor + step)) floor += step;
    }
    return static_cast<std::uint16_t>(floor);
  }

  bool is_footing(std::uint32_t column, std::uint32_t row, std::uint32_t floor) {
    std::uint32_t pixels = 0;
    std::uint32_t reached = 0;
    for_each_disc_span(pitch_, column, row, head_, grid_.columns, grid_.rows,
                       [&](std::uint32_t r, std::uint32_t begin, std::uint32_t end) {
                         pixels += end - begin;
                         if (r < window_.row || r >= window_.row_end) return;
                         const std::uint32_t most = std::min(end, window_.word_end * 64);
                         for (std::uint32_t c = std::max(begin, window_.word * 64); c < most; ++c) {
                           if (below_.at(c, r) || top(c, r) >= floor) ++reached;
                         }
                       });
    return 2 * reached >= pixels;
  }

  /// @param placed  by a person: also where tips are blocked
  Status add_tip(std::uint32_t column, std::uint32_t row, std::uint32_t layer, ConstBitImage mask, bool island,
                 bool dense, bool placed = false) {
    if (!placed && placed_.is_blocked(column, row, layer)) return {};
    if (count_ == list_.size()) {
      return telling(
          Told(ToldCode::kTooManySupports, {{Fact::kCount, list_.size()}}),
          fail(ErrorCode::kOutOfMemory,
               "%s: more than %zu are needed up to layer %u of %u, the list has room for no more.\tTurn the object, "
               "allow a smaller support_overhang_angle or a larger support_overhang_span, or look at the preview for "
               "outliers in the scan",
               kStage, list_.size(), layer, grid_.layers + lifted_));
    }
    Tip& tip = list_[count_];
    tip = {};
    tip.column = static_cast<std::uint16_t>(column);
    tip.row = static_cast<std::uint16_t>(row);
    tip.floor = floor_below(column, row);
    tip.layer = static_cast<std::uint16_t>(layer);
    tip.end = static_cast<std::uint16_t>(std::min(layer + penetration_, grid_.layers + lifted_));
    tip.island = island;
    tip.dense = dense;
    loads_.add(static_cast<std::uint32_t>(count_));
    ++count_;
    held_.add_disc(column, row, head_, mask);
    return {};
  }

  /// Keeps the layer as the one below, with the heads in it, as thin as they may become: what only a thicker one touches would be an
  /// island. A head ends where the object above its tip ends.
  void keep_as_below(std::uint32_t layer, ConstBitImage mask) {
    copy_below(mask);
    while (heads_ < count_ && list_[heads_].layer + penetration_ <= layer) ++heads_;
    for (Tip& tip : list_.first(count_).subspan(heads_)) {
      if (layer >= tip.end) continue;
      if (!mask.at(tip.column, tip.row)) {
        tip.end = static_cast<std::uint16_t>(layer);
        continue;
      }
      for_each_disc_span(pitch_, tip.column, tip.row, light_head_, grid_.columns, grid_.rows,
                         [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                           if (row < window_.row || row >= window_.row_end) return;
                           const auto line = below_.row(row);
                           for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) { line[w] |= bits; });
                         });
    }
  }

  void copy_below(ConstBitImage mask) {
    for (std::uint32_t r = window_.row; r < window_.row_end; ++r) {
      const auto from = mask.row(r).subspan(window_.word, window_.word_end - window_.word);
      std::copy(from.begin(), from.end(), below_.row(r).begin() + window_.word);
    }
  }

  PlacedTips placed_;
  PrintGrid grid_;
  std::uint32_t lifted_;
  Window window_;
  PixelPitch pitch_;
  Nanometres head_;                 ///< radius of a tip of medium load
  Nanometres light_head_;           ///< and of light load
  Nanometres reach_ = 0;            ///< of a tip
  std::uint32_t penetration_ = 0;   ///< layers
  std::uint32_t speck_layers_ = 0;  ///< of a speck, at most
  std::uint32_t index_ = 0;         ///< of the layer, in the stream
  double speck_pixels_ = 0;         ///< of a speck, at most
  double dense_pixels_ = 0;         ///< of an island, at most, that gets dense tips
  std::span<Tip> list_;             ///< by layer
  std::size_t count_ = 0;
  std::span<SpeckPixel> specks_;
  std::size_t speck_end_ = 0;
  std::size_t specks_below_ = 0, specks_here_ = 0;  ///< where those of the layers begin
  std::uint32_t speck_count_ = 0;
  std::size_t heads_ = 0;         ///< index of the first tip that may be in the layer
  std::span<std::uint16_t> top_;  ///< per pixel of the window: first layer above the object below it; 0: plate
  BitImage below_;                ///< the layer below, with heads
  BitImage marks_;                ///< words of fresh_ that have new pixels, one bit each
  BitImage fresh_;                ///< new pixels of the layer, then those that are not held
  HeldArea held_;
  IslandFinder islands_;
  WeakRegions weak_;
  TipLoads loads_;
};

}  // namespace

Expected<FoundTips> find_tips(const RRep& rrep, std::uint32_t lifted, const SupportSettings& settings,
                              std::span<Tip> list, std::span<SpeckPixel> specks, Arena& arena, ProgressSink* progress) {
  const ArenaScope scope(arena);
  const std::size_t bottom = arena.bottom_mark();
  Sweep sweep(rrep, lifted, settings, list, specks);
  PLUMBLINE_TRY(sweep.take_memory(settings, arena));
  auto stream = LayerStream::create(rrep, arena);
  PLUMBLINE_TRY(stream);
  sweep.find_placed(*stream);
  const std::uint32_t layers = rrep.grid.layers;
  Status done;
  for (std::uint32_t k = 0; k < layers && done; ++k) {
    if (progress != nullptr && !progress->advance(Stage::kSupports, static_cast<double>(k) / layers)) {
      done = fail(ErrorCode::kCancelled, "stopped while supports were sought, at layer %u of %u", k, layers);
    } else {
      done = sweep.next_layer(*stream);
    }
  }
  arena.release_bottom(bottom);
  PLUMBLINE_TRY(done);
  return sweep.found();
}

std::uint32_t most_tips(const PrintGrid& grid) {
  const double pixels = static_cast<double>(grid.columns) * grid.rows;
  const double area = pixels * static_cast<double>(grid.pitch_x_mm) * static_cast<double>(grid.pitch_y_mm);
  const double most = std::max(kMostTips, area / kLargeAreaPerTip);
  return static_cast<std::uint32_t>(std::clamp(std::max(pixels / kPixelsPerTip, area / kAreaPerTip), 256.0, most));
}

std::size_t find_tips_bytes(const PrintGrid& grid, const Window& window) {
  const std::size_t image = Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t));
  const std::size_t pixels = std::size_t{window.columns()} * window.rows();
  return LayerStream::bytes_needed(grid) + Arena::rounded(pixels * sizeof(std::uint16_t)) + 2 * image +
         Arena::rounded(BitImage::words_needed((grid.columns + 63) / 64, grid.rows) * sizeof(std::uint64_t)) +
         HeldArea::bytes_needed(grid) + IslandFinder::bytes_needed(grid.columns) +
         WeakRegions::bytes_needed(grid.rows) + TipLoads::bytes_needed(grid, most_tips(grid));
}

}  // namespace plumbline::inline slicer
