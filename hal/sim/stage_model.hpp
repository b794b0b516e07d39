#pragma once
/// The stage's mechanics: a motor that moves a carriage along a screw between the film and an upper end.

#include <cstdint>
#include <functional>

#include "hal/ramp.hpp"
#include "hal/sim/timeline.hpp"

namespace plumbline {

/// What ends a leg before its whole way.
enum class StageSwitch : std::uint8_t {
  kNone,
  kPressed,   ///< the end stop's edge to pressed
  kReleased,  ///< the end stop's edge to released
};

enum class LegEnd : std::uint8_t {
  kWholeWay,
  kSwitched,  ///< the end stop came; the carriage stands a braking distance behind
  kStopped,   ///< by stop()
  kStalled,   ///< blocked, at once, and steps are lost
};

/// One ramp from rest to rest.
struct LegResult {
  LegEnd end = LegEnd::kWholeWay;
  Distance moved;     ///< as the motor was stepped, up is positive
  Distance switched;  ///< of it, until the end stop's edge
  TimePoint at;
};

class StageModel {
 public:
  struct Build {
    Distance step = Distance::nanometres(1250);  ///< of the motor
    Distance start = 60_mm;                      ///< height of the plate when the plant begins
    Distance end_stop = 172_mm;                  ///< height at which the switch is pressed
    Distance upper_end = 175_mm;                 ///< where the carriage meets the frame
  };
  /// Heights that a leg passes, for what the part and the film feel.
  struct Leg {
    TimePoint began;
    Distance from;  ///< true height
    Distance to;    ///< true height where it ended
    Ramp ramp;
    StageSwitch until = StageSwitch::kNone;
    LegEnd end = LegEnd::kWholeWay;
    TimePoint passes(Distance height) const;  ///< where `height` is between from and to
  };

  StageModel(Timeline& timeline, const Build& build) : timeline_(timeline), build_(build), height_(build.start) {}

  /// @param way      whole steps, up is positive
  /// @param on_rest  hears how the leg went
  void start(Distance way, Speed speed, Acceleration acceleration, StageSwitch until,
             std::function<void(const LegResult&)> on_rest);
  /// Slows down. No effect at rest.
  void stop();
  /// The motor has lost its power: stands at once.
  void cut();

  bool moving() const { return moving_; }
  Distance height() const;               ///< true height of the plate, at any time
  Distance moved() const;                ///< by the leg that runs, as stepped
  TimePoint ends_at() const;             ///< of the leg that runs
  bool end_stop_pressed() const;         ///< as the switch says
  Distance rounded(Distance way) const;  ///< to whole steps

  /// Hears of each leg when it is over.
  std::function<void(const Leg&)> on_leg;

  // Faults.
  bool end_stop_stuck = false;
  bool end_stop_dead = false;
  Distance skips;        ///< the next leg that goes its way ends that much too low
  double stalls_at = 2;  ///< of the next leg's way; above 1: it does not

 private:
  void schedule();
  void end(LegEnd how);
  Distance stepped(double way_mm) const;

  Timeline& timeline_;
  Build build_;
  Distance height_;  ///< at rest
  bool moving_ = false;
  bool up_ = false;
  bool stopped_ = false;
  StageSwitch until_ = StageSwitch::kNone;
  Ramp ramp_;
  Distance way_;       ///< asked for
  Distance switched_;  ///< at the edge
  bool edge_ = false;
  TimePoint began_;
  Timeline::Due due_;
  std::function<void(const LegResult&)> on_rest_;
};

}  // namespace plumbline
