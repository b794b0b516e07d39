#pragma once
/// References to all devices of one printer. A back end owns the devices.

#include "hal/clock.hpp"
#include "hal/events.hpp"
#include "hal/front_panel.hpp"
#include "hal/mask_display.hpp"
#include "hal/status_screen.hpp"
#include "hal/stick_port.hpp"
#include "hal/thermals.hpp"
#include "hal/uv_lamp.hpp"
#include "hal/z_stage.hpp"

namespace plumbline::inline hal {

struct Machine {
  Clock& clock;
  Events& events;
  MaskDisplay& mask;
  UvLamp& lamp;
  ZStage& stage;
  StickPort& stick;
  FrontPanel& panel;
  Thermals& thermals;
  StatusScreen* screen = nullptr;  ///< null: the printer has none
};

}  // namespace plumbline::inline hal
