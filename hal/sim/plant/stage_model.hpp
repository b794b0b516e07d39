#pragma once
/// The stage's mechanics: a motor moves a carriage on a screw between the film and the frame's upper end.

#include <cstdint>
#include <functional>

#include "hal/ramp.hpp"
#include "hal/sim/plant/timeline.hpp"

namespace plumbline::inline hal::inline sim {

/// What ends a leg early.
enum class StageSwitch : std::uint8_t {
  kNone,
  kPressed,   ///< the end stop's edge to pressed
  kReleased,  ///< the end stop's edge to released
};

enum class LegEnd : std::uint8_t {
  kComplete,
  kSwitched,  ///< the end stop switched; the carriage stopped one braking distance later
  kStopped,   ///< by stop()
  kStalled,   ///< blocked: it stopped at once and lost steps
};

/// One ramp from rest to rest.
struct LegResult {
  LegEnd end = LegEnd::kComplete;
  Distance moved;     ///< by motor steps, up is positive
  Distance switched;  ///< the part of `moved` before the end stop's edge
  TimePoint at;
};

class StageModel {
 public:
  struct Build {
    Distance step = Distance::nanometres(1250);  ///< of the motor
    Distance start = 60_mm;                      ///< height of the plate when the plant begins
    Distance end_stop = 172_mm;                  ///< height at which the end stop closes
    Distance upper_end = 175_mm;                 ///< where the carriage meets the frame
  };
  /// A finished leg, for its effect on part and film.
  struct Leg {
    TimePoint began;
    Distance from;  ///< true height
    Distance to;    ///< true height where it ended
    Ramp ramp;
    StageSwitch until = StageSwitch::kNone;
    LegEnd end = LegEnd::kComplete;
    TimePoint passes(Distance height) const;  ///< when it passes a height between from and to
  };

  StageModel(Timeline& timeline, const Build& build) : timeline_(timeline), build_(build), height_(build.start) {}

  /// @param distance  rounded to whole steps, up is positive
  /// @param on_rest   called with the result
  void start(Distance distance, Speed speed, Acceleration acceleration, StageSwitch until,
             std::function<void(const LegResult&)> on_rest);
  /// Brakes. No effect at rest.
  void stop();
  /// Cuts the motor's power: the stage stops at once.
  void cut();
  /// Moves the stage as a motor does that loses its power or gets it back. At rest only.
  void drift(Distance by) { height_ = height_ + by; }

  bool moving() const { return moving_; }
  Distance height() const;                    ///< true height of the plate, also while it moves
  Distance moved() const;                     ///< by the running leg, in motor steps
  TimePoint ends_at() const;                  ///< of the running leg
  bool end_stop_pressed() const;              ///< as the switch says
  Distance rounded(Distance distance) const;  ///< to whole steps

  /// Called after each leg.
  std::function<void(const Leg&)> on_leg;

  // Faults.
  bool end_stop_stuck = false;
  bool end_stop_dead = false;
  Distance skips;        ///< the next complete leg ends this much too low
  double stalls_at = 2;  ///< share of the next leg at which it stalls; above 1: never

 private:
  void schedule();
  void end(LegEnd how);
  Distance stepped(double distance_mm) const;

  Timeline& timeline_;
  Build build_;
  Distance height_;  ///< at rest
  bool moving_ = false;
  bool up_ = false;
  bool stopped_ = false;
  StageSwitch until_ = StageSwitch::kNone;
  Ramp ramp_;
  Distance distance_;  ///< requested
  Distance switched_;  ///< at the edge
  bool edge_ = false;
  TimePoint began_;
  Timeline::Due due_;
  std::function<void(const LegResult&)> on_rest_;
};

}  // namespace plumbline::inline hal::inline sim
