#include "hal/sim/sim_status_screen.hpp"

namespace plumbline::inline hal::inline sim {

Status SimStatusScreen::do_present(std::span<const std::uint16_t> pixels) {
  pixels_.assign(pixels.begin(), pixels.end());
  if (watcher_ != nullptr) watcher_->shown(columns(), rows(), pixels_);
  return {};
}

std::optional<ScreenTouch> SimStatusScreen::do_next_touch() {
  if (touches_.empty()) return std::nullopt;
  const ScreenTouch touch = touches_.front();
  touches_.pop_front();
  return touch;
}

}  // namespace plumbline::inline hal::inline sim
