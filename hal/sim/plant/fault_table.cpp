#include <array>

#include "hal/sim/plant/fault.hpp"

namespace plumbline::inline hal::inline sim {
namespace {

constexpr FaultMoment kBefore = FaultMoment::kBeforeLayer;
constexpr FaultMoment kIn = FaultMoment::kInExposure;

// README.md shows the same table; a test compares the two.
constexpr std::array<FaultRow, kFaultKindCount> kTable = {{
    {FaultKind::kLampStuckOn, "lamp.stuck_on", kBefore, 0, "", 0, 0,
     "once lit, stays on without its line; cutting its supply still works"},
    {FaultKind::kLampRunaway, "lamp.runaway", kBefore, 0, "", 0, 0,
     "like stuck_on, and its supply can't be cut either"},
    {FaultKind::kLampDead, "lamp.dead", kBefore, 0, "", 0, 0, "does not light"},
    {FaultKind::kLampWeak, "lamp.weak", kBefore, 0.8, "of its irradiance", 0, 2, "has a different irradiance"},
    {FaultKind::kLampDies, "lamp.dies", kBefore, 0.5, "s after it is lit", 0, 1000, "goes off during the exposure"},
    {FaultKind::kLampFlickers, "lamp.flickers", kBefore, 0.5, "of its irradiance", 0, 1,
     "falls to that every other 20 ms"},
    {FaultKind::kLampSlowRise, "lamp.slow_rise", kBefore, 0.2, "s to full light", 0.001, 60, "brightens slowly"},
    {FaultKind::kLampUnarmed, "lamp.unarmed", kBefore, 0, "", 0, 0,
     "its keeper does not answer, so off can't be armed"},
    {FaultKind::kPanelFlipTimeout, "panel.flip_timeout", kBefore, 0, "", 0, 0, "never shows the mask"},
    {FaultKind::kPanelTorn, "panel.torn", kBefore, 0, "", 0, 0, "shows half of the mask's rows and reports success"},
    {FaultKind::kPanelStale, "panel.stale", kBefore, 0, "", 0, 0, "keeps showing the old mask and reports success"},
    {FaultKind::kPanelDead, "panel.dead", kBefore, 0, "", 0, 0, "does not answer"},
    {FaultKind::kPanelSlow, "panel.slow", kBefore, 0.2, "s more for each mask", 0, 10,
     "scans out slowly, but in time if below its time limit"},
    {FaultKind::kStageEndStopStuck, "stage.endstop_stuck", kBefore, 0, "", 0, 0, "the end stop is always pressed"},
    {FaultKind::kStageEndStopDead, "stage.endstop_dead", kBefore, 0, "", 0, 0, "the end stop is never pressed"},
    {FaultKind::kStageSkips, "stage.skips", kBefore, 0.2, "mm too low from then on", -100, 100,
     "loses steps in its next move"},
    {FaultKind::kStageStalls, "stage.stalls", kBefore, 0.5, "of the next move", 0, 0.99,
     "is blocked there, which its driver notices"},
    {FaultKind::kResinSticks, "resin.sticks", kBefore, 100, "times the time to peel", 0, 1e6,
     "comes off the film too late"},
    {FaultKind::kResinWeak, "resin.weak", kBefore, 5, "times the critical dose", 0.01, 1000, "cures less deep"},
    {FaultKind::kComputeSlow, "compute.slow", kBefore, 5, "s for each mask", 0, 3600, "the firmware's masks are late"},
    {FaultKind::kCoverOpens, "cover.opens", kIn, 0, "", 0, 0, "opens; with for=, closes again"},
    {FaultKind::kCoverSwitchDead, "cover.switch_dead", kIn, 0, "", 0, 0, "its switch reads open forever"},
    {FaultKind::kStickPulled, "stick.pulled", kIn, 0, "", 0, 0, "is pulled; with for=, plugged in again"},
    {FaultKind::kStickSlow, "stick.slow", kIn, 0.01, "of its speed", 1e-6, 1, "reads slowly"},
    {FaultKind::kStickBadSector, "stick.bad_sector", kIn, 0, "", 0, 0, "can't be read any more"},
    {FaultKind::kStickMountFails, "stick.mount_fails", kIn, 0, "", 0, 0, "its file system can't be mounted"},
    {FaultKind::kTemperatureLampHot, "temperature.lamp_hot", kIn, 95, "degrees", -30, 150, "the LEDs are that hot"},
    {FaultKind::kTemperatureLampSensorDead, "temperature.lamp_sensor_dead", kIn, 0, "", 0, 0, "does not answer"},
    {FaultKind::kTemperatureResinCold, "temperature.resin_cold", kIn, 8, "degrees", -30, 150, "the resin is that cold"},
    {FaultKind::kTemperatureResinHot, "temperature.resin_hot", kIn, 60, "degrees", -30, 150, "the resin is that hot"},
    {FaultKind::kTemperatureResinSensorDead, "temperature.resin_sensor_dead", kIn, 0, "", 0, 0, "does not answer"},
    {FaultKind::kTemperatureResinSensorWild, "temperature.resin_sensor_wild", kIn, 400, "degrees", -1e6, 1e6,
     "reads an impossible value"},
    {FaultKind::kTemperatureBoardHot, "temperature.board_hot", kIn, 105, "degrees", -30, 150,
     "the processor is that hot"},
    {FaultKind::kFanLampStalls, "fan.lamp_stalls", kIn, 0, "", 0, 0, "does not turn"},
    {FaultKind::kFanChamberStalls, "fan.chamber_stalls", kIn, 0, "", 0, 0, "does not turn"},
    {FaultKind::kButtonStart, "button.start", kIn, 0, "", 0, 0, "is pressed: print, resume"},
    {FaultKind::kButtonPause, "button.pause", kIn, 0, "", 0, 0, "is pressed"},
    {FaultKind::kButtonCancel, "button.cancel", kIn, 0, "", 0, 0, "is pressed"},
    {FaultKind::kSystemShutdown, "system.shutdown", kIn, 0, "", 0, 0, "the system asks the firmware to end"},
    {FaultKind::kPowerCut, "power.cut", kIn, 0, "", 0, 0,
     "everything stops where it is; every device returns kPowerLost"},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    if (kTable[i].kind != static_cast<FaultKind>(i)) return false;
  }
  return true;
}
static_assert(in_order(), "row_of() looks the row up by its kind");

}  // namespace

std::span<const FaultRow, kFaultKindCount> fault_table() { return kTable; }

}  // namespace plumbline::inline hal::inline sim
