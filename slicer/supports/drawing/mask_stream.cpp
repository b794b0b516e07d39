#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline::inline slicer {

Expected<MaskStream> MaskStream::create(const RRep& rrep, const Supports& supports, Arena& arena, bool counts) {
  const auto layers = LayerStream::create(rrep, arena);
  PLUMBLINE_TRY(layers);
  if (supports.empty()) return MaskStream(*layers, {}, false, false);
  const auto painter = SupportPainter::create(supports, arena);
  PLUMBLINE_TRY(painter);
  return MaskStream(*layers, *painter, true, counts);
}

std::size_t MaskStream::bytes_needed(const PrintGrid& grid, std::size_t supports) {
  return LayerStream::bytes_needed(grid) + (supports == 0 ? 0 : SupportPainter::bytes_needed(supports));
}

ConstBitImage MaskStream::mask(std::uint32_t layer) {
  const ConstBitImage mask = layers_.mask(layer);
  if (has_supports_) {
    layers_.draw_on_mask([&](BitImage image, BitImage drawn) {
      if (counts_) {
        support_pixels_ = painter_.draw_and_count(layer, image, drawn);
      } else {
        painter_.draw(layer, image, drawn);
      }
    });
  }
  return mask;
}

}  // namespace plumbline::inline slicer
