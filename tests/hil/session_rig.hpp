#pragma once
/// A whole printer for sessions and the daemon: scan, memory, state folder, plant.

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "firmware/daemon/printer_daemon.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/print_session.hpp"
#include "hal/sim/sim_machine.hpp"
#include "tests/firmware/support/job_fixture.hpp"
#include "tests/hil/rig.hpp"

namespace plumbline::firmware {

inline BoardFile session_board() {
  BoardFile board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml").value();
  board.columns = kRigColumns;
  board.rows = kRigRows;
  board.pixel_pitch_x_mm = kRigPitchMm;
  board.pixel_pitch_y_mm = kRigPitchMm;
  return board;
}

/// The plant of a board file: its panel and its lamp.
inline PlantSettings plant_for(const BoardFile& board) {
  PlantSettings settings = rig_plant();
  settings.panel.columns = board.columns;
  settings.panel.rows = board.rows;
  settings.panel.pitch_x_mm = board.pixel_pitch_x_mm;
  settings.panel.pitch_y_mm = board.pixel_pitch_y_mm;
  settings.lamp.irradiance = Irradiance(board.machine->power_mw_cm2);
  settings.pace.computing = 1;
  return settings;
}

/// For a print on `board` with the default layer height and two threads.
inline SliceSettings slicing_for(const BoardFile& board) {
  SliceSettings settings;
  settings.threads = 2;
  settings.placement.printer = printer_volume(board);
  return settings;
}

/// Slices a scan, and has a session take it.
inline Status slice_into(PrintSession& session, ByteSource& scan, SliceSettings settings,
                         const std::optional<SupportSettings>& supports, const PrintProfile& profile,
                         const MachineFile& machine, Arena& arena, ProgressSink* progress = nullptr) {
  ByteSource* const one[] = {&scan};
  settings.supports = supports;
  auto printable = slice_printable(one, settings, profile, machine, arena, progress);
  PLUMBLINE_TRY(printable);
  return session.take(std::move(*printable));
}

/// Ignores the print.
class Silent final : public PrintObserver {
 public:
  bool update(const PrintStatus& /*status*/) override { return true; }
  void checked(Check /*check*/, const CheckResult& /*result*/) override {}
};

/// Records what the daemon says and does. Its actions run while nothing is being printed, as late as those of a person.
class ScriptedUser final : public DaemonObserver {
 public:
  explicit ScriptedUser(Plant& plant) : plant_(plant) {}

