#include "firmware/daemon/offered_masks.hpp"

namespace plumbline::firmware {

tl::unexpected<Error> no_such_layer(std::uint32_t layer, std::uint32_t layers) {
  return fail(ErrorCode::kBadSetting, "there is no layer %u: the last one is %u", layer, layers - 1);
}

Expected<std::unique_ptr<OfferedScanMasks>> OfferedScanMasks::create(const SlicedScan& sliced, const CureModel& grey,
                                                                     Arena& arena) {
  std::unique_ptr<OfferedScanMasks> offered(new OfferedScanMasks(arena));
  const auto stream = StreamMasks::create(sliced.rrep, sliced.supports, grey, double{sliced.rrep.grid.layer_height_mm},
                                          arena, sliced.support_counts.steps);
  PLUMBLINE_TRY(stream);
  offered->stream_ = *stream;
  return offered;
}

Expected<bool> OfferedScanMasks::draw(std::uint32_t layer, const MaskWindow& window, MaskPicture& picture) {
  const std::uint32_t layers = stream_->grid().layers;
  if (layer >= layers) return no_such_layer(layer, layers);
  const auto mask = stream_->mask(layer);
  PLUMBLINE_TRY(mask);
  draw_mask_window(*mask, stream_->greys(), stream_->section(), window, picture);
  return true;
}

}  // namespace plumbline::firmware
