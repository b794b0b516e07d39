#pragma once
/// All settings of a board's devices, made from its board file.

#include <string>

#include "hal/linux/stage/z_stage.hpp"
#include "hal/linux/stick/mount_protocol.hpp"
#include "hal/panel_layout.hpp"
#include "hal/uv_lamp.hpp"
#include "hal/wiring.hpp"

namespace plumbline::inline hal::inline linux_board {

struct LinuxSettings {
  PanelLayout panel;
  nanoseconds settling{};  ///< from the end of a scan-out until the pixels have settled
  ZStage::Limits travel;
  LinuxZStage::Mechanics mechanics;
  UvLamp::Limits lamp;
  std::string keeper;  ///< path of plumbline-keeper
  Wiring wiring;       ///< no cover line: the printer has no cover switch
  std::string sysfs = "/sys";
  std::string mount_socket = kMountSocket;
};

}  // namespace plumbline::inline hal::inline linux_board
