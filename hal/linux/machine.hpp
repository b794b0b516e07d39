#pragma once
/// Opens and owns the devices of a board.

#include <memory>
#include <vector>

#include "hal/linux/display/mask_display.hpp"
#include "hal/linux/events/clock.hpp"
#include "hal/linux/events/events.hpp"
#include "hal/linux/events/shutdown_signal.hpp"
#include "hal/linux/front_panel.hpp"
#include "hal/linux/gpio/line_registry.hpp"
#include "hal/linux/lamp/uv_lamp.hpp"
#include "hal/linux/screen/status_screen.hpp"
#include "hal/linux/settings.hpp"
#include "hal/linux/stage/gpio_stage_lines.hpp"
#include "hal/linux/stick/stick_port.hpp"
#include "hal/linux/thermals/thermals.hpp"
#include "hal/machine.hpp"

namespace plumbline::inline hal::inline linux_board {

/// The places of a wiring's lines, which must outlive it.
class BoardLines {
 public:
  struct Line {
    const LineSettings* settings = nullptr;
    std::string use;  ///< "the lamp"
    LinePlace place;
  };

  /// Looks up every given line.
  /// @retval ErrorCode::kBadSetting  a required line is not given, or a line doesn't exist or has two uses
  /// @retval ErrorCode::kCannotOpen  a chip can't be opened
  [[nodiscard]] static Expected<BoardLines> find(const Wiring& wiring);
  /// @returns null if the line is not given
  const Line* of(const LineSettings& settings) const;

 private:
  Status add(const LineRole& role, const LineSettings& settings, LineRegistry& registry);

  std::vector<Line> all_;
};

/// Owns a board's devices. The destructor turns the lamp off and stops the stage.
class LinuxMachine {
 public:
  /// Opens all devices, the lamp first, so that it stays off if another one fails.
  /// @retval the errors of the devices; the message names the device, the problem and what to do
  [[nodiscard]] static Expected<std::unique_ptr<LinuxMachine>> open(const LinuxSettings& settings);
  LinuxMachine(const LinuxMachine&) = delete;
  LinuxMachine& operator=(const LinuxMachine&) = delete;
  ~LinuxMachine();

  Machine machine();
  /// How well the stage met its deadlines since the last call. @pre the stage is at rest
  StepRecord take_step_record() { return stage_->take_record(); }
  /// Whether real-time priority and locked memory were permitted.
  bool has_real_time_priority() const { return stage_->has_real_time_priority(); }
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
  std::unique_ptr<LinuxStatusScreen> screen_;  ///< after the mask's display, whose card it may share
  std::unique_ptr<LinuxFrontPanel> panel_;
  std::vector<std::unique_ptr<Button>> buttons_;
  std::unique_ptr<LinuxThermals> thermals_;
  std::unique_ptr<LinuxStickPort> stick_;
  bool memory_locked_ = false;
};

}  // namespace plumbline::inline hal::inline linux_board
