#include "firmware/machine/machine_limits.hpp"

namespace plumbline::firmware {

nanoseconds nanoseconds_of_ms(double ms) { return nanoseconds(static_cast<nanoseconds::rep>(ms * 1e6)); }

ZStage::Limits travel_limits(const MachineFile& machine) {
  const Distance end_stop = Distance::millimetres(machine.end_stop_height_mm);
  return {.lowest = ZPosition(),
          .highest = ZPosition(end_stop - Distance::millimetres(kEndStopClearanceMm)),
          .end_stop = ZPosition(end_stop),
          .fastest = mm_per_min(machine.max_speed_mm_min),
          .acceleration = Acceleration(machine.max_acceleration_mm_s2),
          .drift = Distance::millimetres(2 * machine.rotation_distance_mm / machine.full_steps_per_rotation)};
}

UvLamp::Limits lamp_limits(const MachineFile& machine) {
  return {.longest_exposure = nanoseconds_of_ms(machine.max_exposure_s * 1e3),
          .irradiance = Irradiance(machine.power_mw_cm2),
          .per_minute = nanoseconds_of_ms(machine.max_light_per_minute_s * 1e3)};
}

}  // namespace plumbline::firmware
