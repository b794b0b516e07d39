#include <vector>

#include "hal/sim/sim_machine.hpp"
#include "tests/hal/rig.hpp"

namespace plumbline {
namespace {

class SimRig final : public Rig {
 public:
  Machine machine() override { return machine_.machine(); }
  void open_cover(nanoseconds after) override {
    later(after, [this] { plant_.open_cover(); });
  }
  void close_cover(nanoseconds after) override {
    later(after, [this] { plant_.close_cover(); });
  }
  void press(EventKind button, nanoseconds after) override {
    later(after, [this, button] { plant_.press(button); });
  }
  void plug_stick(const std::string& folder, nanoseconds after) override {
    later(after, [this, folder] { plant_.plug_stick(folder); });
  }
  void pull_stick(nanoseconds after) override {
    later(after, [this] { plant_.pull_stick(); });
  }
  bool light() override { return plant_.light(); }
  nanoseconds time_lit() override {
    nanoseconds sum{};
    for (const LightRecord& light : plant_.lights()) sum += light.ended - light.began;
    return sum;
  }
  Distance plate_height() override { return plant_.stage().height(); }

 private:
  void later(nanoseconds after, Timeline::Action action) {
    plant_.timeline().at(plant_.now() + after, std::move(action));
  }

  static PlantSettings settings() {
    PlantSettings settings;
    settings.panel.columns = 100;
    settings.panel.rows = 60;
    settings.panel.grey.levels = 256;
    return settings;
  }
  Plant plant_{settings()};
  SimMachine machine_{plant_};
};

}  // namespace

std::vector<RigMaker> rig_makers() {
  return {{"Sim", [] { return std::make_unique<SimRig>(); }}};
}

}  // namespace plumbline