  void say(const PrintableText& text) override {
    said.emplace_back(text.view());
    for (const auto& [word, action] : on_words) {
      if (text.view().find(word) != std::string_view::npos) later(action);
    }
  }
  bool update(const PrintStatus& status) override {
    states.push_back(status.state);
    return true;
  }
  void checked(Check /*check*/, const CheckResult& /*result*/) override {}
  void begins(const Contract& contract) override { contracts.push_back(contract); }
  void printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) override {
    reports.push_back(report);
    profiles.push_back(profile.name);
    scans.emplace_back(view(session.printable().facts.scan));
    ids.push_back(session.printable().facts.print_id);
    hashes.emplace_back();
    for (const auto& line : report.exposures) hashes.back().push_back(line.mask_hash);
    if (on_printed) later(on_printed);
  }
  void slicing(Stage /*stage*/, double /*fraction*/) override {
    if (on_slicing) on_slicing();
  }
  void idle() override {
    if (on_idle) on_idle();
    if (!todo_.empty() && ++waited_ > kTurnsToAct) {
      for (const auto& action : std::exchange(todo_, {})) action();
    }
    if (++idle_turns > 20'000) plant_.press(EventKind::kShutdownRequested);  // over an hour: the script has ended
  }

  /// Drops all records, so that a long test's memory is that of the firmware.
  void forget() {
    said.clear();
    states.clear();
    reports.clear();
    profiles.clear();
    scans.clear();
    hashes.clear();
  }

  std::multimap<std::string, std::function<void()>> on_words;
  std::function<void()> on_printed;
  std::function<void()> on_slicing;  ///< at every look at the child
  std::function<void()> on_idle;     ///< at every turn of a printer at rest
  std::vector<std::string> said;
  std::vector<PrintState> states;
  std::vector<PrintReport> reports;
  std::vector<std::string> profiles;
  std::vector<std::string> scans;
  std::vector<Contract> contracts;
  std::vector<std::uint64_t> ids;
  std::vector<std::vector<std::uint64_t>> hashes;
  int idle_turns = 0;

 private:
  static constexpr int kTurnsToAct = 6;  // of 200 ms: the daemon ignores buttons in the first second after a question

  void later(const std::function<void()>& action) {
    todo_.push_back(action);
    waited_ = 0;
  }

  Plant& plant_;
  std::vector<std::function<void()>> todo_;
  int waited_ = 0;
};

inline PlantSettings session_plant() {
  PlantSettings settings = rig_plant();
  settings.keep_part = false;
  return settings;
}

/// The stick and the state are folders below `folder`. Sticks start their print, unless `start` says otherwise, and somebody has
/// confirmed that the plate is empty.
class DaemonRig {
 public:
  explicit DaemonRig(const PlantSettings& settings = session_plant(), std::size_t arena_bytes = std::size_t{24} << 20U,
                     ChildTask task = run_stick_task)
      : child(SlicingChild::make(arena_bytes, 1, task).value()),
        plant(settings),
        user(plant),
        arena(child.arena_block()) {
    std::filesystem::create_directory(stick());
    std::filesystem::create_directory(state());
    auto remembered = MachineRecord::open(state(), rig_machine().tank_volume_ml);
    EXPECT_TRUE(remembered && remembered->confirm_empty() && remembered->fill(rig_machine().tank_volume_ml));
  }

  std::string stick() const { return folder / "stick"; }
  std::string state() const { return folder / "state"; }
  bool plate_is_empty() const { return MachineRecord::open(state(), 1)->plate_is_empty(); }
  void put_scan(const std::string& name, double radius_mm = 2, std::uint32_t points = 4000) const {
    write_sphere_scan(stick() + "/" + name, points, radius_mm);
    // All equally old, so that they are listed by name.
    std::filesystem::last_write_time(stick() + "/" + name, std::filesystem::file_time_type());
  }

  /// One process of the daemon.
  Status run() {
    auto store = JobStore::open(state());
    EXPECT_TRUE(store) << store.error().message();
    auto remembered = open_machine_record(state(), *store, rig_machine().tank_volume_ml, false);
    EXPECT_TRUE(remembered) << remembered.error().message();
    machine_.reset();
    machine_.emplace(plant);
    Machine machine = machine_->machine();
    DaemonSettings settings{session_board(), rig_machine(), board_path, {}, {}, 1, patience};
    settings.machine.start = start;
    Uploads uploads(UploadStore::open(folder / ".", 0).value(), record);
    PrinterDaemon daemon(machine, settings, child, arena, *store, *remembered, user, record, uploads);
    const auto served = daemon.run();
    fault = daemon.fault();
    return served;
  }

  LightState light(PanelLight light) const { return machine_->panel().light(light); }

  SlicingChild child;  ///< first: made before anything else
  TemporaryFolder folder;
  Plant plant;
  ScriptedUser user;
  StartChoice start = StartChoice::kOnStick;
  std::string board_path = PLUMBLINE_SOURCE_DIR "/board/sim2k.toml";  ///< the profiles are beside it
  FaultCode fault = FaultCode::kNone;
  PrinterRecord record;
  std::chrono::nanoseconds patience = kSlicingPatience;  ///< with a silent child
  Arena arena;

 private:
  std::optional<SimMachine> machine_;
};

}  // namespace plumbline::firmware
