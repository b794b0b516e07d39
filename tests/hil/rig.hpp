#pragma once
/// The real print job on the simulated plant. The printer is so small that a whole print takes milliseconds.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/print/job/mask_renderer.hpp"
#include "firmware/print/loop/print_job.hpp"
#include "firmware/print/print_session.hpp"
#include "hal/sim/sim_machine.hpp"

namespace plumbline::firmware {

using namespace plumbline::literals;

inline constexpr std::uint32_t kRigColumns = 130;
inline constexpr std::uint32_t kRigRows = 64;
inline constexpr double kRigPitchMm = 0.1;

/// A leaning tower with a hole: no two layers have the same mask.
inline bool in_tower(std::uint32_t x, std::uint32_t y, std::uint32_t layer) {
  const std::uint32_t left = 10 + layer;
  const bool hole = x >= left + 10 && x < left + 16 && y >= 20 && y < 30 && layer > 3;
  return x >= left && x < left + 40 && y >= 8 && y < 50 && !hole;
}

/// The R-Rep of in_tower().
class TowerRRep {
 public:
  explicit TowerRRep(std::uint32_t layers) {
    first_.push_back(0);
    const CrossingPacking packing({.columns = kRigColumns, .rows = kRigRows});
    for (std::uint32_t layer = 0; layer < layers; ++layer) {
      for (std::uint32_t y = 0; y < kRigRows; ++y) {
        for (std::uint32_t x = 0; x < kRigColumns; ++x) {
          if (in_tower(x, y, layer) != (layer > 0 && in_tower(x, y, layer - 1)))
            packed_.push_back(packing.packed(y * kRigColumns + x));
        }
      }
      first_.push_back(static_cast<std::uint32_t>(packed_.size()));
    }
    const auto pitch = static_cast<float>(kRigPitchMm);
    rrep_ = {.grid = {.columns = kRigColumns,
                      .rows = kRigRows,
                      .layers = layers,
                      .pitch_x_mm = pitch,
                      .pitch_y_mm = pitch,
                      .layer_height_mm = 0.05F},
             .first = first_,
             .packed = packed_};
  }
  const RRep& rrep() const { return rrep_; }
  /// Of all masks together.
  std::uint64_t pixels() const {
    std::uint64_t count = 0;
    for (std::uint32_t layer = 0; layer < rrep_.grid.layers; ++layer) {
      for (std::uint32_t y = 0; y < kRigRows; ++y) {
        for (std::uint32_t x = 0; x < kRigColumns; ++x) count += in_tower(x, y, layer) ? 1 : 0;
      }
    }
    return count;
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> packed_;
  RRep rrep_;
};

inline MachineFile rig_machine() { return *read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value().machine; }

/// Two bottom layers of 5 s, two faded ones, then 2.5 s.
inline PrintProfile rig_profile() {
  auto profile = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml").value();
  profile.initial_exposure_time = 5;
  profile.bottom_layer_count = 2;
  profile.faded_layers = 2;
  return profile;
}

inline PlantSettings rig_plant() {
  PlantSettings plant;
  const MachineFile machine = rig_machine();
  const PrintProfile profile = rig_profile();
  plant.panel.columns = kRigColumns;
  plant.panel.rows = kRigRows;
  plant.panel.pitch_x_mm = kRigPitchMm;
  plant.panel.pitch_y_mm = kRigPitchMm;
  plant.travel = {.lowest = ZPosition(),
                  .highest = ZPosition(174_mm),
                  .end_stop = ZPosition(175_mm),
                  .fastest = mm_per_min(machine.max_speed_mm_min),
                  .acceleration = Acceleration(machine.max_acceleration_mm_s2),
                  .drift = 20_um};
  plant.stage.end_stop = 175_mm;
  plant.stage.upper_end = 178_mm;
  plant.lamp = {.longest_exposure = std::chrono::seconds(60), .irradiance = Irradiance(machine.power_mw_cm2)};
  plant.resin.critical = Dose(profile.critical_energy);
  plant.resin.penetration_mm = profile.penetration_depth;
  return plant;
}

/// The journal's medium in the plant. Writing a record takes plant time; a power cut during it keeps the bytes written so far.
class PlantStorage final : public JournalStorage {
 public:
  PlantStorage(Plant& plant, std::uint32_t layers) : plant_(plant), medium_(Journal::bytes_needed(layers)) {}

