#pragma once
/// The keeper's two lines on GPIO chips, and their form on its command line.

#include <optional>
#include <string>
#include <string_view>

#include "hal/linux/gpio/gpio_line.hpp"
#include "hal/linux/keeper/cover_line.hpp"
#include "hal/linux/keeper/lamp_line.hpp"

namespace plumbline::inline hal::inline linux_board {

class GpioLampLine final : public LampLine {
 public:
  explicit GpioLampLine(OutputLine line) : line_(std::move(line)) {}
  ~GpioLampLine() override { static_cast<void>(line_.set(false)); }
  bool set(bool lit) noexcept override { return line_.set(lit); }

 private:
  OutputLine line_;
};

class GpioCoverLine final : public CoverLine {
 public:
  explicit GpioCoverLine(InputLine line) : line_(std::move(line)) {}
  bool open() const noexcept override { return line_.on().value_or(true); }
  std::optional<Edge> next_edge() noexcept override {
    const auto edge = line_.next_edge();
    if (!edge) return std::nullopt;
    return Edge{edge->on, edge->at};
  }
  int descriptor() const override { return line_.descriptor(); }

 private:
  InputLine line_;
};

/// "gpio:gpiochip0:17:high:as-is": the line's place, the voltage that means "on", and its bias.
std::string line_option(const LinePlace& place, const LineSettings& settings);

struct LineOption {
  LinePlace place;
  LineSettings settings;
};
/// Parses what line_option() wrote. @returns nothing for any other text
std::optional<LineOption> parse_line_option(std::string_view text);

}  // namespace plumbline::inline hal::inline linux_board
