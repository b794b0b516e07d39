#include "firmware/machine/simulated_back_end.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "firmware/machine/machine_limits.hpp"
#include "firmware/machine/screen_folder.hpp"
#include "hal/sim/part/deviation.hpp"
#include "hal/sim/plant/plant.hpp"
#include "hal/sim/sim_machine.hpp"
#include "hal/sim/sim_status_screen.hpp"

namespace plumbline::firmware {
namespace {

PlantSettings plant_of(const BoardFile& board, const MachineFile& machine, const PrintProfile& profile) {
  PlantSettings plant;
  plant.panel.columns = board.columns;
  plant.panel.rows = board.rows;
  plant.panel.pitch_x_mm = board.pixel_pitch_x_mm;
  plant.panel.pitch_y_mm = board.pixel_pitch_y_mm;
  plant.panel.grey = machine.panel.grey;
  plant.panel.lamp = machine.panel.lamp;
  plant.panel.settling = nanoseconds_of_ms(machine.refresh_delay_ms);
  const Distance end_stop = Distance::millimetres(machine.end_stop_height_mm);
  plant.stage.step = Distance::millimetres(machine.step_mm());
  plant.stage.start = Distance::millimetres(machine.end_stop_height_mm / 3);
  plant.stage.end_stop = end_stop;
  plant.stage.upper_end = end_stop + 3_mm;
  plant.travel = travel_limits(machine);
  plant.travel.drift = Distance();  // an earlier run has left the stage where its journal says
  plant.lamp = lamp_limits(machine);
  // The light falls as fast as it rises, so that the dose matches the requested time. 0 would not be physical.
  const double warm_up_ms = machine.warm_up_ms > 0.01 ? machine.warm_up_ms : 0.01;
  plant.lamp_rise = nanoseconds_of_ms(warm_up_ms);
  plant.lamp_fall = plant.lamp_rise;
  plant.resin.critical = Dose(profile.critical_energy);
  plant.resin.penetration_mm = profile.penetration_depth;
  plant.resin.exchange = profile.exchange.value_or(0);
  plant.resin.blur_px = profile.blur;
  plant.peel = profile.peel;
  return plant;
}

/// Lets a plant that is made as `built` says meet a firmware that believes `machine`.
void build_otherwise(PlantSettings& plant, const MachineFile& machine, const MachineFile& built) {
  const bool reversed = machine.wiring.direction.active_low != built.wiring.direction.active_low;
  plant.built_otherwise = {.believed = machine.panel,
                           .panel = built.panel,
                           .travel_ratio = built.step_mm() / machine.step_mm() * (reversed ? -1 : 1)};
  plant.travel = travel_limits(machine);
  plant.lamp = lamp_limits(machine);
  plant.lamp.irradiance = Irradiance(built.power_mw_cm2);
}

/// Lights a real line for as long as the simulated lamp is lit, in the host's time.
class HostTimeWire final : public LampWire {
 public:
  HostTimeWire(std::unique_ptr<KeptLampLine> line, double speedup) : line_(std::move(line)), speedup_(speedup) {}

  bool light(nanoseconds cure) override {
    // A simulation that falls behind ends an exposure late; the line does not wait for it.
    return line_->light(nanoseconds(std::llround(static_cast<double>(cure.count()) / speedup_)));
  }
  void turn_off() noexcept override { line_->turn_off(); }

 private:
  std::unique_ptr<KeptLampLine> line_;
  double speedup_;
};

/// The size of a screen for which the board file has none.
constexpr std::uint32_t kScreenColumns = 320, kScreenRows = 240;

/// A status screen whose frames go to a folder.
class FolderScreen final : public ScreenWatcher {
 public:
  explicit FolderScreen(std::unique_ptr<ScreenFolder> folder, std::uint32_t columns, std::uint32_t rows)
      : folder_(std::move(folder)), screen_(columns, rows, this) {}

  SimStatusScreen& screen() { return screen_; }
  void shown(std::uint32_t columns, std::uint32_t rows, std::span<const std::uint16_t> pixels) override {
    folder_->write(columns, rows, pixels);
  }

 private:
  std::unique_ptr<ScreenFolder> folder_;
  SimStatusScreen screen_;
};

Expected<std::unique_ptr<FolderScreen>> open_screen(const ScreenSettings& screen, const std::string& folder) {
  const std::uint32_t columns = screen.given() ? screen.columns : kScreenColumns;
  const std::uint32_t rows = screen.given() ? screen.rows : kScreenRows;
  auto frames = ScreenFolder::open(folder, columns, rows);
  PLUMBLINE_TRY(frames);
  return std::make_unique<FolderScreen>(std::move(*frames), columns, rows);
}

class SimulatedBackEnd final : public BackEnd, public Witness {
 public:
  SimulatedBackEnd(PlantSettings settings, std::unique_ptr<LampWire> wire, std::unique_ptr<FolderScreen> screen)
      : wire_(std::move(wire)),
        screen_(std::move(screen)),
        plant_(with_wire(settings, wire_.get())),
        run_(plant_),
        machine_(run_.machine()) {
    if (screen_) machine_.screen = &screen_->screen();
  }

  Machine& machine() override { return machine_; }
  Witness* witness() override { return this; }
  std::optional<StepFigures> take_step_figures() override { return std::nullopt; }

