#include "hal/interlock.hpp"

#include <cassert>

#include "hal/front_panel.hpp"
#include "hal/mask_display.hpp"
#include "hal/uv_lamp.hpp"
#include "hal/z_stage.hpp"

namespace plumbline::inline hal {

Status Interlock::check_power() const {
  if (!powered_) return fail(ErrorCode::kPowerLost, "the power failed:\tresume the job when it is back");
  return {};
}

bool Interlock::lamp_lit() const {
  assert(lamp_ != nullptr);
  return lamp_->lit();
}

bool Interlock::stage_moving() const {
  assert(stage_ != nullptr);
  return stage_->moving();
}

bool Interlock::mask_presented() const {
  assert(mask_ != nullptr);
  return mask_->presented();
}

bool Interlock::cover_open() const {
  assert(panel_ != nullptr);
  return panel_->cover_open();
}

}  // namespace plumbline::inline hal
