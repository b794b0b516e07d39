#pragma once
/// The simulated printer: one physical model behind all devices.
///
/// It has two sides. The firmware sees devices (sim_machine.hpp); tests, or whoever plays the user, act on the plant itself.

#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/events.hpp"
#include "hal/panel_layout.hpp"
#include "hal/sim/plant/cured_part.hpp"
#include "hal/sim/plant/fault.hpp"
#include "hal/sim/plant/lamp_model.hpp"
#include "hal/sim/plant/lamp_wire.hpp"
#include "hal/sim/plant/objection.hpp"
#include "hal/sim/plant/panel_model.hpp"
#include "hal/sim/plant/resin.hpp"
#include "hal/sim/plant/stage_model.hpp"
#include "hal/sim/plant/thermal_model.hpp"
#include "hal/sim/plant/timeline.hpp"
#include "hal/uv_lamp.hpp"
#include "hal/z_stage.hpp"

namespace plumbline::inline hal::inline sim {

/// How the printer is built where the firmware's board file is wrong about it.
struct BuiltOtherwise {
  PanelLayout believed;     ///< as the firmware sends its masks
  PanelLayout panel;        ///< as the panel shows them; its mask has the size of PlantSettings::panel
  double travel_ratio = 1;  ///< true travel for the travel that the firmware asks for; negative: the other way. Not 0
};

struct PlantSettings {
  PanelModel::Build panel;
  StageModel::Build stage;
  ZStage::Limits travel{.lowest = ZPosition(),
                        .highest = ZPosition(170_mm),
                        .end_stop = ZPosition(172_mm),
                        .fastest = Speed(10),
                        .acceleration = Acceleration(50)};
  UvLamp::Limits lamp{.longest_exposure = std::chrono::seconds(120), .irradiance = Irradiance(3)};
  nanoseconds lamp_rise{1'000'000};
  nanoseconds lamp_fall{1'000'000};
  Resin resin;
  PeelSettings peel;
  Celsius room = Celsius(25);
  std::string stick;  ///< folder that plays the stick; empty: no stick
  double stick_bytes_per_second = 20e6;
  nanoseconds
      compute_per_mask{};  ///< virtual time that the firmware needs for each mask, in addition to Pace::computing
  Pace pace;
  std::vector<Fault> faults;
  LampWire* lamp_wire = nullptr;                  ///< follows the lamp's line; null: none. Must outlive the plant
  bool keep_part = true;                          ///< needed for part().for_each_layer()
  std::optional<BuiltOtherwise> built_otherwise;  ///< nothing: as the firmware believes
  /// What an earlier plant left on the plate. A print that lights above it resumes that part.
  std::uint32_t layers_on_plate = 0;
  ZPosition height_on_plate;
};

/// One period of light.
struct LightRecord {
  std::uint32_t layer = 0;
  ZPosition z;
  TimePoint began;
  TimePoint ended;
  nanoseconds asked{};  ///< 0: unrequested
  Dose dose;
};

/// How a job ended, which decides how the last layer is judged.
enum class JobEnd : std::uint8_t {
  kFinished,   ///< all layers must be complete
  kAbandoned,  ///< the last layer may be underexposed
};

class Plant {
 public:
  explicit Plant(const PlantSettings& settings);
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  const PlantSettings& settings() const { return settings_; }
  TimePoint now() const { return timeline_.now(); }

  // The user's side.
  void open_cover();
  void close_cover();
  bool cover_open() const { return cover_open_; }
  void plug_stick(const std::string& folder);
  void pull_stick();
  /// Takes out what lies on the film. Whoever opens the cover while the plate is out of the way does that, too.
  void clean_film();
  /// Takes the part off the plate and forgets it with its light: layers count from 0 again. Objections stay. After conclude(), if the
  /// last layer is to be judged.
  void take_part_off();
  void press(EventKind button) { push_event(button); }
  void inject(const Fault& fault);

  // Power. A cut stops everything where it is. From then on every device call returns kPowerLost and takes no time.
  void cut_power();
  /// Switches the power on again; then make a new SimMachine. Cured resin and the stage's height are kept.
  void restore_power();
  bool powered() const { return powered_; }

  /// Lets time pass, such as for writing a file. @returns powered(): false if the power was cut meanwhile
  bool wait(nanoseconds time);

  // Results.
  std::span<const Objection> objections() const { return objections_; }
  const CuredPart& part() const { return part_; }
  std::span<const LightRecord> lights() const { return lights_; }  ///< since the plate was empty
  /// Judges the last layer. Call it once a job, when that is over.
  void conclude(JobEnd end);
  bool light() const { return light_; }

