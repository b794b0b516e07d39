#pragma once

#include "hal/sim/plant/plant.hpp"

namespace plumbline::inline hal::inline sim {

/// First object in each call of a simulated device. The time since the last call counts as the firmware's computing.
class SimCall {
 public:
  explicit SimCall(Plant& plant) : timeline_(plant.timeline()) { timeline_.enter_call(); }
  ~SimCall() { timeline_.leave_call(); }
  SimCall(const SimCall&) = delete;
  SimCall& operator=(const SimCall&) = delete;

 private:
  Timeline& timeline_;
};

}  // namespace plumbline::inline hal::inline sim
