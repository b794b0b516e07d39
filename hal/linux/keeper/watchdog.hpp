#pragma once
/// The board's watchdog, which resets the board unless it is fed.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Runs from the moment it is opened, also when this object is destroyed. Move-only.
class Watchdog {
 public:
  /// Fed this often. Far below the shortest time of a board file, 2 s.
  static constexpr std::chrono::milliseconds kFeedEvery{250};

  /// @param device   "/dev/watchdog0"; "file:PATH", for tests, is a file or FIFO to which the same bytes go
  /// @param timeout  whole seconds until it resets the board
  /// @retval ErrorCode::kCannotOpen  missing, busy, no permission, or no watchdog
  /// @retval ErrorCode::kBadSetting  it can't do with so short a timeout: it says which it can
  [[nodiscard]] static Expected<Watchdog> open(std::string_view device, std::chrono::seconds timeout);
  Watchdog(Watchdog&& other) noexcept;
  Watchdog& operator=(Watchdog&&) = delete;
  ~Watchdog();

  void feed() noexcept;
  /// Stops it, if its driver lets it be stopped.
  void disarm() noexcept;

 private:
  explicit Watchdog(int file) : file_(file) {}
  int file_ = -1;
};

}  // namespace plumbline::inline hal::inline linux_board
