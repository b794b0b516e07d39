#include "firmware/daemon/offered_archive.hpp"

#include <utility>

#include "firmware/io/mask_hash.hpp"
#include "firmware/print/job/mask_source.hpp"

namespace plumbline::firmware {

Expected<std::unique_ptr<OfferedArchiveMasks>> OfferedArchiveMasks::create(int file, std::string_view name,
                                                                           const SlicedArchive& sliced,
                                                                           ChildLayerDecoder& decoder, bool shows_grey,
                                                                           Arena& arena) {
  const PrintGrid& grid = sliced.grid;
  std::unique_ptr<OfferedArchiveMasks> offered(new OfferedArchiveMasks(file, name, sliced, decoder, arena));
  PLUMBLINE_TRY(decoder.prepare(grid, shows_grey, arena));
  const auto words = arena.take_bottom<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "masks");
  PLUMBLINE_TRY(words);
  offered->mask_ = BitImage(*words, grid.columns, grid.rows);
  const auto greys = take_greys(grid, shows_grey, arena);
  PLUMBLINE_TRY(greys);
  offered->greys_ = *greys;
  return offered;
}

OfferedArchiveMasks::OfferedArchiveMasks(int file, std::string_view name, const SlicedArchive& sliced,
                                         ChildLayerDecoder& decoder, Arena& arena)
    : file_(file), sliced_(sliced), decoder_(decoder), arena_(arena), bottom_(arena.bottom_mark()), top_(arena) {
  name_.add("%.*s", static_cast<int>(name.size()), name.data());
}

OfferedArchiveMasks::~OfferedArchiveMasks() {
  if (asked_) static_cast<void>(decoder_.give_up());
  arena_.release_bottom(bottom_);
}

Expected<bool> OfferedArchiveMasks::draw(std::uint32_t layer, const MaskWindow& window, MaskPicture& picture) {
  if (layer >= sliced_.grid.layers) return no_such_layer(layer, sliced_.grid.layers);
  look();
  if (done_ == layer) {
    if (problem_) {
      done_.reset();  // whoever asks again lets it be tried again
      return tl::unexpected<Error>(*problem_);
    }
    draw_mask_window(mask_, greys_.runs(), {}, window, picture);
    return true;
  }
  if (asked_) return false;
  PLUMBLINE_TRY(decoder_.begin(file_, name_.view(), sliced_.layers[layer], sliced_.turn));
  done_.reset();
  asked_ = layer;
  asked_at_ = HostClock::now();
  return false;
}

/// Takes what the child has decoded, if it has ended.
void OfferedArchiveMasks::look() {
  if (!asked_) return;
  const auto finished = decoder_.finish(std::chrono::milliseconds(0), mask_, greys_);
  const bool hangs = finished && !*finished && HostClock::now() - asked_at_ > decoder_.patience().layer;
  if (finished && !*finished && !hangs) return;
  done_ = std::exchange(asked_, std::nullopt);
  problem_.reset();
  if (hangs) {
    problem_ = decoder_.give_up();
  } else if (!finished) {
    problem_ = finished.error();
  } else if (mask_hash(mask_, greys_.runs()) != sliced_.layers[*done_].hash) {
    problem_ = Error::format(ErrorCode::kMalformed, "%s: layer %u is not as it was when the print was checked",
                             name_.c_str(), *done_ + 1);
  }
}

}  // namespace plumbline::firmware
