#pragma once
/// The Z stage, which moves the build plate up and down.

#include <cstdint>
#include <optional>
#include <utility>

#include "hal/clock.hpp"
#include "hal/interlock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

class ZStage;

/// The result of a motion.
struct MotionReport {
  TimePoint began_at;
  TimePoint ended_at;
  ZPosition position;    ///< where the stage stopped, by counted steps
  bool arrived = false;  ///< false: it was stopped on its way
  /// When a homed stage is homed again: where the end stop was found, less where it was expected. More than a step or two means
  /// that steps were lost in between. 0 for moves and for the first homing.
  Distance steps_lost;
  /// Homing that arrived: where it began, by the steps to the end stop. After power on this is where the stage stood when the power
  /// went, unless somebody has moved it, to within Limits::drift. Nothing for moves.
  std::optional<ZPosition> began_at_height;
};

/// A moving stage. It brakes and stops when this object is destroyed. Move-only.
class [[nodiscard]] Motion {
 public:
  Motion(Motion&& other) noexcept : stage_(std::exchange(other.stage_, nullptr)) {}
  Motion& operator=(Motion&&) = delete;
  Motion(const Motion&) = delete;
  Motion& operator=(const Motion&) = delete;
  ~Motion();

  /// The latest time at which it ends; exact for a move. stop() brings it forward.
  TimePoint ends_by() const;
  bool over() const;

  /// Starts braking with the stage's acceleration, so that no step is lost. over() is true once the stage has stopped.
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status stop();

  /// Waits for the end of the motion and returns its result; nothing interrupts the wait. Call it once.
  /// @retval ErrorCode::kStageStalled     the motor could not follow; homed() is false
  /// @retval ErrorCode::kEndStopNotFound  homing covered the whole travel; homed() is false
  /// @retval ErrorCode::kEndStopStuck     the end stop is pressed where it can't be; homed() is false
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<MotionReport> finish();

 private:
  friend class ZStage;
  explicit Motion(ZStage& stage) : stage_(&stage) {}

  ZStage* stage_ = nullptr;
};

/// The Z stage. Its end stop is at the top, so that homing moves away from the film: after a power cut there is a part on the
/// plate.
class ZStage {
 public:
  struct Limits {
    ZPosition lowest;           ///< lowest target of a move; 0 where the plate touches the film
    ZPosition highest;          ///< highest target of a move; below the end stop
    ZPosition end_stop;         ///< where the end stop closes
    Speed fastest;              ///< above 0
    Acceleration acceleration;  ///< of every move and of braking; above 0
    /// How far the stage may move while its motor is without power and when it gets it again. A driver that starts takes its motor to
    /// the nearest place of its first phase: up to two full steps.
    Distance drift = {};
  };

  ZStage(const ZStage&) = delete;
  ZStage& operator=(const ZStage&) = delete;
  virtual ~ZStage() = default;

  const Limits& limits() const { return limits_; }
  bool homed() const { return do_homed(); }
  bool moving() const { return do_moving(); }
  bool end_stop_pressed() const { return do_end_stop_pressed(); }

  /// By counted steps, also during a motion.
  /// @retval ErrorCode::kNotHomed
  [[nodiscard]] Expected<ZPosition> position() const;

  /// Finds the end stop: up fast, back off, up slowly. Stops at limits().highest.
  /// @retval ErrorCode::kLampLit    no motion under light
  /// @retval ErrorCode::kBusy       it is already moving
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<Motion> begin_homing();

  /// Moves by a trapezoidal ramp (hal/ramp.hpp). A refused move takes no step.
  /// @retval ErrorCode::kOutsideTravel  target below lowest or above highest
  /// @retval ErrorCode::kBadSetting     speed 0 or less, or above limits().fastest
  /// @retval ErrorCode::kNotHomed, kLampLit, kBusy, kPowerLost
  [[nodiscard]] Expected<Motion> begin_move(ZPosition target, Speed speed);

  /// Legs of a homing: from the end stop back, and up to it again slowly. A board file may have another speed for that.
  static constexpr Distance kBackOff = 2_mm;  ///< more than the braking distance and the switch's hysteresis
  static constexpr Speed kApproachSpeed{
      5};                                  ///< mm/s; faster saves seconds, but brakes longer past the switch (v^2 / 2a)
  static constexpr Speed kFindSpeed{0.5};  ///< mm/s

  /// The longest jog.
  static constexpr Distance kLongestJog = 10_mm;

  /// Moves a short way from where the stage is, slowly, for somebody who watches which way it goes and how far: `plumbline setup`. Nobody
  /// needs to know yet where up is, so it ends when the end stop closes, whichever way it goes; then the report has not arrived.
  /// Afterwards the stage is not homed.
  /// @param distance  up is positive; not 0, at most kLongestJog either way
  /// @retval ErrorCode::kOutsideTravel  0 or too far
  /// @retval ErrorCode::kEndStopStuck   the end stop is pressed already
  /// @retval ErrorCode::kLampLit, kBusy, kPowerLost
  [[nodiscard]] Expected<Motion> begin_jog(Distance distance);

  /// begin_homing() and Motion::finish(). Nothing interrupts it; to handle events meanwhile use await() (hal/await.hpp).
  [[nodiscard]] Expected<MotionReport> home();
  /// begin_move() and Motion::finish(), like home().
  [[nodiscard]] Expected<MotionReport> move_to(ZPosition target, Speed speed);

 protected:
  ZStage(const Limits& limits, Interlock& interlock) : limits_(limits), interlock_(interlock) { interlock.add(*this); }

 private:
  friend class Motion;

  virtual bool do_homed() const = 0;
  virtual bool do_moving() const = 0;
  virtual bool do_end_stop_pressed() const = 0;
  /// Called only when homed.
  virtual ZPosition do_position() const = 0;
  virtual Status do_begin_homing() = 0;
  virtual Status do_begin_move(ZPosition target, Speed speed) = 0;
  virtual Status do_begin_jog(Distance distance, Speed speed) = 0;
  virtual TimePoint do_ends_by() const = 0;
  virtual Status do_stop() = 0;
  /// Waits until the stage has stopped, then reports the last motion.
  virtual Expected<MotionReport> do_finish() = 0;

  Limits limits_;
  Interlock& interlock_;
};

}  // namespace plumbline::inline hal
