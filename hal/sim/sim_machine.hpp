#pragma once
/// The devices of a plant, as the firmware sees them.

#include <array>

#include "hal/machine.hpp"
#include "hal/sim/plant/plant.hpp"
#include "hal/sim/sim_mask_display.hpp"
#include "hal/sim/sim_stick_port.hpp"
#include "hal/sim/sim_uv_lamp.hpp"
#include "hal/sim/sim_z_stage.hpp"

namespace plumbline::inline hal::inline sim {

class SimClock final : public Clock {
 public:
  explicit SimClock(Plant& plant) : plant_(plant) {}

 private:
  TimePoint do_now() const override;
  Status do_sleep_until(TimePoint deadline) override;

  Plant& plant_;
};

class SimEvents final : public Events {
 public:
  explicit SimEvents(Plant& plant) : plant_(plant) {}

 private:
  Expected<std::optional<Event>> do_next_event(TimePoint deadline) override;

  Plant& plant_;
};

class SimFrontPanel final : public FrontPanel {
 public:
  SimFrontPanel(Plant& plant, Interlock& interlock) : FrontPanel(interlock), plant_(plant) {}

  LightState light(PanelLight light) const { return lights_[static_cast<std::size_t>(light)]; }
  std::uint32_t beeps() const { return beeps_; }

 private:
  bool do_cover_open() const override;
  Status do_set_light(PanelLight light, LightState state) override;
  Status do_beep(nanoseconds time) override;

  Plant& plant_;
  std::array<LightState, kPanelLightCount> lights_{};
  std::uint32_t beeps_ = 0;
};

class SimThermals final : public Thermals {
 public:
  SimThermals(Plant& plant, Interlock& interlock) : Thermals(interlock), plant_(plant) {}

 private:
  Expected<Celsius> do_temperature(TemperatureSite site) const override;
  Status do_set_fan(Fan fan, double duty) override;
  FanHealth do_fan_health(Fan fan) const override;

  Plant& plant_;
};

/// One run of the firmware on a plant, from switching on to switching off. Only one at a time; after a power cut, restore the plant's
/// power and make a new one. Its destructor acts like a killed process: the keeper turns the lamp off and the stage stops.
class SimMachine {
 public:
  /// @param plant  must outlive it
  explicit SimMachine(Plant& plant);
  SimMachine(const SimMachine&) = delete;
  SimMachine& operator=(const SimMachine&) = delete;
  ~SimMachine();

  Machine machine();
  const SimFrontPanel& panel() const { return panel_; }

 private:
  Plant& plant_;
  Interlock interlock_;
  SimClock clock_;
  SimEvents events_;
  SimMaskDisplay mask_;
  SimUvLamp lamp_;
  SimZStage stage_;
  SimStickPort stick_;
  SimFrontPanel panel_;
  SimThermals thermals_;
};

}  // namespace plumbline::inline hal::inline sim
