#pragma once
/// A touch panel through the kernel's input events.

#include <linux/input.h>

#include <cstdint>
#include <optional>
#include <string>

#include "hal/linux/screen/pack_screen.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Puts the events of a touch together. Pure.
class TouchReader {
 public:
  /// What a panel reports at its edges.
  struct Range {
    std::int32_t low = 0, high = 0;
  };

  TouchReader(const ScreenLayout& layout, Range x, Range y) : layout_(layout), x_range_(x), y_range_(y) {}

  /// @returns the place in the picture where a finger has come down, once for each touch
  std::optional<ScreenPlace> take(const input_event& event);

 private:
  ScreenLayout layout_;
  Range x_range_, y_range_;
  std::int32_t x_ = 0, y_ = 0;
  bool came_down_ = false;  ///< since the last report
};

/// Closes its device.
class TouchPanel {
 public:
  /// @param device  "/dev/input/by-path/...-event"
  /// @retval ErrorCode::kCannotOpen   the reason, or that it is no touch panel
  [[nodiscard]] static Expected<TouchPanel> open(const std::string& device, const ScreenLayout& layout);
  TouchPanel(TouchPanel&& other) noexcept;
  TouchPanel& operator=(TouchPanel&&) = delete;
  ~TouchPanel();

  /// The oldest touch that was not asked for yet. Never waits.
  std::optional<ScreenPlace> next();

 private:
  TouchPanel(int file, const TouchReader& reader) : file_(file), reader_(reader) {}

  int file_;
  TouchReader reader_;
};

}  // namespace plumbline::inline hal::inline linux_board
