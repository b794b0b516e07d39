#pragma once
/// Layer masks, just in time, from the R-Rep (DESIGN 3, stage 9).

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/support_painter.hpp"

namespace plumbline {

/// Makes the masks of a print one after another; any layer can also be asked for directly.
class LayerStream {
 public:
  /// Takes its two images from the bottom of the arena.
  /// @param rrep      must outlive the stream
  /// @param supports  must outlive the stream; null or empty: none
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<LayerStream> create(const RRep& rrep, Arena& arena, const Supports* supports = nullptr);

  /// Bytes that create() takes.
  /// @param supports  how many there are
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t supports = 0);

  /// The mask of `layer`, one bit a pixel, one cures: the section, opened and closed, and the supports. The next layer
  /// costs what changes in it and the supports that are in it; another one costs the crossings between, and one from
  /// before costs all from layer 0 on.
  /// @param layer  0 to rrep.grid.layers - 1
  /// @returns a view, valid until the next call
  ConstBitImage mask(std::uint32_t layer);

  /// The section of the layer asked for last, as the crossings have it. A view, valid until the next call of mask().
  ConstBitImage section() const { return section_; }

  /// Pixels of the last mask that are there for the supports alone.
  std::uint64_t support_pixels() const { return support_pixels_; }

  const PrintGrid& grid() const { return rrep_->grid; }

 private:
  void toggle(std::uint32_t layer);
  void clean_changed();

  const RRep* rrep_ = nullptr;
  BitImage section_;  ///< as the crossings have it
  BitImage mask_;     ///< section_, opened and closed, and the supports
  BitImage changed_;  ///< one bit a word of section_: a pixel in reach was toggled since mask_ was made
  BitImage drawn_;    ///< one bit a word of mask_: has a support in it; without supports of no size
  SupportPainter painter_;
  std::uint64_t support_pixels_ = 0;
  std::uint32_t first_changed_ = 0, end_changed_ = 0;  ///< rows of changed_ that have a bit, none beyond
  std::int64_t at_ = -1;                               ///< layer of section_, -1: before the first
};

}  // namespace plumbline
