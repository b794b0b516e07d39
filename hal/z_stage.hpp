#pragma once
/// The stage that carries the build plate up and down.

#include <cstdint>
#include <utility>

#include "hal/clock.hpp"
#include "hal/interlock.hpp"
#include "hal/units.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

class ZStage;

/// What a motion has been.
struct MotionReport {
  TimePoint began_at;
  TimePoint ended_at;
  ZPosition at;          ///< where the stage stands, by the steps counted
  bool arrived = false;  ///< false: it was stopped on its way
  /// Homing of a stage that had been homed: where the end stop was found, less where it should have been. More than a step or
  /// two says that steps were lost since. 0 for moves and for a first homing.
  Distance steps_lost;
};

/// A stage that moves. It slows down and stands when this object ends. Move-only.
class [[nodiscard]] Motion {
 public:
  Motion(Motion&& other) noexcept : stage_(std::exchange(other.stage_, nullptr)) {}
  Motion& operator=(Motion&&) = delete;
  Motion(const Motion&) = delete;
  Motion& operator=(const Motion&) = delete;
  ~Motion();

  /// The latest end; for a move the exact one. Earlier after stop().
  TimePoint ends_by() const;
  bool over() const;

  /// Slows down with the stage's acceleration from now on, losing no step. over() follows.
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status stop();

  /// Waits for the rest of the motion, which nothing interrupts, and looks how it went. The object is spent.
  /// @retval ErrorCode::kStageStalled     the motor could not follow; homed() is false
  /// @retval ErrorCode::kEndStopNotFound  homing went its whole way; homed() is false
  /// @retval ErrorCode::kEndStopStuck     the end stop is pressed where it can't be; homed() is false
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<MotionReport> finish();

 private:
  friend class ZStage;
  explicit Motion(ZStage& stage) : stage_(&stage) {}

  ZStage* stage_ = nullptr;
};

/// The stage. The end stop is at the top, so that homing moves a half-made part away from the film: after a power cut there is
/// one on the plate.
class ZStage {
 public:
  struct Limits {
    ZPosition lowest;           ///< of moves; 0 where the plate touches the film
    ZPosition highest;          ///< of moves; below the end stop
    ZPosition end_stop;         ///< where homing finds itself
    Speed fastest;              ///< above 0
    Acceleration acceleration;  ///< of every move, up and down; above 0
  };

  ZStage(const ZStage&) = delete;
  ZStage& operator=(const ZStage&) = delete;
  virtual ~ZStage() = default;

  const Limits& limits() const { return limits_; }
  bool homed() const { return do_homed(); }
  bool moving() const { return do_moving(); }
  bool end_stop_pressed() const { return do_end_stop_pressed(); }

  /// By the steps counted, also while it moves.
  /// @retval ErrorCode::kNotHomed
  [[nodiscard]] Expected<ZPosition> position() const;

  /// Finds the end stop: up fast, back off, up slowly. Ends at limits().highest.
  /// @retval ErrorCode::kLampLit    no motion under light
  /// @retval ErrorCode::kBusy       it moves already
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<Motion> begin_homing();

  /// Moves by a trapezoidal ramp (hal/ramp.hpp). The target is checked before the first step.
  /// @retval ErrorCode::kOutsideTravel  below lowest or above highest; it did not move
  /// @retval ErrorCode::kBadSetting     speed 0, less, or above limits().fastest; it did not move
  /// @retval ErrorCode::kNotHomed, kLampLit, kBusy, kPowerLost
  [[nodiscard]] Expected<Motion> begin_move(ZPosition target, Speed speed);

  /// begin_homing() and Motion::finish(): nothing interrupts it. The print loop uses await() in hal/await.hpp.
  [[nodiscard]] Expected<MotionReport> home();
  /// begin_move() and Motion::finish(); see home().
  [[nodiscard]] Expected<MotionReport> move_to(ZPosition target, Speed speed);

 protected:
  ZStage(const Limits& limits, Interlock& interlock) : limits_(limits), interlock_(interlock) {
    interlock.enter(*this);
  }

 private:
  friend class Motion;

  virtual bool do_homed() const = 0;
  virtual bool do_moving() const = 0;
  virtual bool do_end_stop_pressed() const = 0;
  /// Called only when homed.
  virtual ZPosition do_position() const = 0;
  virtual Status do_begin_homing() = 0;
  virtual Status do_begin_move(ZPosition target, Speed speed) = 0;
  virtual TimePoint do_ends_by() const = 0;
  virtual Status do_stop() = 0;
  /// Waits until the stage stands, then says how the last motion went.
  virtual Expected<MotionReport> do_finish() = 0;

  Limits limits_;
  Interlock& interlock_;
};

}  // namespace plumbline
