#pragma once
/// The stage of a board: a thread of its own takes the steps, so that the firmware can compute meanwhile.

#include <array>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/stage/step_leg.hpp"
#include "hal/z_stage.hpp"

namespace plumbline {

class LinuxZStage final : public ZStage {
 public:
  struct Mechanics {
    double step_mm = 0;  ///< of travel for a pulse
    Speed find_speed;    ///< of the second, slow approach of the end stop
  };

  /// @param lines  must outlive it
  LinuxZStage(const Limits& limits, const Mechanics& mechanics, StageLines& lines, Interlock& interlock);
  /// A motion under way slows down first; the motor is let go.
  ~LinuxZStage() override;

  /// Readable when a motion has ended.
  int descriptor() const { return wake_; }
  /// Moves ended motions into the queue.
  void drain(EventQueue& events);
  /// @pre no motion is under way
  StepRecord take_record() { return legs_.take_record(); }
  /// The thread has been given real-time priority.
  bool runs_first() const { return runs_first_; }

 private:
  enum class Order : std::uint8_t { kNone, kMove, kHome, kQuit };

  bool do_homed() const override;
  bool do_moving() const override;
  bool do_end_stop_pressed() const override;
  ZPosition do_position() const override;
  Status do_begin_homing() override;
  Status do_begin_move(ZPosition target, Speed speed) override;
  TimePoint do_ends_by() const override;
  Status do_stop() override;
  Expected<MotionReport> do_finish() override;

  void serve();
  void give(Order order);
  /// The legs of a motion, in the thread. @returns what ended it early, if anything did
  Status move();
  Status home();
  Status approach();
  Status find();
  /// @retval ErrorCode::kCancelled  stopped
  Status leg(Distance way, Speed speed, LegUntil until, StepLegResult& result);
  std::int64_t steps_of(Distance way) const;
  Distance way_of(std::int64_t steps) const;
  ZPosition height_of(std::int64_t count) const;

  Mechanics mechanics_;
  StageLines& lines_;
  StepLegs legs_;
  int wake_ = -1;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Order order_ = Order::kNone;
  bool moving_ = false;
  bool homed_ = false;
  bool was_homed_ = false;
  bool arrived_ = false;
  nanoseconds began_at_{};
  nanoseconds ended_at_{};
  nanoseconds ends_by_{};
  std::int64_t target_ = 0;  // steps, as StepLegs counts them
  Speed speed_;
  Distance steps_lost_;
  Status outcome_;
  std::array<nanoseconds, 8> ended_{};  // not told yet
  std::size_t ended_count_ = 0;
  // Where the stage was at count 0, as far as is known; changed by homing, by the thread.
  ZPosition reference_;

  bool runs_first_ = false;
  std::thread thread_;
};

}  // namespace plumbline
