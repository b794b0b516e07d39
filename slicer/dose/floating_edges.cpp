#include "slicer/dose/floating_edges.hpp"

#include <algorithm>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/disjoint_sets.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "edges";
/// New pixels that a layer may have for its pieces to be looked at; one with more begins a flat underside, beside which a strip is nothing.
/// The same in any arena, so that masks are.
std::size_t most_pixels(const PrintGrid& grid) { return std::size_t{grid.columns} * grid.rows / 32 + 1024; }

/// A pixel that a layer has and the one below has not.
struct NewPixel {
  std::uint32_t parent = 0;  ///< of DisjointSets
  std::uint32_t packed = 0;  ///< its crossing
  bool is_held = false;      ///< of a root: a pixel of the layer below goes on beside its piece
  bool goes_on = false;      ///< of a root: a pixel of its piece is in the next layer, too
};
using Pieces = DisjointSets<NewPixel, &NewPixel::parent>;

class FloatingEdges {
 public:
  FloatingEdges(RRep& rrep, std::uint32_t most, BitImage lit, BitImage fresh, std::span<NewPixel> pixels,
                std::span<std::uint32_t> carried)
      : grid_(rrep.grid),
        packing_(rrep.grid),
        most_less_(most),
        lit_(lit),
        new_(fresh),
        pixels_(pixels),
        carried_(carried) {
    packed_ = const_cast<std::uint32_t*>(rrep.packed.data());
  }

  /// Makes the layer's crossings of those that the R-Rep has and those that have been moved up to it, writes them behind those of the layers
  /// below, and moves up what floats.
  /// @param crossings, next  of this layer and the one above
  void add_layer(std::span<const std::uint32_t> crossings, std::span<const std::uint32_t> next) {
    const std::uint32_t begin = written_;
    count_ = 0;
    is_complete_ = true;
    merge(crossings);
    if (count_ > 0 && is_complete_ && has_floating(next)) move_up(begin);
    for (const NewPixel& pixel : pixels_.first(count_)) toggle(new_, packing_.pixel(pixel.packed));
  }

  std::uint32_t written() const { return written_; }
  std::uint64_t taken() const { return taken_; }

 private:
  /// @returns the pixel's new value
  static bool toggle(BitImage image, std::uint32_t pixel) {
    std::uint64_t& word = image.words()[pixel / 64];
    word ^= std::uint64_t{1} << (pixel % 64);
    return (word >> (pixel % 64)) & 1U;
  }

  /// Writes what is read or carried; a pixel of both enters and exits at once.
  /// What is written ends at or before what has been read, since what is carried was taken from the layer below.
  void merge(std::span<const std::uint32_t> crossings) {
    std::size_t carried = 0, read = 0;
    while (carried < carried_count_ || read < crossings.size()) {
      const std::uint32_t old = carried < carried_count_ ? packing_.pixel(carried_[carried]) : UINT32_MAX;
      const std::uint32_t own = read < crossings.size() ? packing_.pixel(crossings[read]) : UINT32_MAX;
      if (old == own) {
        ++carried;
        ++read;
      } else {
        write(old < own ? carried_[carried++] : crossings[read++]);
      }
    }
    carried_count_ = 0;
  }

  void write(std::uint32_t packed) {
    const std::uint32_t pixel = packing_.pixel(packed);
    const bool enters = toggle(lit_, pixel);
    packed_[written_++] = enters ? marked_less(packed, (most_less_ + 1) / 2, most_less_)
                                 : packed;  // the middle of what the bits stand for
    if (!enters) return;
    if (count_ == pixels_.size()) {
      is_complete_ = false;
      return;
    }
    pixels_[count_++] = {.parent = 0, .packed = packed};
    toggle(new_, pixel);
  }

