#include "hal/sim/sim_machine.hpp"

#include "hal/sim/sim_call.hpp"

namespace plumbline::inline hal::inline sim {

TimePoint SimClock::do_now() const {
  const SimCall call(plant_);
  return plant_.now();
}

Status SimClock::do_sleep_until(TimePoint deadline) {
  const SimCall call(plant_);
  return plant_.wait_until(deadline, [] { return false; });
}

Expected<std::optional<Event>> SimEvents::do_next_event(TimePoint deadline) {
  const SimCall call(plant_);
  auto& events = plant_.events();
  PLUMBLINE_TRY(plant_.wait_until(deadline, [&] { return !events.empty(); }));
  if (events.empty()) return std::nullopt;
  const Event event = events.front();
  events.pop_front();
  return event;
}

bool SimFrontPanel::do_cover_open() const {
  const SimCall call(plant_);
  return plant_.cover_open();
}

Status SimFrontPanel::do_set_light(PanelLight light, LightState state) {
  lights_[static_cast<std::size_t>(light)] = state;
  return {};
}

Status SimFrontPanel::do_beep(nanoseconds time) {
  if (time > nanoseconds::zero()) ++beeps_;
  return {};
}

Expected<Celsius> SimThermals::do_temperature(TemperatureSite site) const {
  const SimCall call(plant_);
  if (plant_.thermals().dead[static_cast<std::size_t>(site)]) {
    const auto where = to_string(site);
    return fail(ErrorCode::kSensorDead, "the %.*s's temperature sensor does not answer:\tcheck its plug",
                static_cast<int>(where.size()), where.data());
  }
  return plant_.thermals().temperature(plant_.now(), site);
}

Status SimThermals::do_set_fan(Fan fan, double duty) {
  const SimCall call(plant_);
  plant_.thermals().set_fan(plant_.now(), fan, duty);
  return {};
}

FanHealth SimThermals::do_fan_health(Fan fan) const { return plant_.thermals().fan_health(fan); }

SimMachine::SimMachine(Plant& plant)
    : plant_(plant),
      clock_(plant),
      events_(plant),
      mask_(plant, interlock_),
      lamp_(plant, interlock_, clock_),
      stage_(plant, interlock_),
      stick_(plant, interlock_),
      panel_(plant, interlock_),
      thermals_(plant, interlock_) {
  plant_.on_cover_opened = [this] { lamp_.cover_opened(); };
  plant_.on_power_lost = [this] {
    interlock_.lose_power();
    lamp_.power_lost();
  };
  if (!plant_.powered()) interlock_.lose_power();
  plant_.events().clear();  // a new run starts without old events
}

SimMachine::~SimMachine() {
  plant_.on_cover_opened = nullptr;
  plant_.on_power_lost = nullptr;
}

Machine SimMachine::machine() {
  return {.clock = clock_,
          .events = events_,
          .mask = mask_,
          .lamp = lamp_,
          .stage = stage_,
          .stick = stick_,
          .panel = panel_,
          .thermals = thermals_};
}

}  // namespace plumbline::inline hal::inline sim