  void conclude(bool finished) override { plant_.conclude(finished ? JobEnd::kFinished : JobEnd::kAbandoned); }
  std::vector<std::string> objections() const override {
    std::vector<std::string> texts;
    for (const auto& objection : plant_.objections()) texts.push_back(to_string(objection));
    return texts;
  }
  PartFigures part_figures() const override {
    const HangingPart& part = plant_.part().hanging();
    PartFigures figures{.largest_peel_n = part.largest_peel_n(),
                        .suction_cm2 = part.largest_suction_mm2() / 100,
                        .traps = part.cavities().traps(),
                        .trapped_ml = part.cavities().trapped_mm3() / 1000,
                        .bleed_ml = part.bleed_mm3() / 1000,
                        .lost = {}};
    for (const Loss& loss : part.losses()) {
      if (loss.joined != Loss::kNone) continue;
      figures.lost.push_back({.kind = to_string(kind_of(loss.kind)),
                              .layer = loss.layer,
                              .last_layer = loss.last_layer,
                              .x_mm = loss.x_mm,
                              .y_mm = loss.y_mm,
                              .ml = loss.ml});
    }
    return figures;
  }
  void for_each_cured_layer(const std::function<void(ZPosition, ConstBitImage)>& visit) const override {
    plant_.part().for_each_layer([&](const CuredLayer& layer, ConstBitImage cured) { visit(layer.z, cured); });
  }
  std::vector<float> deviations_mm(std::span<const OrientedPoint> truth) const override {
    const PlantSettings& plant = plant_.settings();
    const PanelModel::Build& panel = plant.panel;
    DoseModel model{.resin = plant.resin, .pitch_x_mm = panel.pitch_x_mm, .pitch_y_mm = panel.pitch_y_mm};
    if (panel.lamp.known()) {  // as uneven as its board file says
      model.lamp = [&panel](double x_mm, double y_mm) {
        return panel.lamp.at(x_mm / (panel.columns * panel.pitch_x_mm), y_mm / (panel.rows * panel.pitch_y_mm));
      };
    }
    return sim::deviations_mm(plant_.part(), model, truth);
  }
  Sight panel_from_above() override {
    const ConstBitImage mask = plant_.panel().visible();
    Sight seen{mask.columns(), mask.rows(), std::vector<std::uint64_t>(mask.words().size())};
    if (plant_.panel().black()) return seen;
    const BitImage image(seen.words, seen.columns, seen.rows);
    for (std::uint32_t row = 0; row < seen.rows; ++row) {
      for (std::uint32_t column = 0; column < seen.columns; ++column) {
        if (mask.at(column, row)) image.set(seen.columns - 1 - column, row);
      }
    }
    return seen;
  }
  Distance plate_height() override { return plant_.stage().height(); }
  Irradiance irradiance() override { return plant_.settings().lamp.irradiance; }
  bool light() override { return plant_.light(); }

  void take_part_off() override { plant_.take_part_off(); }
  void plug_stick(const std::string& folder) override { plant_.plug_stick(folder); }
  void pull_stick() override { plant_.pull_stick(); }
  void press(EventKind button) override { plant_.press(button); }

 private:
  static const PlantSettings& with_wire(PlantSettings& settings, LampWire* wire) {
    settings.lamp_wire = wire;
    return settings;
  }

  std::unique_ptr<LampWire> wire_;
  std::unique_ptr<FolderScreen> screen_;
  Plant plant_;
  SimMachine run_;
  Machine machine_;
};

}  // namespace

Status check_simulated_back_end(const SimulationOptions& options) {
  for (const auto& text : options.faults) PLUMBLINE_TRY(parse_fault(text));
  return {};
}

Expected<std::unique_ptr<BackEnd>> open_simulated_back_end(const BoardFile& board, const MachineFile& machine,
                                                           const PrintProfile& profile,
                                                           const SimulationOptions& options,
                                                           std::unique_ptr<KeptLampLine> lamp_line) {
  PlantSettings settings =
      options.built ? plant_of(*options.built, *options.built->machine, profile) : plant_of(board, machine, profile);
  if (options.built) build_otherwise(settings, machine, *options.built->machine);
  for (const auto& text : options.faults) {
    const auto fault = parse_fault(text);
    PLUMBLINE_TRY(fault);
    settings.faults.push_back(*fault);
  }
  settings.pace = {.speedup = options.speedup, .computing = options.computing};
  settings.stick = options.stick;
  settings.keep_part = options.keep_part;
  settings.layers_on_plate = options.layers_on_plate;
  settings.height_on_plate = options.height_on_plate;
  if (options.plate_at) settings.stage.start = options.plate_at->above_film();
  std::unique_ptr<LampWire> wire;
  if (lamp_line) wire = std::make_unique<HostTimeWire>(std::move(lamp_line), options.speedup);
  std::unique_ptr<FolderScreen> screen;
  if (!options.screen.empty()) {
    auto opened = open_screen(machine.wiring.screen, options.screen);
    PLUMBLINE_TRY(opened);
    screen = std::move(*opened);
  }
  return std::make_unique<SimulatedBackEnd>(std::move(settings), std::move(wire), std::move(screen));
}

}  // namespace plumbline::firmware
