#pragma once
/// A small display that shows people what the printer does. A printer may have none.

#include <cstdint>
#include <optional>
#include <span>

#include "hal/clock.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

/// Where somebody has touched the screen; (0, 0) is its upper left pixel.
struct ScreenTouch {
  TimePoint at;
  std::uint32_t column = 0, row = 0;
};

/// It takes no part in the interlock: whatever it shows, nothing lights or moves.
class StatusScreen {
 public:
  StatusScreen(const StatusScreen&) = delete;
  StatusScreen& operator=(const StatusScreen&) = delete;
  virtual ~StatusScreen() = default;

  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }

  /// Shows a frame. Copies it and returns: it never waits for the display.
  /// @param pixels  columns() * rows(), row after row from the top: RGB565, red in the highest bits. The back end turns them and converts
  ///                them to what the panel takes
  /// @retval ErrorCode::kPanelFailed  the display does not answer. The printer goes on without it
  [[nodiscard]] Status present(std::span<const std::uint16_t> pixels);

  /// The oldest touch that was not asked for yet; none: there is none.
  std::optional<ScreenTouch> next_touch() { return do_next_touch(); }

 protected:
  StatusScreen(std::uint32_t columns, std::uint32_t rows) : columns_(columns), rows_(rows) {}

 private:
  virtual Status do_present(std::span<const std::uint16_t> pixels) = 0;
  virtual std::optional<ScreenTouch> do_next_touch() = 0;

  std::uint32_t columns_;
  std::uint32_t rows_;
};

}  // namespace plumbline::inline hal
