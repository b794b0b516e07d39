#include "hal/sim/sim_mask_display.hpp"

#include <memory>

#include "hal/sim/sim_call.hpp"

namespace plumbline {

SimMaskDisplay::SimMaskDisplay(Plant& plant, Interlock& interlock)
    : MaskDisplay(plant.settings().panel.columns, plant.settings().panel.rows, interlock), plant_(plant) {}

Expected<BitImage> SimMaskDisplay::do_lend() {
  const SimCall call(plant_);
  // Drawing it takes the firmware that much, whatever the host needs for it.
  if (plant_.mask_cost() > nanoseconds::zero()) {
    PLUMBLINE_TRY(plant_.wait_until(plant_.now() + plant_.mask_cost(), [] { return false; }));
  }
  return plant_.panel().back();
}

Status SimMaskDisplay::show(bool black) {
  const SimCall call(plant_);
  if (plant_.faulty(FaultKind::kPanelDead)) {
    return fail(ErrorCode::kPanelFailed, "the panel does not answer: check its cable");
  }
  // Outlives this call: a panel that is too slow answers after it.
  const auto settled = std::make_shared<bool>(false);
  plant_.panel().flip(black, [settled] { *settled = true; });
  PLUMBLINE_TRY(plant_.wait_until(plant_.now() + plant_.settings().panel.flip_timeout, [&] { return *settled; }));
  if (!*settled) return fail(ErrorCode::kFlipTimeout, "the panel did not take the mask in time: check its cable");
  return {};
}

}  // namespace plumbline
