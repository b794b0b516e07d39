#pragma once
/// Measures how long each stage takes, shows it, and lets an interrupt stop the work. The slicer itself has no clock.

#include <array>
#include <chrono>

#include "slicer/core/progress.hpp"

namespace plumbline::firmware {

/// Shows the work in progress, on a terminal or in a log.
class ProgressDisplay {
 public:
  virtual ~ProgressDisplay() = default;
  virtual void begin(Stage stage) = 0;
  /// Called often; the display decides how much of it to show.
  /// @param fraction  of the stage, 0 to 1
  /// @param seconds   since begin()
  virtual void update(Stage stage, double fraction, double seconds) = 0;
  /// @param peak_bytes  highest use of the arena in this stage
  virtual void end(Stage stage, double seconds, std::size_t peak_bytes) = 0;
  /// ProgressSink::averages().
  virtual void averages(std::uint32_t /*points*/) {}
  /// ProgressSink::lies_wrong().
  virtual void lies_wrong(double /*x_degrees*/, double /*y_degrees*/) {}
};

/// Measures the stages and passes them on to a display.
class JobProgress final : public ProgressSink {
 public:
  /// @param display  may be null
  explicit JobProgress(ProgressDisplay* display) : display_(display) {}

  void begin(Stage stage) override;
  /// @returns false after an interrupt
  bool advance(Stage stage, double fraction) override;
  void end(Stage stage, std::size_t peak_bytes) override;
  void averages(std::uint32_t points) override {
    if (display_ != nullptr) display_->averages(points);
  }
  void lies_wrong(double x_degrees, double y_degrees) override {
    if (display_ != nullptr) display_->lies_wrong(x_degrees, y_degrees);
  }

  const std::array<double, kStageCount>& seconds() const { return seconds_; }  ///< by Stage
  /// Seconds since this object was made.
  double total_seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  double since(Clock::time_point start) const { return std::chrono::duration<double>(Clock::now() - start).count(); }

  ProgressDisplay* display_;
  Clock::time_point made_ = Clock::now();
  Clock::time_point begun_ = made_;
  std::array<double, kStageCount> seconds_ = {};
};

}  // namespace plumbline::firmware
