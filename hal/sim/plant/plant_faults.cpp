#include "hal/sim/plant/plant.hpp"

namespace plumbline::inline hal::inline sim {
namespace {

nanoseconds time_of(double seconds) { return nanoseconds(static_cast<nanoseconds::rep>(seconds * 1e9)); }

}  // namespace

void Plant::inject(const Fault& fault) {
  if (fault.layer) {
    waiting_.push_back(fault);
  } else {
    timeline_.at(TimePoint(fault.delay), [this, fault] { activate(fault); });
  }
}

void Plant::trigger_faults(FaultMoment moment, std::uint32_t layer) {
  const auto met = [&](const Fault& fault) {
    if (fault.layer != layer || row_of(fault.kind).moment != moment) return false;
    if (fault.delay == nanoseconds::zero() && moment == FaultMoment::kBeforeLayer) {
      activate(fault);
    } else {
      timeline_.at(now() + fault.delay, [this, fault] { activate(fault); });
    }
    return true;
  };
  std::erase_if(waiting_, met);
}

void Plant::activate(const Fault& fault) {
  active_[static_cast<std::size_t>(fault.kind)] = fault.amount;
  apply(fault.kind, true, fault.amount);
  if (fault.lasts) timeline_.at(now() + *fault.lasts, [this, kind = fault.kind] { deactivate(kind); });
}

void Plant::deactivate(FaultKind kind) {
  active_[static_cast<std::size_t>(kind)].reset();
  apply(kind, false, 0);
}

// Passes on the faults that a model must know. The other faults are checked with has_fault() where they matter.
void Plant::apply(FaultKind kind, bool active, double amount) {
  switch (kind) {
    case FaultKind::kPanelFlipTimeout: panel_.never_flips = active; break;
    case FaultKind::kPanelTorn: panel_.torn = active; break;
    case FaultKind::kPanelStale: panel_.stale = active; break;
    case FaultKind::kPanelSlow: panel_.extra = time_of(amount); break;
    case FaultKind::kStageEndStopStuck: stage_.end_stop_stuck = active; break;
    case FaultKind::kStageEndStopDead: stage_.end_stop_dead = active; break;
    case FaultKind::kStageSkips: stage_.skips = Distance::millimetres(amount); break;
    case FaultKind::kStageStalls: stage_.stalls_at = active ? amount : 2; break;
    case FaultKind::kComputeSlow: extra_mask_cost_ = time_of(amount); break;
    case FaultKind::kCoverOpens:
    case FaultKind::kCoverSwitchDead: active ? open_cover() : close_cover(); break;
    case FaultKind::kStickPulled: active ? pull_stick() : plug_stick(last_stick_); break;
    case FaultKind::kButtonStart:
      if (active) press(EventKind::kStartPressed);
      break;
    case FaultKind::kButtonPause:
      if (active) press(EventKind::kPausePressed);
      break;
    case FaultKind::kButtonCancel:
      if (active) press(EventKind::kCancelPressed);
      break;
    case FaultKind::kSystemShutdown:
      if (active) push_event(EventKind::kShutdownRequested);
      break;
    case FaultKind::kPowerCut:
      if (active) cut_power();
      break;
    case FaultKind::kLampStuckOn:
    case FaultKind::kLampRunaway:
    case FaultKind::kLampDead:
    case FaultKind::kLampWeak:
    case FaultKind::kLampDies:
    case FaultKind::kLampFlickers:
    case FaultKind::kLampSlowRise:
    case FaultKind::kLampUnarmed: drive_lamp(); break;
    case FaultKind::kTemperatureLampHot:
    case FaultKind::kTemperatureLampSensorDead:
    case FaultKind::kTemperatureResinCold:
    case FaultKind::kTemperatureResinHot:
    case FaultKind::kTemperatureResinSensorDead:
    case FaultKind::kTemperatureResinSensorWild:
    case FaultKind::kTemperatureBoardHot:
    case FaultKind::kFanLampStalls:
    case FaultKind::kFanChamberStalls: apply_to_temperatures(kind, active, amount); break;
    case FaultKind::kPanelDead:
    case FaultKind::kResinSticks:
    case FaultKind::kResinWeak:
    case FaultKind::kStickSlow:
    case FaultKind::kStickBadSector:
    case FaultKind::kStickMountFails: break;
  }
}

void Plant::apply_to_temperatures(FaultKind kind, bool active, double amount) {
  const auto force = [&](TemperatureSite site) {
    thermals_.forced[static_cast<std::size_t>(site)] = active ? std::optional(amount) : std::nullopt;
  };
  const auto kill = [&](TemperatureSite site) { thermals_.dead[static_cast<std::size_t>(site)] = active; };
  switch (kind) {
    case FaultKind::kTemperatureLampHot: force(TemperatureSite::kLamp); break;
    case FaultKind::kTemperatureResinCold:
    case FaultKind::kTemperatureResinHot:
    case FaultKind::kTemperatureResinSensorWild: force(TemperatureSite::kResin); break;
    case FaultKind::kTemperatureBoardHot: force(TemperatureSite::kBoard); break;
    case FaultKind::kTemperatureLampSensorDead: kill(TemperatureSite::kLamp); break;
    case FaultKind::kTemperatureResinSensorDead: kill(TemperatureSite::kResin); break;
    case FaultKind::kFanLampStalls: thermals_.set_stalled(now(), Fan::kLamp, active); break;
    case FaultKind::kFanChamberStalls: thermals_.set_stalled(now(), Fan::kChamber, active); break;
    default: break;
  }
}

}  // namespace plumbline::inline hal::inline sim
