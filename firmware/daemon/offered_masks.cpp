#include "firmware/daemon/offered_masks.hpp"

namespace plumbline::firmware {

tl::unexpected<Error> no_such_layer(std::uint32_t layer, std::uint32_t layers) {
  return fail(ErrorCode::kBadSetting, "there is no layer %u: the last one is %u", layer, layers - 1);
}

Expected<std::unique_ptr<OfferedScanMasks>> OfferedScanMasks::create(const SlicedScan& sliced, const PrintPlan& plan,
                                                                     Arena& arena) {
  const PrintGrid& grid = sliced.rrep.grid;
  std::unique_ptr<OfferedScanMasks> offered(new OfferedScanMasks(arena));
  const auto stream = MaskStream::create(sliced.rrep, sliced.supports, arena);
  PLUMBLINE_TRY(stream);
  offered->stream_.emplace(*stream, plan.steps);
  const auto masks = MaskRenderer::create(*offered->stream_, plan, arena);
  PLUMBLINE_TRY(masks);
  offered->masks_ = *masks;
  const auto words = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "mask");
  PLUMBLINE_TRY(words);
  offered->mask_ = BitImage(*words, grid.columns, grid.rows);
  return offered;
}

Expected<bool> OfferedScanMasks::draw(std::uint32_t layer, LayerPicture& picture) {
  const std::uint32_t layers = masks_->grid().layers;
  if (layer >= layers) return no_such_layer(layer, layers);
  PLUMBLINE_TRY(masks_->render(layer, mask_));
  draw_layer_picture(mask_, picture);
  return true;
}

}  // namespace plumbline::firmware