  std::size_t size() const override { return medium_.size(); }
  Status read(std::size_t offset, std::span<std::byte> bytes) override {
    std::copy_n(medium_.begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
    return {};
  }
  Status write(std::size_t offset, std::span<const std::byte> bytes) override {
    if (broken) return fail(ErrorCode::kCannotWrite, "the storage is broken");
    if (drops) return {};
    const auto place = medium_.begin() + static_cast<std::ptrdiff_t>(offset);
    if (bytes.size() > Journal::kRecordBytes) {  // before the print
      std::copy(bytes.begin(), bytes.end(), place);
      return {};
    }
    ++writes_;
    before_.push_back({offset, std::vector<std::byte>(place, place + static_cast<std::ptrdiff_t>(bytes.size()))});
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (writes_ == cut_in_write && i == cut_after_bytes) plant_.cut_power();
      if (!plant_.wait(std::chrono::microseconds(20))) return fail(ErrorCode::kPowerLost, "cut");
      medium_[offset + i] = bytes[i];
    }
    return {};
  }
  Status sync() override {
    return plant_.wait(std::chrono::milliseconds(3)) ? Status() : Status(fail(ErrorCode::kPowerLost, "cut"));
  }
  std::vector<std::byte>& medium() { return medium_; }
  void forget() { std::fill(medium_.begin(), medium_.end(), std::byte{}); }
  std::size_t writes() const { return before_.size(); }
  /// Loses those of the last `count` writes for which `is_lost()` is true, though sync() has called them durable.
  void lose(std::size_t count, const std::function<bool()>& is_lost) {
    for (; count > 0; --count) {
      const Before& last = before_.back();
      if (is_lost()) {
        std::copy(last.bytes.begin(), last.bytes.end(), medium_.begin() + static_cast<std::ptrdiff_t>(last.offset));
      }
      before_.pop_back();
    }
  }

  int cut_in_write = -1;  ///< counted from 1, the first copy of the first record
  std::size_t cut_after_bytes = 0;
  bool broken = false;
  bool drops = false;  ///< each write, without a word

 private:
  struct Before {
    std::size_t offset;
    std::vector<std::byte> bytes;
  };

  Plant& plant_;
  std::vector<std::byte> medium_;
  std::vector<Before> before_;  ///< what each write has replaced
  int writes_ = 0;
};

/// Plays the user: presses start after 10 s of waiting, gives up after an hour.
class RigUser : public PrintObserver {
 public:
  explicit RigUser(Plant& plant) : plant_(plant) {}

  bool update(const PrintStatus& status) override {
    if (states.empty() || states.back() != status.state) {
      states.push_back(status.state);
      since_ = status.now;
    }
    if (updates.empty() || updates.back().note != status.note) noted_at = status.now;
    updates.push_back(status);
    if (on_update) on_update(status);
    const auto waited = status.now - since_;
    if (!status.question.empty()) {
      if (questions.empty() || questions.back() != status.question) questions.emplace_back(status.question);
      if (measures_part && part_is_taller(status)) {
        plant_.press(EventKind::kCancelPressed);
        return true;
      }
    }
    if (on_update) on_update(status);
    const bool waits = status.state == PrintState::kPaused || status.state == PrintState::kFeedMe;
    if (waits && presses_start && waited > std::chrono::seconds(10)) {
      since_ = status.now;
      plant_.press(EventKind::kStartPressed);
    }
    return waited < gives_up_after;
  }
  void checked(Check check, const CheckResult& result) override {
    checks[static_cast<std::size_t>(check)] = result.outcome;
    if (result.outcome == CheckOutcome::kFailed) failed_checks.push_back(check);
  }

  std::function<void(const PrintStatus&)> on_update;
  nanoseconds gives_up_after = std::chrono::hours(1);
  std::vector<PrintStatus> updates;  ///< all; their texts are gone
  TimePoint noted_at;                ///< when the note last changed
  bool presses_start = true;
  bool measures_part = false;          ///< when asked, and cancels if it is taller than it should be
  std::vector<std::string> questions;  ///< of which no two in a row are the same
  std::vector<PrintState> states;      ///< in order
  std::vector<Check> failed_checks;
  std::array<CheckOutcome, kCheckCount> checks{};

 private:
  /// The layer at hand is already there if it had light before the interruption.
  bool part_is_taller(const PrintStatus& status) const {
    const auto& layers = plant_.part().layers();
    return !layers.empty() && layers.back().z > status.height + 10_um;
  }

  Plant& plant_;
  TimePoint since_;
};

/// Plant, storage and memory. Each run() is one process of the firmware, unless same_process says otherwise.
class Rig {
 public:
  static constexpr std::uint32_t kLayers = 40;

