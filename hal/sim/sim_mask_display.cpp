#include "hal/sim/sim_mask_display.hpp"

#include <memory>

#include "hal/sim/sim_call.hpp"

namespace plumbline::inline hal::inline sim {

SimMaskDisplay::SimMaskDisplay(Plant& plant, Interlock& interlock)
    : MaskDisplay(plant.settings().built_otherwise ? plant.settings().built_otherwise->believed.columns
                                                   : plant.settings().panel.columns,
                  plant.settings().built_otherwise ? plant.settings().built_otherwise->believed.rows
                                                   : plant.settings().panel.rows,
                  interlock),
      plant_(plant) {
  if (plant.settings().built_otherwise) lent_.resize(BitImage::words_needed(columns(), rows()));
}

Expected<MaskDisplay::Lent> SimMaskDisplay::do_lend() {
  const SimCall call(plant_);
  // The virtual cost of drawing the mask, whatever the host needs.
  if (plant_.mask_cost() > nanoseconds::zero()) {
    PLUMBLINE_TRY(plant_.wait_until(plant_.now() + plant_.mask_cost(), [] { return false; }));
  }
  if (!lent_.empty()) return Lent{BitImage(lent_, columns(), rows()), &no_greys_};
  return Lent{plant_.panel().back(), &plant_.panel().back_greys()};
}

Status SimMaskDisplay::do_present() {
  if (const auto& otherwise = plant_.settings().built_otherwise) PLUMBLINE_TRY(send_otherwise(*otherwise));
  return show(false);
}

Status SimMaskDisplay::send_otherwise(const BuiltOtherwise& otherwise) {
  const PanelLayout& believed = otherwise.believed;
  const PanelLayout& panel = otherwise.panel;
  if (believed.mode_width() != panel.mode_width() || believed.mode_height() != panel.mode_height()) {
    return fail(ErrorCode::kPanelFailed, "the panel has a mode of %u x %u, but not one of %u x %u:\tcorrect [panel]",
                panel.mode_width(), panel.mode_height(), believed.mode_width(), believed.mode_height());
  }
  const std::uint32_t width = panel.picture_width(), height = panel.mode_height();
  std::vector<std::uint64_t> words(BitImage::words_needed(width, height));
  const BitImage picture(words, width, height);
  const ConstBitImage mask(lent_, columns(), rows());
  for (std::uint32_t row = 0; row < rows(); ++row) {
    for (std::uint32_t column = 0; column < columns(); ++column) {
      if (!mask.at(column, row)) continue;
      const auto to = believed.sent({column, row});
      picture.set(to.column, to.row);
    }
  }
  const BitImage shown = plant_.panel().back();
  shown.clear();
  plant_.panel().back_greys().clear();
  for (std::uint32_t row = 0; row < shown.rows(); ++row) {
    for (std::uint32_t column = 0; column < shown.columns(); ++column) {
      const auto from = panel.sent({column, row});
      if (picture.at(from.column, from.row)) shown.set(column, row);
    }
  }
  return {};
}

Status SimMaskDisplay::show(bool black) {
  const SimCall call(plant_);
  if (plant_.has_fault(FaultKind::kPanelDead)) {
    return fail(ErrorCode::kPanelFailed, "the panel does not answer:\tcheck its cable");
  }
  // Shared, because a slow panel settles after this call.
  const auto settled = std::make_shared<bool>(false);
  plant_.panel().flip(black, [settled] { *settled = true; });
  PLUMBLINE_TRY(plant_.wait_until(plant_.now() + plant_.settings().panel.flip_timeout, [&] { return *settled; }));
  if (!*settled) return fail(ErrorCode::kFlipTimeout, "the panel did not show the mask in time:\tcheck its cable");
  return {};
}

}  // namespace plumbline::inline hal::inline sim
