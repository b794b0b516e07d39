#pragma once
/// What has fallen lies on the film and keeps the light from the layers above it.

#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/bit_spans.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/regions/layer_regions.hpp"

namespace plumbline::inline slicer {

/// The pixels on which something lies, and those of the newest layer that stayed on the part. Nobody cleans the film until the print
/// ends, as in hal/sim.
class Film {
 public:
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<Film> create(const PrintGrid& grid, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid);

  bool clean() const { return clean_; }
  /// @param lit  the pixels of `mask` that get light; overwritten
  void shade(ConstBitImage mask, BitImage lit) const;
  /// Whether a run of a row lies above what stayed of the layer below.
  bool touches_part(std::uint32_t row, const LayerRegions::Run& run) const;
  /// Takes a layer.
  /// @param lit    regions of the pixels that got light
  /// @param falls  called with a white region: whether nothing holds it
  template <class Falls>
  void lay_down(const LayerRegions& lit, Falls falls);
  /// The pixels of the newest layer that stayed. @pre !clean()
  ConstBitImage stayed() const { return stayed_; }
  /// Takes a layer of which all that gets light stays.
  void keep(ConstBitImage mask);

 private:
  bool clean_ = true;
  BitImage film_;
  BitImage stayed_;  ///< used when the film is not clean
};

template <class Falls>
void Film::lay_down(const LayerRegions& lit, Falls falls) {
  stayed_.clear();
  lit.for_each_white_run([&](std::uint32_t row, std::uint32_t i) {
    const bool fell = falls(lit.region(i));
    clean_ = clean_ && !fell;
    fill(fell ? film_ : stayed_, row, lit.run(i).first, lit.run(i).last + 1U, true);
  });
}

}  // namespace plumbline::inline slicer
