#pragma once
/// The cover's switch, as the keeper holds it.

#include <chrono>
#include <optional>

namespace plumbline {

/// Logical levels: which voltage means open is the line's own knowledge.
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

  /// As it is now. A switch that can't be read counts as open.
  virtual bool open() const noexcept = 0;
  /// The oldest change that was not asked for yet, bounces included. Never waits.
  virtual std::optional<Edge> next_edge() noexcept = 0;
  /// To wait for with poll().
  virtual int descriptor() const = 0;
};

}  // namespace plumbline
