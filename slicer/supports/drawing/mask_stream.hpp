#pragma once
/// Makes the masks that are printed: section, opened and closed, with the supports drawn in.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/support_painter.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::inline slicer {

/// A LayerStream whose masks have the supports drawn in. Any layer may be asked for; the costs are LayerStream's, and those
/// of the supports in the layer.
class MaskStream {
 public:
  /// Takes bytes_needed() from the bottom of the arena.
  /// @param rrep      must outlive the stream
  /// @param supports  must outlive the stream; may be empty
  /// @param counts    support_pixels() is wanted, which doubles the cost of supports
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<MaskStream> create(const RRep& rrep, const Supports& supports, Arena& arena,
                                                   bool counts = false);

  /// @param supports  how many there are
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t supports);

  /// The mask of `layer`, one bit a pixel, 1 cures.
  /// @param layer  0 to rrep.grid.layers - 1
  /// @returns a view, valid until the next call
  ConstBitImage mask(std::uint32_t layer);

  /// Of the last mask, before opening, closing and supports.
  ConstBitImage section() const { return layers_.section(); }

  /// Pixels of the last mask that belong to supports only; 0 if they are not counted.
  std::uint64_t support_pixels() const { return support_pixels_; }

  const PrintGrid& grid() const { return layers_.grid(); }

 private:
  MaskStream(const LayerStream& layers, const SupportPainter& painter, bool has_supports, bool counts)
      : layers_(layers), painter_(painter), has_supports_(has_supports), counts_(counts) {}

  LayerStream layers_;
  SupportPainter painter_;
  bool has_supports_;
  bool counts_;
  std::uint64_t support_pixels_ = 0;
};

}  // namespace plumbline::inline slicer
