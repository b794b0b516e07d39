#pragma once
/// A layer as the pictures show it: the object's section and its supports.

#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures::preview {

/// The section of each layer in turn, before its mask is opened and closed.
class Section {
 public:
  Section(const RRep& rrep, std::span<std::uint64_t> words)
      : rrep_(rrep), image_(words, rrep.grid.columns, rrep.grid.rows) {
    image_.clear();
  }

  /// Toggles the crossings of `layer`. Layers come in order, from 0.
  /// @param on_change  called with column, row and whether the pixel is inside now
  template <class OnChange>
  void advance(std::uint32_t layer, OnChange on_change) {
    const CrossingPacking packing(rrep_.grid);
    for (std::uint32_t k = rrep_.first[layer]; k < rrep_.first[layer + 1]; ++k) {
      const std::uint32_t pixel = packing.pixel(rrep_.packed[k]), row = pixel / rrep_.grid.columns;
      const std::uint32_t column = pixel - row * rrep_.grid.columns;
      std::uint64_t& word = image_.row(row)[column / 64];
      const std::uint64_t bit = std::uint64_t{1} << (column % 64);
      word ^= bit;
      on_change(column, row, (word & bit) != 0);
    }
  }
  const BitImage& image() const { return image_; }

 private:
  const RRep& rrep_;
  BitImage image_;
};

/// Calls visit(row, begin, end) for the pixels of a strut in a layer.
template <class Visit>
void for_each_span(const Supports& supports, const Strut& strut, std::uint32_t layer, const PrintGrid& grid,
                   Visit visit) {
  for_each_strut_span(supports.pitch, strut, layer, grid.columns, grid.rows, visit);
}

}  // namespace plumbline::firmware::inline pictures::preview
