#include "hal/linux/stage/gpio_stage_lines.hpp"

#include "hal/linux/events/clock.hpp"

namespace plumbline::inline hal::inline linux_board {

bool GpioStageLines::step() noexcept {
  // Drivers need up to 1.9 us high and low (A4988: 1 us, DRV8825: 1.9 us). Spin, because going to sleep takes longer.
  constexpr auto kPulse = std::chrono::microseconds(2);
  if (!step_.set(true)) return false;
  const auto until = monotonic_now() + kPulse;
  while (monotonic_now() < until) {
  }
  return step_.set(false);
}

std::optional<StageLines::Edge> GpioStageLines::next_edge() noexcept {
  const auto edge = end_stop_.next_edge();
  if (!edge) return std::nullopt;
  return Edge{edge->on, edge->at};
}

}  // namespace plumbline::inline hal::inline linux_board
