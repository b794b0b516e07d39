#include "hal/linux/front_panel.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/gpio/edges.hpp"

namespace plumbline::inline hal::inline linux_board {

Button::Button(InputLine line, EventKind kind, EventQueue& events)
    : line_(std::move(line)), kind_(kind), events_(events), contact_(line_.on().value_or(false)) {}

void Button::drain(std::chrono::nanoseconds now) {
  for_each_edge(line_, [&](const InputLine::Edge& edge) {
    if (contact_.update(edge.on, edge.at)) events_.add(kind_, edge.at);
  });
  // The kernel may have dropped the last edges of a long bounce.
  const auto on = line_.on();
  if (on && !contact_.due() && *on != contact_.on() && contact_.update(*on, now)) events_.add(kind_, now);
  static_cast<void>(contact_.settle(now));
}

bool LinuxFrontPanel::do_cover_open() const {
  watch_.drain(monotonic_now());
  return watch_.cover_open();
}

Status LinuxFrontPanel::do_set_light(PanelLight light, LightState state) {
  const auto index = static_cast<std::size_t>(light);
  states_[index] = state;
  auto& line = lines_.lights[index];
  const bool blinks = std::find(states_.begin(), states_.end(), LightState::kBlinking) != states_.end();
  if (!blinks) {
    blink_at_.reset();
  } else if (!blink_at_) {
    blink_at_ = monotonic_now() + kBlink;
    blink_on_ = true;
  }
  if (line && !line->set(state == LightState::kOn || (state == LightState::kBlinking && blink_on_))) {
    return fail(ErrorCode::kDeviceTimeout, "a light of the front panel can't be set: %s", std::strerror(errno));
  }
  return {};
}

Status LinuxFrontPanel::do_beep(nanoseconds time) {
  if (!lines_.buzzer) return {};
  beep_ends_ = monotonic_now() + time;
  if (!lines_.buzzer->set(time > nanoseconds::zero())) {
    return fail(ErrorCode::kDeviceTimeout, "the buzzer can't be set: %s", std::strerror(errno));
  }
  return {};
}

std::optional<std::chrono::nanoseconds> LinuxFrontPanel::due() const {
  if (!beep_ends_) return blink_at_;
  return blink_at_ ? std::min(*beep_ends_, *blink_at_) : *beep_ends_;
}

void LinuxFrontPanel::drain(std::chrono::nanoseconds now) {
  if (beep_ends_ && now >= *beep_ends_) {
    beep_ends_.reset();
    static_cast<void>(lines_.buzzer->set(false));
  }
  if (!blink_at_ || now < *blink_at_) return;
  blink_at_ = now + kBlink;
  blink_on_ = !blink_on_;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (states_[i] == LightState::kBlinking && lines_.lights[i]) {
      static_cast<void>(lines_.lights[i]->set(blink_on_));
    }
  }
}

}  // namespace plumbline::inline hal::inline linux_board
