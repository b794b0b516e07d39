#pragma once
/// Counts from a sweep over all masks of an object.

#include <cstdint>

namespace plumbline::inline slicer {

/// Layers at the ends of the object whose masks have no pixel. All are `below` if no mask has any.
struct EmptyLayers {
  std::uint32_t below = 0;
  std::uint32_t above = 0;
};

struct LayerTotals {
  EmptyLayers empty;
  std::uint64_t pixels = 0;        ///< of all masks, without supports
  std::uint64_t first_pixels = 0;  ///< of the first mask that has any

  /// Adds the next layer's mask.
  void add(std::uint64_t mask_pixels) {
    if (mask_pixels == 0) {
      ++(pixels == 0 ? empty.below : empty.above);
      return;
    }
    if (pixels == 0) first_pixels = mask_pixels;
    pixels += mask_pixels;
    empty.above = 0;
  }
};

}  // namespace plumbline::inline slicer
