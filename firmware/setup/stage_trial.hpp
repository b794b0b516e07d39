#pragma once
/// What a jog that somebody has watched says about the stage's drive.

#include <cstdint>

#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

struct Drive {
  double rotation_distance_mm = 0;  ///< as MachineFile
  std::uint32_t full_steps_per_rotation = 0;
  std::uint32_t microsteps = 0;
  bool direction_active_low = false;  ///< of [direction_line], whose on is up

  double step_mm() const { return rotation_distance_mm / (full_steps_per_rotation * microsteps); }
};

/// How far the travel that was seen may be from the one asked for: a caliper's reading of a few mm.
inline constexpr double kSameTravel = 0.03;

/// The drive that explains what was seen. A wrong jumper is likelier than a wrong screw: other microsteps are tried first, then the
/// usual leads of screws, then any.
/// @param asked     of the jog, up is positive, not 0
/// @param moved_mm  what somebody saw, up is positive
/// @returns `drive` itself, but for the direction, if the travel agrees to within kSameTravel
/// @retval ErrorCode::kBadSetting  moved_mm is 0, or more than 1000 times too much or too little
[[nodiscard]] Expected<Drive> drive_for(const Drive& drive, Distance asked, double moved_mm);

}  // namespace plumbline::firmware
