#pragma once
/// Lines of GPIO chips. Only gpio_line.cpp includes libgpiod (version 1.6).
///
/// Values are logical: true means on, pressed or open, at either voltage. libgpiod allocates only while a line is opened.

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/linux/gpio/line_place.hpp"
#include "hal/wiring.hpp"
#include "slicer/core/error.hpp"

struct gpiod_line;

namespace plumbline::inline hal::inline linux_board {

/// Looks a line up without requesting it.
/// @param use  "the lamp", for messages
/// @retval ErrorCode::kBadSetting  the board has no such line
/// @retval ErrorCode::kCannotOpen  its chip can't be opened: the reason
[[nodiscard]] Expected<LinePlace> find_line(const LineSettings& settings, const std::string& use);

/// Who holds the line, according to the kernel; empty: nobody.
[[nodiscard]] Expected<std::string> holder_of(const LinePlace& place);

struct GpioChip {
  struct Line {
    std::uint32_t offset = 0;
    std::string name;    ///< empty: it has none
    std::string holder;  ///< empty: nobody holds it
  };
  std::string name;   ///< "gpiochip0"
  std::string label;  ///< "pinctrl-bcm2711"
  std::vector<Line> lines;
};
/// All chips that this process may open. Requests no line.
std::vector<GpioChip> list_gpio_chips();

/// Releases a line and its chip.
struct ReleaseLine {
  void operator()(gpiod_line* line) const;
};
using HeldLine = std::unique_ptr<gpiod_line, ReleaseLine>;

class OutputLine {
 public:
  /// @param on  its value from the moment of the request
  /// @retval ErrorCode::kCannotOpen  busy, no permission, or not an output: the reason
  [[nodiscard]] static Expected<OutputLine> open(const LinePlace& place, const LineSettings& settings,
                                                 const std::string& use, bool on);

  /// @returns false with errno set if the kernel refused
  [[nodiscard]] bool set(bool on) noexcept;

 private:
  explicit OutputLine(HeldLine line) : line_(std::move(line)) {}
  HeldLine line_;
};

/// An input. The kernel buffers its last changes, up to 16, with the time of each.
class InputLine {
 public:
  struct Edge {
    bool on = false;
    std::chrono::nanoseconds at{};  ///< CLOCK_MONOTONIC
  };

  /// @retval ErrorCode::kCannotOpen  busy, no permission, or without an interrupt: the reason
  [[nodiscard]] static Expected<InputLine> open(const LinePlace& place, const LineSettings& settings,
                                                const std::string& use);

  /// Its present value; nothing if it can't be read.
  std::optional<bool> on() const noexcept;
  /// The oldest unread change. Never waits.
  std::optional<Edge> next_edge() noexcept;
  /// For poll(): readable when there is an edge.
  int descriptor() const { return events_; }

 private:
  InputLine(HeldLine line, int events) : line_(std::move(line)), events_(events) {}
  HeldLine line_;
  int events_ = -1;
};

}  // namespace plumbline::inline hal::inline linux_board
