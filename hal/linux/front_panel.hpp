#pragma once
/// Lights, buzzer and buttons of a board. The keeper watches the cover.

#include <array>
#include <optional>

#include "hal/front_panel.hpp"
#include "hal/linux/gpio/contact.hpp"
#include "hal/linux/gpio/gpio_line.hpp"
#include "hal/linux/lamp/lamp_watch.hpp"

namespace plumbline::inline hal::inline linux_board {

/// A button. Each press causes one event, at the first contact.
class Button final : public EventSource {
 public:
  Button(InputLine line, EventKind kind, EventQueue& events);

  int descriptor() const override { return line_.descriptor(); }
  std::optional<std::chrono::nanoseconds> due() const override { return contact_.due(); }
  void drain(std::chrono::nanoseconds now) override;

 private:
  InputLine line_;
  EventKind kind_;
  EventQueue& events_;
  Contact contact_;
};

/// Setting a light or buzzer that the printer lacks does nothing. Blinking lights and beeps change only while the firmware waits for
/// events; while it computes they stay as they are.
class LinuxFrontPanel final : public FrontPanel, public EventSource {
 public:
  struct Lines {
    std::array<std::optional<OutputLine>, kPanelLightCount> lights;
    std::optional<OutputLine> buzzer;
  };
  static constexpr nanoseconds kBlink = std::chrono::milliseconds(500);  ///< on, and equally long off

  LinuxFrontPanel(Lines lines, LampWatch& watch, Interlock& interlock)
      : FrontPanel(interlock), lines_(std::move(lines)), watch_(watch) {}

  int descriptor() const override { return -1; }
  std::optional<std::chrono::nanoseconds> due() const override;
  void drain(std::chrono::nanoseconds now) override;

 private:
  bool do_cover_open() const override;
  Status do_set_light(PanelLight light, LightState state) override;
  Status do_beep(nanoseconds time) override;

  Lines lines_;
  LampWatch& watch_;
  std::array<LightState, kPanelLightCount> states_{};
  std::optional<nanoseconds> beep_ends_;
  std::optional<nanoseconds> blink_at_;
  bool blink_on_ = false;
};

}  // namespace plumbline::inline hal::inline linux_board
