#pragma once
/// Makes layer masks from the R-Rep, just in time.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/layers/quotient.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// Makes the object's masks one after another, without supports (MaskStream adds those). Any layer may be asked for.
class LayerStream {
 public:
  /// Takes bytes_needed() from the bottom of the arena.
  /// @param rrep  must outlive the stream
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<LayerStream> create(const RRep& rrep, Arena& arena);

  static std::size_t bytes_needed(const PrintGrid& grid);

  /// The mask of `layer`: its section, opened and closed unless the R-Rep is exact; one bit a pixel, 1 cures.
  ///
  /// The next layer costs what changes in it, a later one the crossings between, an earlier one all crossings from layer 0.
  /// @param layer  0 to rrep.grid.layers - 1
  /// @returns a view, valid until the next call
  ConstBitImage mask(std::uint32_t layer);

  /// The section of the layer asked for last, before opening and closing. A view, valid until the next call of mask().
  ConstBitImage section() const { return section_; }

  /// Calls draw(image, drawn) to draw on the last mask. The drawing stays until the next call of mask(), which restores
  /// the strips it touched.
  /// @param draw  sets bit r of row s in `drawn` for each row r of `image` that it changes in strip s (kStripColumns)
  template <class Draw>
  void draw_on_mask(Draw draw) {
    draw(mask_, changed_);
  }

  const PrintGrid& grid() const { return rrep_->grid; }

 private:
  void toggle(std::uint32_t layer);
  void remake(std::uint32_t strip, std::uint32_t first, std::uint32_t end);
  void remake_changed();

  const RRep* rrep_ = nullptr;
  BitImage section_;  ///< the crossings up to layer at_, toggled
  BitImage mask_;     ///< section_, opened and closed
  BitImage changed_;  ///< one row a strip of mask_, one bit for each of its rows: must be remade
  Quotient row_of_;   ///< of a pixel
  CrossingPacking packing_{PrintGrid{}};
  std::int64_t at_ = -1;  ///< layer of section_; -1: none yet
};

}  // namespace plumbline::inline slicer
