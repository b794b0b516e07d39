#pragma once
/// The stage's wires on GPIO lines.

#include "hal/linux/gpio/gpio_line.hpp"
#include "hal/linux/stage/stage_lines.hpp"

namespace plumbline::inline hal::inline linux_board {

class GpioStageLines final : public StageLines {
 public:
  /// @param enable  absent: the driver always holds its motor
  GpioStageLines(OutputLine step, OutputLine direction, std::optional<OutputLine> enable, InputLine end_stop)
      : step_(std::move(step)),
        direction_(std::move(direction)),
        enable_(std::move(enable)),
        end_stop_(std::move(end_stop)) {}

  bool enable(bool on) noexcept override { return !enable_ || enable_->set(on); }
  bool set_direction(bool up) noexcept override { return direction_.set(up); }
  bool step() noexcept override;
  bool pressed() const noexcept override { return end_stop_.on().value_or(true); }
  std::optional<Edge> next_edge() noexcept override;

 private:
  OutputLine step_;
  OutputLine direction_;
  std::optional<OutputLine> enable_;
  InputLine end_stop_;
};

}  // namespace plumbline::inline hal::inline linux_board
