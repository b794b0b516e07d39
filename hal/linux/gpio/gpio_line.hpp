#pragma once
/// Lines of GPIO chips. gpio_line.cpp is the one file that knows libgpiod, version 1.6.
///
/// Values are logical: true is on, pressed, open, whatever the voltage. What libgpiod takes from the heap it takes while a line
/// is opened.

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "hal/linux/gpio/line_settings.hpp"
#include "slicer/core/error.hpp"

struct gpiod_line;

namespace plumbline {

/// Looks the line up; requests nothing.
/// @param use  "the lamp", for messages
/// @retval ErrorCode::kBadSetting  the board has no such line
/// @retval ErrorCode::kCannotOpen  its chip can't be opened: the message has the reason
[[nodiscard]] Expected<LinePlace> find_line(const LineSettings& settings, const std::string& use);

/// Who holds the line, as the kernel has it; empty: nobody.
[[nodiscard]] Expected<std::string> holder_of(const LinePlace& place);

/// Gives a line and its chip back.
struct ReleaseLine {
  void operator()(gpiod_line* line) const;
};
using HeldLine = std::unique_ptr<gpiod_line, ReleaseLine>;

class OutputLine {
 public:
  /// @param on  what it is from the moment of the request
  /// @retval ErrorCode::kCannotOpen  busy, no permission, no output: the message has the reason
  [[nodiscard]] static Expected<OutputLine> open(const LinePlace& place, const LineSettings& settings,
                                                 const std::string& use, bool on);

  /// @returns false: the kernel refused; errno has the reason
  [[nodiscard]] bool set(bool on) noexcept;

 private:
  explicit OutputLine(HeldLine line) : line_(std::move(line)) {}
  HeldLine line_;
};

/// An input whose changes are kept by the kernel, 16 of them, with the time of each.
class InputLine {
 public:
  struct Edge {
    bool on = false;
    std::chrono::nanoseconds at{};  ///< CLOCK_MONOTONIC
  };

  /// @retval ErrorCode::kCannotOpen  as above, or the line has no interrupt
  [[nodiscard]] static Expected<InputLine> open(const LinePlace& place, const LineSettings& settings,
                                                const std::string& use);

  /// As it is now; nothing: it can't be read.
  std::optional<bool> on() const noexcept;
  /// The oldest change that was not asked for yet. Never waits.
  std::optional<Edge> next_edge() noexcept;
  /// To wait for with poll(): readable when there is an edge.
  int descriptor() const { return events_; }

 private:
  InputLine(HeldLine line, int events) : line_(std::move(line)), events_(events) {}
  HeldLine line_;
  int events_ = -1;
};

}  // namespace plumbline
