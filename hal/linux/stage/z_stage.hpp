#pragma once
/// The stage of a board. A separate thread takes the steps, so that the firmware can compute meanwhile.

#include <array>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/stage/step_leg.hpp"
#include "hal/z_stage.hpp"

namespace plumbline::inline hal::inline linux_board {

class LinuxZStage final : public ZStage {
 public:
  struct Mechanics {
    double step_mm = 0;  ///< travel for one pulse
    Speed find_speed;    ///< of the second, slow approach to the end stop
  };

  /// @param lines  must outlive it
  LinuxZStage(const Limits& limits, const Mechanics& mechanics, StageLines& lines, Interlock& interlock);
  /// Brakes if the stage moves, then releases the motor.
  ~LinuxZStage() override;

  /// For poll(): readable when a motion has ended.
  int descriptor() const { return wake_; }
  /// Adds an event for each motion that has ended.
  void drain(EventQueue& events);
  /// @pre the stage is at rest
  StepRecord take_record() { return legs_.take_record(); }
  /// Whether the thread has real-time priority.
  bool has_real_time_priority() const { return has_real_time_priority_; }

 private:
  enum class Order : std::uint8_t { kNone, kMove, kJog, kHome, kQuit };

  bool do_homed() const override;
  bool do_moving() const override;
  bool do_end_stop_pressed() const override;
  ZPosition do_position() const override;
  Status do_begin_homing() override;
  Status do_begin_move(ZPosition target, Speed speed) override;
  Status do_begin_jog(Distance distance, Speed speed) override;
  TimePoint do_ends_by() const override;
  Status do_stop() override;
  Expected<MotionReport> do_finish() override;

  void run_thread();
  void start(Order order);
  // These run in the thread and return an error for whatever ended the motion early.
  Status move();
  Status jog();
  Status home();
  Status approach();
  Status find_end_stop();
  /// @retval ErrorCode::kCancelled  stopped
  Status run_leg(Distance distance, Speed speed, LegUntil until, StepLegResult& result);
  std::int64_t steps_of(Distance distance) const;
  Distance distance_of(std::int64_t steps) const;
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
  std::int64_t target_ = 0;  // counted steps, see StepLegs::count()
  Speed speed_;
  Distance steps_lost_;
  std::int64_t homed_from_ = 0;  // counted steps before the homing
  std::optional<ZPosition> began_at_height_;
  Status outcome_;
  std::array<nanoseconds, 8> ended_{};  // for drain()
  std::size_t ended_count_ = 0;
  // Height at step count 0. Homing sets it, in the thread.
  ZPosition reference_;

  bool has_real_time_priority_ = false;
  std::thread thread_;
};

}  // namespace plumbline::inline hal::inline linux_board
