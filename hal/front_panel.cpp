#include "hal/front_panel.hpp"

#include <algorithm>

namespace plumbline::inline hal {

Status FrontPanel::set_light(PanelLight light, LightState state) {
  PLUMBLINE_TRY(interlock_.check_power());
  return do_set_light(light, state);
}

Status FrontPanel::beep(nanoseconds time) {
  PLUMBLINE_TRY(interlock_.check_power());
  return do_beep(std::clamp(time, nanoseconds::zero(), kLongestBeep));
}

}  // namespace plumbline::inline hal
