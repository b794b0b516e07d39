#pragma once
/// All that a board's devices need to be told: from the board file.

#include <array>
#include <string>

#include "hal/front_panel.hpp"
#include "hal/linux/display/kms_panel.hpp"
#include "hal/linux/display/panel_layout.hpp"
#include "hal/linux/gpio/line_settings.hpp"
#include "hal/linux/stage/linux_z_stage.hpp"
#include "hal/linux/stick/linux_stick_port.hpp"
#include "hal/linux/thermals/thermal_settings.hpp"
#include "hal/uv_lamp.hpp"

namespace plumbline {

struct LinuxSettings {
  PanelLayout panel;
  nanoseconds settling{};  ///< from the end of a scan-out until the panel's pixels stand
  DisplaySettings display;

  ZStage::Limits travel;
  LinuxZStage::Mechanics mechanics;
  LineSettings step;
  LineSettings direction;  ///< on: up
  LineSettings enable;     ///< not given: the driver always holds its motor
  LineSettings end_stop;   ///< on: pressed

  UvLamp::Limits lamp;
  LineSettings lamp_line;
  LineSettings cover;  ///< on: open; not given: the printer has no switch
  std::string keeper;  ///< path of plumbline-keeper

  LineSettings start_button;  ///< on: pressed; a button that is not given is not there; so with the rest
  LineSettings pause_button;
  LineSettings cancel_button;
  std::array<LineSettings, kPanelLightCount> lights;  ///< by PanelLight
  LineSettings buzzer;

  ThermalSettings thermals;
  StickSettings stick;
  std::string sysfs = "/sys";
};

}  // namespace plumbline
