#pragma once
/// The devices of a board, opened.

#include <memory>
#include <vector>

#include "hal/linux/display/linux_mask_display.hpp"
#include "hal/linux/events/linux_clock.hpp"
#include "hal/linux/events/linux_events.hpp"
#include "hal/linux/events/shutdown_signal.hpp"
#include "hal/linux/gpio/line_registry.hpp"
#include "hal/linux/lamp/linux_uv_lamp.hpp"
#include "hal/linux/linux_front_panel.hpp"
#include "hal/linux/linux_settings.hpp"
#include "hal/linux/stage/gpio_stage_lines.hpp"
#include "hal/linux/thermals/linux_thermals.hpp"
#include "hal/machine.hpp"

namespace plumbline {

/// Where each line of the board file is.
struct BoardLines {
  struct Line {
    const LineSettings* settings = nullptr;
    std::string use;  ///< "the lamp"
    LinePlace place;
  };
  std::vector<Line> all;

  /// Looks up every line that is given.
  /// @retval ErrorCode::kBadSetting  a line that must be given is not, is not on this board, or has two uses
  /// @retval ErrorCode::kCannotOpen  a chip can't be opened
  [[nodiscard]] static Expected<BoardLines> find(const LinuxSettings& settings);
  /// @returns null: not given
  const Line* of(const LineSettings& settings) const;
};

/// The lines of the settings with their names, those that are not given included: for whoever looks at each.
std::vector<BoardLines::Line> lines_of(const LinuxSettings& settings);

/// Owns a board's devices. Off and standing when it ends.
class LinuxMachine {
 public:
  /// Opens all devices, the lamp first: what is found wrong leaves it dark.
  /// @retval those of the devices: the message names the device, what was found and what to do
  [[nodiscard]] static Expected<std::unique_ptr<LinuxMachine>> open(const LinuxSettings& settings);
  LinuxMachine(const LinuxMachine&) = delete;
  LinuxMachine& operator=(const LinuxMachine&) = delete;
  ~LinuxMachine();

  Machine machine();
  /// How well the stage's deadlines were kept since this was last asked. @pre it stands
  StepRecord take_step_record() { return stage_->take_record(); }
  /// Real-time priority and locked memory were permitted.
  bool steps_first() const { return stage_->runs_first(); }
  bool memory_locked() const { return memory_locked_; }

 private:
  class StageSource;

  LinuxMachine() = default;
  Status open_lamp(const LinuxSettings& settings, const BoardLines& lines);
  Status open_stage(const LinuxSettings& settings, const BoardLines& lines);
  Status open_panel(const LinuxSettings& settings, const BoardLines& lines);

  EventQueue queue_;
  LinuxEvents events_{queue_};
  Interlock interlock_;
  LinuxClock clock_;
  ShutdownSignal shutdown_{queue_};
  std::unique_ptr<LampWatch> watch_;
  std::unique_ptr<LinuxUvLamp> lamp_;
  std::unique_ptr<GpioStageLines> stage_lines_;
  std::unique_ptr<LinuxZStage> stage_;
  std::unique_ptr<StageSource> stage_source_;
  std::unique_ptr<LinuxMaskDisplay> mask_;
  std::unique_ptr<LinuxFrontPanel> panel_;
  std::vector<std::unique_ptr<Button>> buttons_;
  std::unique_ptr<LinuxThermals> thermals_;
  std::unique_ptr<LinuxStickPort> stick_;
  bool memory_locked_ = false;
};

}  // namespace plumbline
