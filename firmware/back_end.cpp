#include "firmware/back_end.hpp"

#include <unistd.h>

#include <array>
#include <cmath>

#include "hal/linux/lamp_keeper.hpp"
#include "hal/sim/plant.hpp"
#include "hal/sim/sim_machine.hpp"

namespace plumbline {
namespace {

PlantSettings plant_of(const BoardFile& board, const MachineFile& machine, const PrintProfile& profile) {
  PlantSettings plant;
  plant.panel.columns = board.columns;
  plant.panel.rows = board.rows;
  plant.panel.pitch_x_mm = board.pixel_pitch_x_mm;
  plant.panel.pitch_y_mm = board.pixel_pitch_y_mm;
  plant.panel.settling = nanoseconds(static_cast<nanoseconds::rep>(machine.refresh_delay_ms * 1e6));
  const Distance end_stop = Distance::millimetres(machine.end_stop_height_mm);
  plant.stage.step = Distance::millimetres(machine.step_mm());
  plant.stage.start = Distance::millimetres(machine.end_stop_height_mm / 3);
  plant.stage.end_stop = end_stop;
  plant.stage.upper_end = end_stop + 3_mm;
  plant.travel = {.lowest = ZPosition(),
                  .highest = ZPosition(end_stop - Distance::millimetres(kEndStopClearanceMm)),
                  .end_stop = ZPosition(end_stop),
                  .fastest = mm_per_min(machine.max_speed_mm_min),
                  .acceleration = Acceleration(machine.max_acceleration_mm_s2)};
  plant.lamp = {.longest_exposure = nanoseconds(static_cast<nanoseconds::rep>(machine.max_exposure_s * 1e9)),
                .irradiance = Irradiance(machine.power_mw_cm2)};
  // As fast down as up, so that a dose is the time asked for; 0 is not physical.
  const double warm_up_ms = machine.warm_up_ms > 0.01 ? machine.warm_up_ms : 0.01;
  plant.lamp_rise = nanoseconds(static_cast<nanoseconds::rep>(warm_up_ms * 1e6));
  plant.lamp_fall = plant.lamp_rise;
  plant.resin.critical = Dose(profile.critical_energy);
  plant.resin.penetration_mm = profile.penetration_depth;
  return plant;
}

/// The keeper is installed beside the program.
std::string keeper_program() {
  std::array<char, 4096> path{};
  const auto length = ::readlink("/proc/self/exe", path.data(), path.size());
  const std::string_view program(path.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  return std::string(program.substr(0, program.rfind('/') + 1)) + "plumbline-keeper";
}

/// A line that is lit for as long as the simulated lamp is, in the host's time.
class KeptWire final : public LampWire {
 public:
  KeptWire(LampKeeper keeper, double speedup) : keeper_(std::move(keeper)), speedup_(speedup) {}

  bool light(std::chrono::nanoseconds cure) override {
    // A simulation that falls behind ends an exposure late; the line does not wait for it.
    return keeper_.light(nanoseconds(std::llround(static_cast<double>(cure.count()) / speedup_))).has_value();
  }
  // The keeper's deadline holds where it can't be told.
  void darken() noexcept override { static_cast<void>(keeper_.darken()); }

 private:
  LampKeeper keeper_;
  double speedup_;
};

class SimulatedBackEnd final : public BackEnd, public Witness {
 public:
  SimulatedBackEnd(PlantSettings settings, std::unique_ptr<LampWire> wire)
      : wire_(std::move(wire)), plant_(with(settings, wire_.get())), run_(plant_), machine_(run_.machine()) {}

  Machine& machine() override { return machine_; }
  Witness* witness() override { return this; }

  void conclude(bool finished) override { plant_.conclude(finished ? JobEnd::kFinished : JobEnd::kAbandoned); }
  std::vector<std::string> objections() const override {
    std::vector<std::string> texts;
    for (const auto& objection : plant_.objections()) texts.push_back(to_string(objection));
    return texts;
  }
  void for_each_cured_layer(const std::function<void(ZPosition, ConstBitImage)>& visit) const override {
    plant_.part().for_each_layer([&](const CuredLayer& layer, ConstBitImage cured) { visit(layer.z, cured); });
  }
  void plug_stick(const std::string& folder) override { plant_.plug_stick(folder); }
  void pull_stick() override { plant_.pull_stick(); }
  void press(EventKind button) override { plant_.press(button); }

 private:
  static const PlantSettings& with(PlantSettings& settings, LampWire* wire) {
    settings.lamp_wire = wire;
    return settings;
  }

  std::unique_ptr<LampWire> wire_;
  Plant plant_;
  SimMachine run_;
  Machine machine_;
};

}  // namespace

Expected<std::unique_ptr<BackEnd>> open_back_end(const BoardFile& board, const MachineFile& machine,
                                                 const PrintProfile& profile, const SimulationOptions& options) {
  if (!machine.simulated && !options.simulate) {
    return fail(ErrorCode::kUnsupported,
                "printer %s: this build drives simulated printers only; print with --simulate to try it out",
                board.name.c_str());
  }
  PlantSettings settings = plant_of(board, machine, profile);
  for (const auto& text : options.faults) {
    const auto fault = parse_fault(text);
    PLUMBLINE_TRY(fault);
    settings.faults.push_back(*fault);
  }
  settings.pace = {.speedup = options.speedup, .computing = options.computing};
  settings.stick = options.stick;
  settings.keep_part = options.keep_part;
  std::unique_ptr<LampWire> wire;
  if (!options.lamp_line.empty()) {
    if (options.speedup <= 0) {
      return fail(ErrorCode::kBadSetting, "a lamp's line is lit in real time: say how fast with --speedup");
    }
    auto keeper = LampKeeper::start(keeper_program(), options.lamp_line);
    PLUMBLINE_TRY(keeper);
    wire = std::make_unique<KeptWire>(std::move(*keeper), options.speedup);
  }
  return std::make_unique<SimulatedBackEnd>(std::move(settings), std::move(wire));
}

}  // namespace plumbline
