#include "firmware/machine/machine_limits.hpp"

#include <gtest/gtest.h>

namespace plumbline::firmware {
namespace {

using namespace plumbline::literals;

TEST(MachineLimits, LetAMotorWithoutPowerTurnByTwoFullSteps) {
  MachineFile machine;
  machine.rotation_distance_mm = 4;
  machine.full_steps_per_rotation = 200;
  machine.microsteps = 16;
  EXPECT_EQ(travel_limits(machine).drift, 40_um);
}

}  // namespace
}  // namespace plumbline::firmware