  /// Finds the pieces of new pixels. @returns whether any is to move up
  bool has_floating(std::span<const std::uint32_t> next) {
    const auto fresh = pixels_.first(count_);
    Pieces pieces(fresh);
    pieces.start_all();
    std::uint32_t above = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      const std::uint32_t pixel = packing_.pixel(fresh[i].packed);
      if (i > 0 && packing_.pixel(fresh[i - 1].packed) + 1 == pixel && pixel % grid_.columns > 0)
        pieces.unite(i - 1, i);
      while (packing_.pixel(fresh[above].packed) + grid_.columns < pixel) ++above;
      if (packing_.pixel(fresh[above].packed) + grid_.columns == pixel) pieces.unite(above, i);
    }
    for (std::uint32_t i = 0; i < count_; ++i) {
      const std::uint32_t pixel = packing_.pixel(fresh[i].packed);
      NewPixel& piece = fresh[pieces.root(i)];
      piece.is_held = piece.is_held || has_old_beside(pixel);
      piece.goes_on = piece.goes_on || !std::ranges::binary_search(next, pixel, {}, [this](std::uint32_t packed) {
                        return packing_.pixel(packed);
                      });
    }
    return std::ranges::any_of(fresh, [](const NewPixel& pixel) { return !pixel.is_held && pixel.goes_on; });
  }

  bool has_old_beside(std::uint32_t pixel) const {
    const std::uint32_t columns = grid_.columns, column = pixel % columns;
    const auto is_old = [this](std::uint32_t at) { return lit_.at(at, 0) && !new_.at(at, 0); };
    return (column > 0 && is_old(pixel - 1)) || (column + 1 < columns && is_old(pixel + 1)) ||
           (pixel >= columns && is_old(pixel - columns)) ||
           (pixel + columns < lit_.columns() && is_old(pixel + columns));
  }

  /// @param begin  of the layer's crossings among those written
  void move_up(std::uint32_t begin) {
    const Pieces pieces(pixels_.first(count_));
    std::uint32_t kept = begin, at = 0;
    for (std::uint32_t from = begin; from < written_; ++from) {
      const std::uint32_t packed = packed_[from];
      if (at < count_ && packing_.pixel(pixels_[at].packed) == packing_.pixel(packed)) {
        const NewPixel& piece = pixels_[pieces.root(at)];
        const std::uint32_t less = pixels_[at++].packed & most_less_;
        if (!piece.is_held && piece.goes_on && less > 0) {
          carried_[carried_count_++] = marked_less(packing_.packed(packing_.pixel(packed)), less - 1, most_less_);
          toggle(lit_, packing_.pixel(packed));
          continue;
        }
      }
      packed_[kept++] = packed;
    }
    taken_ += written_ - kept;
    written_ = kept;
  }

  PrintGrid grid_;
  CrossingPacking packing_;
  std::uint32_t most_less_;
  std::uint32_t* packed_;
  BitImage lit_;  ///< of the layer, all rows in one
  BitImage new_;  ///< those of pixels_, all rows in one
  std::span<NewPixel> pixels_;
  std::uint32_t count_ = 0;           ///< of pixels_ in use
  bool is_complete_ = true;           ///< pixels_ has all of the layer
  std::span<std::uint32_t> carried_;  ///< to the next layer, as many as pixels_
  std::size_t carried_count_ = 0;
  std::uint32_t written_ = 0;
  std::uint64_t taken_ = 0;
};

}  // namespace

std::size_t floating_edges_bytes(const PrintGrid& grid) {
  return 2 * Arena::rounded(BitImage::words_needed(grid.columns * grid.rows, 1) * sizeof(std::uint64_t)) +
         Arena::rounded(most_pixels(grid) * sizeof(NewPixel)) +
         Arena::rounded(most_pixels(grid) * sizeof(std::uint32_t));
}

Expected<std::uint64_t> drop_floating_edges(RRep& rrep, std::uint32_t most_less, Arena& arena) {
  const ArenaScope scope(arena);
  const PrintGrid& grid = rrep.grid;
  const std::uint32_t grid_pixels = grid.columns * grid.rows;
  const std::size_t words = BitImage::words_needed(grid_pixels, 1);
  const auto lit = arena.take_top<std::uint64_t>(words, kStage);
  PLUMBLINE_TRY(lit);
  const auto fresh = arena.take_top<std::uint64_t>(words, kStage);
  PLUMBLINE_TRY(fresh);
  const std::size_t most = std::min(rrep.crossings(), most_pixels(grid));
  const auto pixels = arena.take_top<NewPixel>(most, kStage);
  PLUMBLINE_TRY(pixels);
  const auto carried = arena.take_top<std::uint32_t>(most, kStage);
  PLUMBLINE_TRY(carried);
  const BitImage lit_image(*lit, grid_pixels, 1), new_image(*fresh, grid_pixels, 1);
  lit_image.clear();
  new_image.clear();

  FloatingEdges edges(rrep, most_less, lit_image, new_image, *pixels, *carried);
  std::uint32_t* const first = const_cast<std::uint32_t*>(rrep.first.data());
  std::uint32_t begin = first[0], end = first[1];
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    const std::uint32_t next_end = k + 1 < grid.layers ? first[k + 2] : end;
    first[k] = edges.written();
    edges.add_layer(rrep.packed.subspan(begin, end - begin), rrep.packed.subspan(end, next_end - end));
    begin = end;
    end = next_end;
  }
  first[grid.layers] = edges.written();
  rrep.packed = rrep.packed.first(edges.written());
  return edges.taken();
}

}  // namespace plumbline::inline slicer
