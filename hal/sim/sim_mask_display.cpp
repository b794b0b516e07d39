#include "hal/sim/sim_mask_display.hpp"

#include <memory>

#include "hal/sim/sim_call.hpp"

namespace plumbline {

SimMaskDisplay::SimMaskDisplay(Plant& plant, Interlock& interlock)
    : MaskDisplay(plant.settings().panel.columns, plant.settings().panel.rows, interlock), plant_(plant) {}

Expected<BitImage> SimMaskDisplay::do_lend() {
  const SimCall call(plant_);
  // The virtual cost of drawing the mask, whatever the host needs.
  if (plant_.mask_cost() > nanoseconds::zero()) {
    PLUMBLINE_TRY(plant_.wait_until(plant_.now() + plant_.mask_cost(), [] { return false; }));
  }
  return plant_.panel().back();
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

}  // namespace plumbline
