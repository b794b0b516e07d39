#include "firmware/print/job/mask_source.hpp"

#include "firmware/io/mask_hash.hpp"

namespace plumbline::firmware {

Expected<GreyRuns> take_greys(const PrintGrid& grid, bool shows_grey, Arena& arena) {
  if (!shows_grey) return GreyRuns();
  const auto room = arena.take_bottom<GreyRun>(GreyRuns::runs_needed(grid.columns, grid.rows), "grey pixels");
  PLUMBLINE_TRY(room);
  return GreyRuns(*room, grid.columns);
}

Expected<StreamMasks> StreamMasks::create(const RRep& rrep, const Supports& supports, const CureModel& grey,
                                          double layer_height_mm, Arena& arena, const LayerSteps& steps) {
  const auto stream = MaskStream::create(rrep, supports, arena);
  PLUMBLINE_TRY(stream);
  StreamMasks masks(*stream, steps);
  if (!grey.is_known()) return masks;
  CureModel model = grey;  // whose layers are the R-Rep's
  model.bottom_layers = steps.of(grey.bottom_layers + grey.faded_layers).first;
  model.faded_layers = 0;
  const auto made = GreyMasks::create(rrep, supports, model, layer_height_mm, arena);
  PLUMBLINE_TRY(made);
  masks.grey_ = *made;
  return masks;
}

Expected<ConstBitImage> StreamMasks::mask(std::uint32_t layer) {
  const LayerStep step = steps_.of(layer);
  const ConstBitImage mask = stream_.mask(step.sampled());
  // No ray enters in the middle of a higher layer of an adaptive print: those are where surfaces are too steep for stairs.
  return grey_ ? grey_->find(step.sampled(), stream_, mask) : mask;
}

Expected<ArchiveMasks> ArchiveMasks::create(int file, std::string_view name, const PrintGrid& grid,
                                            std::span<const ArchiveLayer> layers, const MaskTurn& turn,
                                            LayerDecoder& decoder, bool shows_grey, Arena& arena) {
  PLUMBLINE_TRY(decoder.prepare(grid, shows_grey, arena));
  const auto words = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "masks");
  PLUMBLINE_TRY(words);
  const auto greys = take_greys(grid, shows_grey, arena);
  PLUMBLINE_TRY(greys);
  return ArchiveMasks(file, name, grid, layers, turn, decoder, BitImage(*words, grid.columns, grid.rows), *greys);
}

Expected<ConstBitImage> ArchiveMasks::mask(std::uint32_t layer) {
  PLUMBLINE_TRY(decoder_->decode(file_, name_, layers_[layer], turn_, image_, greys_));
  if (mask_hash(image_, greys_.runs()) != layers_[layer].hash) {
    return fail(ErrorCode::kMalformed, "%s: layer %u is not as it was when the print was checked", name_.c_str(),
                layer + 1);
  }
  return ConstBitImage(image_);
}

}  // namespace plumbline::firmware
