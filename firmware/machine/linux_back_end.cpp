#include "firmware/machine/linux_back_end.hpp"

#include <unistd.h>

#include <array>
#include <string_view>
#include <utility>

#include "firmware/machine/machine_limits.hpp"
#include "firmware/settings/wiring_file.hpp"
#include "hal/linux/board_parts.hpp"
#include "hal/linux/lamp/lamp_keeper.hpp"
#ifdef PLUMBLINE_HAS_BOARD_DEVICES
#include "hal/linux/examination.hpp"
#include "hal/linux/machine.hpp"
#endif

namespace plumbline::firmware {
namespace {

/// The keeper is installed beside the program.
std::string keeper_program() {
  std::array<char, 4096> path{};
  const auto length = ::readlink("/proc/self/exe", path.data(), path.size());
  const std::string_view program(path.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  return std::string(program.substr(0, program.rfind('/') + 1)) + "plumbline-keeper";
}

class KeeperLampLine final : public KeptLampLine {
 public:
  explicit KeeperLampLine(LampKeeper keeper) : keeper_(std::move(keeper)) {}

  bool light(nanoseconds cure) override { return keeper_.light(cure).has_value(); }
  // A keeper that does not answer is ended, and its line taken.
  void turn_off() noexcept override { static_cast<void>(keeper_.turn_off()); }

 private:
  LampKeeper keeper_;
};

#ifdef PLUMBLINE_HAS_BOARD_DEVICES

LinuxSettings settings_of(const MachineFile& machine) {
  LinuxSettings settings{
      .panel = machine.panel,
      .settling = nanoseconds_of_ms(machine.refresh_delay_ms),
      .travel = travel_limits(machine),
      .mechanics = {.step_mm = machine.step_mm(), .find_speed = mm_per_min(machine.homing_speed_mm_min)},
      .lamp = lamp_limits(machine),
      .keeper = keeper_program(),
      .wiring = machine.wiring};
  if (!machine.has_cover_switch) settings.wiring.cover = LineSettings();
  return settings;
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
                       .standstills = record.standstills,
                       .real_time = devices_->has_real_time_priority(),
                       .memory_locked = devices_->memory_locked()};
  }

 private:
  std::unique_ptr<LinuxMachine> devices_;
  Machine machine_;
};

#else

tl::unexpected<Error> no_board_devices(const BoardFile& board) {
  return fail(
      ErrorCode::kUnsupported,
      "printer %s: this build drives simulated printers only, since libdrm, libgpiod or libusb was missing when "
      "it was configured; print with --simulate to try the printer out",
      board.name.c_str());
}

#endif

}  // namespace

#ifdef PLUMBLINE_HAS_BOARD_DEVICES

Status check_linux_back_end(const BoardFile& board, const MachineFile& machine) {
  auto missing = missing_tables(machine.wiring);
  if (machine.has_cover_switch && !machine.wiring.cover.given()) missing.emplace_back("cover_line");
  if (machine.wiring.screen.given() && machine.wiring.screen.connector.empty()) {
    return fail(ErrorCode::kBadSetting, "printer %s: [screen] has no connector.\tAdd it: board/README.md explains it",
                board.name.c_str());
  }
  if (missing.empty()) return {};
  std::string names;
  for (const auto name : missing) names += (names.empty() ? "[" : ", [") + std::string(name) + "]";
  return fail(ErrorCode::kBadSetting,
              "printer %s: its board file does not say how the printer is wired: %s missing. board/README.md explains "
              "them; with --simulate it prints without a printer",
              board.name.c_str(), names.c_str());
}

Expected<std::unique_ptr<BackEnd>> open_linux_back_end(const BoardFile& /*board*/, const MachineFile& machine) {
  auto devices = LinuxMachine::open(settings_of(machine));
  PLUMBLINE_TRY(devices);
  return std::make_unique<LinuxBackEnd>(std::move(*devices));
}

Expected<std::vector<MachineFinding>> examine_linux_machine(const BoardFile& /*board*/, const MachineFile& machine) {
  return examine_board(settings_of(machine));
}

#else

Status check_linux_back_end(const BoardFile& board, const MachineFile& /*machine*/) { return no_board_devices(board); }

Expected<std::unique_ptr<BackEnd>> open_linux_back_end(const BoardFile& board, const MachineFile& /*machine*/) {
  return no_board_devices(board);
}

Expected<std::vector<MachineFinding>> examine_linux_machine(const BoardFile& board, const MachineFile& /*machine*/) {
  return no_board_devices(board);
}

#endif

std::vector<BoardPart> linux_board_parts() { return list_board_parts(); }

Expected<std::unique_ptr<KeptLampLine>> keep_lamp_line(const std::string& line, const MachineFile& machine) {
  // A simulation that falls behind shortens the pauses and not the exposures, so the light of a minute is not limited.
  const WatchdogSettings& watchdog = machine.wiring.watchdog;
  auto keeper = LampKeeper::start({.program = keeper_program(),
                                   .line = line,
                                   .watchdog = watchdog.device,
                                   .watchdog_timeout = std::chrono::seconds(watchdog.timeout_s),
                                   .limits = {lamp_limits(machine).longest_exposure, LightBudget::kMinute}});
  PLUMBLINE_TRY(keeper);
  return std::make_unique<KeeperLampLine>(std::move(*keeper));
}

}  // namespace plumbline::firmware
