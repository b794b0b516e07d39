#pragma once
/// Layer masks, just in time, from the R-Rep (DESIGN 3, stage 9).

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep.hpp"

namespace plumbline {

/// Makes the masks of a print one after another; any layer can also be asked for directly.
class LayerStream {
 public:
  /// Takes its two images from the bottom of the arena.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<LayerStream> create(const RRep& rrep, Arena& arena);

  /// Bytes that create() takes.
  static std::size_t bytes_needed(const PrintGrid& grid);

  /// The mask of `layer`, one bit a pixel, one cures. Cheap when `layer` is the one after the last; otherwise the
  /// crossings between are toggled, or all from layer 0 on.
  /// @param layer  0 to rrep.grid.layers - 1
  /// @returns a view, valid until the next call
  ConstBitImage mask(std::uint32_t layer);

  const PrintGrid& grid() const { return rrep_.grid; }

 private:
  RRep rrep_;
  BitImage raw_;      ///< the section, as the crossings have it
  BitImage clean_;    ///< raw_ after opening and closing
  std::int64_t at_ = -1;  ///< layer that raw_ shows, -1 before the first
};

}  // namespace plumbline
