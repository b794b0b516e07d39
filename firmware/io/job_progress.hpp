#pragma once
/// Seconds of each stage, and the way to stop: what the slicer, which has no clock, tells the programs.

#include <array>
#include <chrono>

#include "slicer/core/progress.hpp"

namespace plumbline {

/// Who shows the work: a terminal, a log, nobody.
class ProgressDisplay {
 public:
  virtual ~ProgressDisplay() = default;
  virtual void begin(std::string_view stage) = 0;
  /// Often; the display decides how much of it to show.
  /// @param seconds  since begin()
  virtual void update(std::string_view stage, double fraction, double seconds) = 0;
  /// @param peak_bytes  of the arena
  virtual void end(std::string_view stage, double seconds, std::size_t peak_bytes) = 0;
};

/// Measures the stages, asks whether to go on, and passes on to a display.
class JobProgress final : public ProgressSink {
 public:
  /// @param display  may be null
  explicit JobProgress(ProgressDisplay* display) : display_(display) {}

  void begin(Stage stage) override;
  /// @returns false after an interrupt
  bool advance(Stage stage, double fraction) override;
  void end(Stage stage, std::size_t peak_bytes) override;

  const std::array<double, kStageCount>& seconds() const { return seconds_; }  ///< by Stage
  /// Since this object was made.
  double total_seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  double since(Clock::time_point start) const { return std::chrono::duration<double>(Clock::now() - start).count(); }

  ProgressDisplay* display_;
  Clock::time_point made_ = Clock::now();
  Clock::time_point begun_ = made_;
  std::array<double, kStageCount> seconds_ = {};
};

}  // namespace plumbline