  // The wires, for the back end and for tests that play a faulty one.
  Timeline& timeline() { return timeline_; }
  StageModel& stage() { return stage_; }
  PanelModel& panel() { return panel_; }
  ThermalModel& thermals() { return thermals_; }
  void start_leg(Distance distance, Speed speed, StageSwitch until, std::function<void(const LegResult&)> on_rest);
  /// Announces an exposure; only announced light is judged by its dose.
  void expect_light(nanoseconds asked);
  void lamp_line(bool on);
  void lamp_supply(bool on);
  Dose monitored_dose() const { return monitored_; }  ///< since the last expect_light()
  std::deque<Event>& events() { return events_; }
  void push_event(EventKind kind) { events_.push_back({.at = now(), .kind = kind}); }
  const std::string& stick() const { return stick_; }  ///< empty: none
  std::uint32_t sticks_plugged() const { return sticks_plugged_; }
  nanoseconds mask_cost() const { return settings_.compute_per_mask + extra_mask_cost_; }
  bool has_fault(FaultKind kind) const { return active_[static_cast<std::size_t>(kind)].has_value(); }
  double amount(FaultKind kind) const { return active_[static_cast<std::size_t>(kind)].value_or(0); }

  /// Lets time pass until `enough` returns true or the deadline.
  /// @retval ErrorCode::kPowerLost
  template <class Enough>
  [[nodiscard]] Status wait_until(TimePoint deadline, Enough&& enough) {
    if (powered_) timeline_.advance_until(deadline, [&] { return !powered_ || enough(); });
    return check_power();
  }
  [[nodiscard]] Status check_power() const;

  /// The running SimMachine sets these to react to the world.
  std::function<void()> on_cover_opened;
  std::function<void()> on_power_lost;

 private:
  void raise(ObjectionKind kind, std::string detail);
  void drive_lamp();
  void flicker();
  void begin_light();
  void end_light();
  void cure();
  void judge_last_layer(bool whole);
  void judge_dose(bool whole);
  void hang_last_layer();
  ZPosition above_last_layer() const;
  void on_leg(const StageModel::Leg& leg);
  /// Frees the part from the film if it has pulled for long enough at `time`.
  void peel(TimePoint time);
  void trigger_faults(FaultMoment moment, std::uint32_t layer);
  void activate(const Fault& fault);
  void deactivate(FaultKind kind);
  void apply(FaultKind kind, bool active, double amount);
  void apply_to_temperatures(FaultKind kind, bool active, double amount);
  std::uint32_t layer() const { return first_layer() + part_.layer_at(z()); }
  /// Layers that were cured before this plant began.
  std::uint32_t first_layer() const {
    const ZPosition lowest = part_.layers().empty() ? z() : part_.layers().front().z;
    return lowest > settings_.height_on_plate ? settings_.layers_on_plate : 0;
  }
  ZPosition z() const { return ZPosition(stage_.height()); }

  PlantSettings settings_;
  Timeline timeline_;
  PanelModel panel_;
  StageModel stage_;
  LampModel lamp_;
  ThermalModel thermals_;
  CuredPart part_;
  std::vector<Objection> objections_;
  std::vector<LightRecord> lights_;
  std::deque<Event> events_;
  bool powered_ = true;
  bool cover_open_ = false;
  std::string stick_;
  std::string last_stick_;
  std::uint32_t sticks_plugged_ = 0;

  // The lamp.
  bool line_ = false;
  bool supply_ = true;
  bool latched_ = false;  ///< stuck on: it was lit since the fault began
  bool died_ = false;
  bool dimmed_ = false;
  bool light_ = false;
  nanoseconds asked_{};
  Dose monitored_;
  TimePoint lit_at_;
  std::uint32_t lit_layer_ = 0;
  /// The next layer whose kBeforeLayer faults are still to come.
  std::uint32_t uncured_layer_ = settings_.layers_on_plate + 1;
  Timeline::Due dark_due_;

  // The film.
  std::optional<ZPosition> stuck_at_;
  double stuck_cm2_ = 0;
  std::optional<TimePoint> stretched_since_;
  std::uint32_t judged_ = 0;                    ///< layers
  std::vector<std::size_t> objection_of_loss_;  ///< index of the objection to a loss

  // Faults.
  std::vector<Fault> waiting_;
  std::array<std::optional<double>, kFaultKindCount> active_{};  ///< amount
  nanoseconds extra_mask_cost_{};
};

}  // namespace plumbline::inline hal::inline sim
