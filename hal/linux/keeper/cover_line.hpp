#pragma once
/// The cover switch, held by the keeper.

#include <chrono>
#include <optional>

namespace plumbline::inline hal::inline linux_board {

/// Levels are logical; the line knows which voltage means open.
class CoverLine {
 public:
  struct Edge {
    bool open = false;
    std::chrono::nanoseconds at{};  ///< CLOCK_MONOTONIC
  };

  CoverLine() = default;
  CoverLine(const CoverLine&) = delete;
  CoverLine& operator=(const CoverLine&) = delete;
  virtual ~CoverLine() = default;

  /// Its present state. A switch that can't be read counts as open.
  virtual bool open() const noexcept = 0;
  /// The oldest unread change, including bounces. Never waits.
  virtual std::optional<Edge> next_edge() noexcept = 0;
  /// For poll(): readable when there is a change.
  virtual int descriptor() const = 0;
};

}  // namespace plumbline::inline hal::inline linux_board
