#pragma once

#include "hal/sim/plant.hpp"

namespace plumbline {

/// Stands at the top of each call of a simulated device: the time since the last one, the firmware has computed.
class SimCall {
 public:
  explicit SimCall(Plant& plant) : timeline_(plant.timeline()) { timeline_.enter_call(); }
  ~SimCall() { timeline_.leave_call(); }
  SimCall(const SimCall&) = delete;
  SimCall& operator=(const SimCall&) = delete;

 private:
  Timeline& timeline_;
};

}  // namespace plumbline
