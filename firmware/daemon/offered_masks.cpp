#include "firmware/daemon/offered_masks.hpp"

namespace plumbline::firmware {

tl::unexpected<Error> no_such_layer(std::uint32_t layer, std::uint32_t layers) {
  return fail(ErrorCode::kBadSetting, "there is no layer %u: the last one is %u", layer, layers - 1);
}

Expected<std::unique_ptr<OfferedScanMasks>> OfferedScanMasks::create(const SlicedScan& sliced, Arena& arena) {
  std::unique_ptr<OfferedScanMasks> offered(new OfferedScanMasks(arena));
  const auto stream = MaskStream::create(sliced.rrep, sliced.supports, arena);
  PLUMBLINE_TRY(stream);
  offered->stream_.emplace(*stream, sliced.support_counts.steps);
  return offered;
}

Expected<bool> OfferedScanMasks::draw(std::uint32_t layer, LayerPicture& picture) {
  const std::uint32_t layers = stream_->grid().layers;
  if (layer >= layers) return no_such_layer(layer, layers);
  const auto mask = stream_->mask(layer);
  PLUMBLINE_TRY(mask);
  draw_layer_picture(*mask, picture);
  return true;
}

}  // namespace plumbline::firmware