  explicit Rig(const PlantSettings& settings = rig_plant(), std::uint32_t layers = kLayers)
      : tower_(layers), plant(settings), storage(plant, layers), user(plant), block_(std::size_t{1} << 20U) {
    plan = plan_print(profile, rig_machine(), 0.05, layers).value();
  }

  /// Starts the print, or resumes it after the journal's last layer.
  PrintReport run() {
    arena_.emplace(std::span(block_));
    if (!machine_ || !same_process) {
      machine_.reset();
      machine_.emplace(plant);
    }
    source_.emplace(MaskStream::create(tower_.rrep(), supports_, *arena_).value());
    masks_ = MaskRenderer::create(wrap ? wrap(*source_) : *source_, plan, *arena_).value();
    auto opened = Journal::open(storage);
    const bool is_new = !opened && opened.error().code() == ErrorCode::kTruncated;
    if (is_new) opened = Journal::create(storage, job_hash, plan.layers);
    EXPECT_TRUE(opened) << opened.error().message();
    journal_ = *opened;
    lines_.assign(most_exposures(plan) + plan.layers + 50, {});
    Machine machine = machine_->machine();
    return run_print(machine, settings(), *masks_, &*journal_, record, lines_, user,
                     is_new ? std::nullopt : std::optional(journal_->last()));
  }

  PrintSettings settings() const {
    PrintSettings settings;
    settings.run = check_plan(plan, "rig", rig_machine()).value();
    const MachineFile machine = rig_machine();
    settings.plan = plan;
    settings.lamp_resume = Celsius(machine.lamp_resume_c);
    settings.lamp_max = Celsius(machine.lamp_max_c);
    settings.resin_min = Celsius(machine.resin_min_c);
    settings.resin_max = Celsius(machine.resin_max_c);
    settings.tank_ml = tank_ml;
    settings.board_max = Celsius(machine.board_max_c);
    settings.pixel_ml = resin_ml(1, kRigPitchMm, kRigPitchMm, 0.05);
    settings.first_layer_pixels = 1;
    settings.cured_pixels = 40U * 42U * plan.layers;
    settings.cure_depth = cure_depth(profile, Irradiance(machine.power_mw_cm2), plan.exposure);
    settings.first_cure_depth = cure_depth(profile, Irradiance(machine.power_mw_cm2), plan.initial_exposure);
    return settings;
  }

  /// A full tank of another size.
  void give_tank(double ml) {
    tank_ml = ml;
    record = MachineRecord(ml);
  }
  /// The next run() begins a new print on an empty plate.
  void begin_anew() {
    plant.conclude(JobEnd::kFinished);
    plant.take_part_off();
    storage.forget();
    ++job_hash;
  }

  /// Resin of all layers that had light since the plate was empty.
  double plant_ml() const {
    std::uint64_t pixels = 0;
    for (const CuredLayer& layer : plant.part().layers()) pixels += layer.pixels;
    return resin_ml(pixels, kRigPitchMm, kRigPitchMm, 0.05);
  }

  /// The part on the plate.
  std::vector<std::vector<std::uint64_t>> part() const {
    std::vector<std::vector<std::uint64_t>> layers;
    plant.part().for_each_layer([&](const CuredLayer&, ConstBitImage cured) {
      layers.emplace_back(cured.words().begin(), cured.words().end());
    });
    return layers;
  }
  std::size_t objections_of(ObjectionKind kind) const {
    const auto all = plant.objections();
    return static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [kind](const Objection& objection) { return objection.kind == kind; }));
  }
  std::string objections() const {
    std::string text;
    for (const auto& objection : plant.objections()) text += to_string(objection) + "\n";
    return text;
  }
  SimMachine& machine() { return *machine_; }

 private:
  TowerRRep tower_;

 public:
  PrintProfile profile = rig_profile();
  PrintPlan plan;
  double tank_ml = 180;
  MachineRecord record{tank_ml};
  Plant plant;
  PlantStorage storage;
  RigUser user;
  std::uint64_t job_hash = 77;
  std::function<MaskSource&(MaskSource&)> wrap;  ///< makes the masks other than the tower's
  bool same_process = false;                     ///< the next run() is in the process of the last one, as in the daemon

 private:
  std::vector<std::byte> block_;
  std::optional<Arena> arena_;
  std::optional<SimMachine> machine_;
  Supports supports_;  ///< none
  std::optional<StreamMasks> source_;
  std::optional<MaskRenderer> masks_;
  std::optional<Journal> journal_;
  std::vector<ExposureLine> lines_;
};

}  // namespace plumbline::firmware
