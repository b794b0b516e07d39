#include "firmware/machine/back_end.hpp"

#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "hal/linux/lamp/lamp_keeper.hpp"
#ifdef PLUMBLINE_HAS_BOARD_DEVICES
#include "hal/linux/examination.hpp"
#include "hal/linux/linux_machine.hpp"
#endif
#include "hal/sim/plant.hpp"
#include "hal/sim/sim_machine.hpp"

namespace plumbline {
namespace {

nanoseconds milliseconds_of(double ms) { return nanoseconds(static_cast<nanoseconds::rep>(ms * 1e6)); }

ZStage::Limits travel_of(const MachineFile& machine) {
  const Distance end_stop = Distance::millimetres(machine.end_stop_height_mm);
  return {.lowest = ZPosition(),
          .highest = ZPosition(end_stop - Distance::millimetres(kEndStopClearanceMm)),
          .end_stop = ZPosition(end_stop),
          .fastest = mm_per_min(machine.max_speed_mm_min),
          .acceleration = Acceleration(machine.max_acceleration_mm_s2)};
}

UvLamp::Limits lamp_of(const MachineFile& machine) {
  return {.longest_exposure = milliseconds_of(machine.max_exposure_s * 1e3),
          .irradiance = Irradiance(machine.power_mw_cm2)};
}

PlantSettings plant_of(const BoardFile& board, const MachineFile& machine, const PrintProfile& profile) {
  PlantSettings plant;
  plant.panel.columns = board.columns;
  plant.panel.rows = board.rows;
  plant.panel.pitch_x_mm = board.pixel_pitch_x_mm;
  plant.panel.pitch_y_mm = board.pixel_pitch_y_mm;
  plant.panel.settling = milliseconds_of(machine.refresh_delay_ms);
  const Distance end_stop = Distance::millimetres(machine.end_stop_height_mm);
  plant.stage.step = Distance::millimetres(machine.step_mm());
  plant.stage.start = Distance::millimetres(machine.end_stop_height_mm / 3);
  plant.stage.end_stop = end_stop;
  plant.stage.upper_end = end_stop + 3_mm;
  plant.travel = travel_of(machine);
  plant.lamp = lamp_of(machine);
  // As fast down as up, so that a dose is the time asked for; 0 is not physical.
  const double warm_up_ms = machine.warm_up_ms > 0.01 ? machine.warm_up_ms : 0.01;
  plant.lamp_rise = milliseconds_of(warm_up_ms);
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
  std::optional<StepFigures> take_step_figures() override { return std::nullopt; }

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

#ifdef PLUMBLINE_HAS_BOARD_DEVICES

LineSettings line_of(const WireFile& wire) {
  return {.name = wire.line,
          .chip = wire.chip,
          .offset = wire.chip.empty() ? 0 : wire.offset,
          .active_low = wire.active == WireFile::Active::kLow,
          .bias = static_cast<LineBias>(wire.bias)};
}

LinuxSettings settings_of(const BoardFile& board, const MachineFile& machine) {
  const WiringFile& wiring = machine.wiring;
  LinuxSettings settings;
  settings.panel = {.columns = board.columns,
                    .rows = board.rows,
                    .rotation_deg = machine.rotation_deg,
                    .mirror = static_cast<PanelLayout::Mirror>(machine.mirror),
                    .rgb = machine.packing == PixelPacking::kRgb};
  settings.settling = milliseconds_of(machine.refresh_delay_ms);
  settings.display = {.card = wiring.card,
                      .connector = wiring.connector,
                      .refresh_hz = wiring.refresh_hz,
                      .plane = wiring.plane,
                      .flip_timeout = milliseconds_of(wiring.flip_timeout_ms)};
  settings.travel = travel_of(machine);
  settings.mechanics = {.step_mm = machine.step_mm(), .find_speed = mm_per_min(machine.homing_speed_mm_min)};
  settings.step = line_of(wiring.step);
  settings.direction = line_of(wiring.direction);
  settings.enable = line_of(wiring.enable);
  settings.end_stop = line_of(wiring.end_stop);
  settings.lamp = lamp_of(machine);
  settings.lamp_line = line_of(wiring.lamp);
  if (machine.has_cover_switch) settings.cover = line_of(wiring.cover);
  settings.keeper = keeper_program();
  settings.start_button = line_of(wiring.start);
  settings.pause_button = line_of(wiring.pause);
  settings.cancel_button = line_of(wiring.cancel);
  for (std::size_t i = 0; i < kPanelLightCount; ++i) settings.lights[i] = line_of(wiring.lights[i]);
  settings.buzzer = line_of(wiring.buzzer);
  for (std::size_t i = 0; i < kTemperatureSiteCount; ++i) {
    const SensorFile& sensor = wiring.sensors[i];
    settings.thermals.sensors[i] = {sensor.hwmon, sensor.channel, sensor.thermal_zone, sensor.file};
  }
  for (std::size_t i = 0; i < kFanCount; ++i) {
    const FanFile& fan = wiring.fans[i];
    settings.thermals.fans[i] = {fan.hwmon, fan.channel, fan.pwm_chip, fan.period_us};
  }
  settings.stick = {.port = wiring.stick_port, .mount_point = wiring.mount_point};
  return settings;
}

/// @retval ErrorCode::kBadSetting  tables without which the printer can't be driven
Status check_wired(const BoardFile& board, const MachineFile& machine) {
  auto missing = machine.wiring.missing();
  if (machine.has_cover_switch && !machine.wiring.cover.given()) missing.emplace_back("cover_line");
  if (missing.empty()) return {};
  std::string names;
  for (const auto name : missing) names += (names.empty() ? "[" : ", [") + std::string(name) + "]";
  return fail(ErrorCode::kBadSetting,
              "printer %s: its board file does not say how the printer is wired: %s missing. board/README.md explains "
              "them; with --simulate it prints without a printer",
              board.name.c_str(), names.c_str());
}

class LinuxBackEnd final : public BackEnd {
 public:
  explicit LinuxBackEnd(std::unique_ptr<LinuxMachine> devices)
      : devices_(std::move(devices)), machine_(devices_->machine()) {}

  Machine& machine() override { return machine_; }
  Witness* witness() override { return nullptr; }
  std::optional<StepFigures> take_step_figures() override {
    const StepRecord record = devices_->take_step_record();
    return StepFigures{.steps = record.steps,
                       .late = record.late,
                       .worst_lateness = record.worst,
                       .standstills = record.restarts,
                       .real_time = devices_->steps_first(),
                       .memory_locked = devices_->memory_locked()};
  }

 private:
  std::unique_ptr<LinuxMachine> devices_;
  Machine machine_;
};

Expected<std::unique_ptr<BackEnd>> open_board(const BoardFile& board, const MachineFile& machine) {
  PLUMBLINE_TRY(check_wired(board, machine));
  auto devices = LinuxMachine::open(settings_of(board, machine));
  PLUMBLINE_TRY(devices);
  return std::make_unique<LinuxBackEnd>(std::move(*devices));
}

#else

tl::unexpected<Error> no_board(const BoardFile& board) {
  return fail(
      ErrorCode::kUnsupported,
      "printer %s: this build drives simulated printers only, since libdrm, libgpiod or libusb was missing when "
      "it was configured; print with --simulate to try the printer out",
      board.name.c_str());
}

Expected<std::unique_ptr<BackEnd>> open_board(const BoardFile& board, const MachineFile& /*machine*/) {
  return no_board(board);
}

#endif

}  // namespace

Expected<std::vector<MachineFinding>> examine_machine(const BoardFile& board, const MachineFile& machine) {
  if (machine.simulated) {
    return fail(ErrorCode::kUnsupported, "printer %s is a simulated one: there is no board to look at",
                board.name.c_str());
  }
#ifdef PLUMBLINE_HAS_BOARD_DEVICES
  std::vector<MachineFinding> findings;
  for (auto& one : examine_board(settings_of(board, machine))) {
    findings.push_back({static_cast<MachineFinding::Verdict>(one.verdict), std::move(one.what), std::move(one.found),
                        std::move(one.advice)});
  }
  return findings;
#else
  return no_board(board);
#endif
}

Expected<std::unique_ptr<BackEnd>> open_back_end(const BoardFile& board, const MachineFile& machine,
                                                 const PrintProfile& profile, const SimulationOptions& options) {
  if (!machine.simulated && !options.simulate) return open_board(board, machine);
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
