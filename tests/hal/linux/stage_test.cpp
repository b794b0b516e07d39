/// Step deadlines and homing, on a simulated stage in real time.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/gpio/edges.hpp"
#include "hal/linux/stage/z_stage.hpp"
#include "hal/mask_display.hpp"
#include "hal/uv_lamp.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

constexpr double kStep = 0.02;  // mm

/// Counts steps and closes its end stop at a height.
class FakeLines final : public StageLines {
 public:
  bool enable(bool on) noexcept override {
    enabled = on;
    return true;
  }
  bool set_direction(bool up) noexcept override {
    up_ = up;
    return !broken;
  }
  bool step() noexcept override {
    const std::scoped_lock lock(mutex_);
    height += up_ != reversed ? 1 : -1;
    taken.push_back(monotonic_now());
    touch();
    return !broken;
  }
  bool pressed() const noexcept override {
    const std::scoped_lock lock(mutex_);
    return pressed_;
  }
  std::optional<Edge> next_edge() noexcept override {
    const std::scoped_lock lock(mutex_);
    if (edges_.empty()) return std::nullopt;
    const Edge edge = edges_.front();
    edges_.pop_front();
    if (hums) {
      keep(true);
      keep(false);
    }
    return edge;
  }
  /// Presses the switch briefly, as interference does.
  void glitch() {
    const std::scoped_lock lock(mutex_);
    keep(true);
    keep(false);
  }
  void touch() {
    const bool now = never_pressed ? false : stuck || height >= stop_at;
    if (now != pressed_) keep(now);
    pressed_ = now;
  }

  std::int64_t height = 450;   // steps above the film
  std::int64_t stop_at = 500;  // where the switch closes
  bool reversed = false;       // the direction line is wired the other way round
  bool enabled = false;
  bool broken = false;
  bool stuck = false;
  bool never_pressed = false;
  bool hums = false;  // the switch's line changes faster than it is read
  std::vector<nanoseconds> taken;

 private:
  void keep(bool pressed) {
    if (edges_.size() < static_cast<std::size_t>(kKernelEdges)) edges_.push_back({pressed, monotonic_now()});
  }

  mutable std::mutex mutex_;
  std::deque<Edge> edges_;
  bool up_ = false;
  bool pressed_ = false;
};

ZStage::Limits limits() {
  return {.lowest = ZPosition(),
          .highest = ZPosition(9_mm),
          .end_stop = ZPosition(10_mm),
          .fastest = Speed(50),
          .acceleration = Acceleration(2000)};
}

class DarkLamp final : public UvLamp {
 public:
  DarkLamp(Interlock& interlock, Clock& clock) : UvLamp({1s, Irradiance(1)}, interlock, clock) {}

 private:
  Expected<TimePoint> do_begin(nanoseconds /*cure*/) override { return TimePoint(); }
  bool do_over() const override { return true; }
  void do_turn_off() noexcept override {}
  bool do_lit() const override { return false; }
  Expected<ExposureReport> do_report() override { return ExposureReport{}; }
};

class Stage : public testing::Test {
 protected:
  ZStage& stage() {
    if (!stage_) {
      stage_.emplace(limits(), LinuxZStage::Mechanics{kStep, Speed(10)}, lines_, interlock_);
    }
    return *stage_;
  }
  void home() {
    const auto homed = stage().home();
    ASSERT_TRUE(homed) << homed.error().message();
  }
  double height_mm() const { return static_cast<double>(lines_.height) * kStep; }

  Interlock interlock_;
  LinuxClock clock_;
  DarkLamp lamp_{interlock_, clock_};
  FakeLines lines_;
  std::optional<LinuxZStage> stage_;
};

TEST(StepLegs, TakeEachStepOnceTheRampHasCoveredIt) {
  FakeLines lines;
  StepLegs legs(lines, kStep, Acceleration(2000));
  lines.height = 0;
  const auto second = monotonic_now();
  EXPECT_EQ(legs.run(400, Speed(50), LegUntil::kDone, second).end, StepLegEnd::kDone);
  ASSERT_EQ(lines.taken.size(), 400U);
  EXPECT_EQ(lines.height, 400);
  const Ramp ramp(8_mm, Speed(50), Acceleration(2000));
  for (std::size_t k = 0; k < lines.taken.size(); ++k) {
    const auto due = std::chrono::duration<double>(ramp.time_at_mm(static_cast<double>(k + 1) * kStep));
    EXPECT_GE(std::chrono::duration<double>(lines.taken[k] - second).count(), due.count() - 1e-6) << k;
  }
  EXPECT_EQ(legs.take_record().steps, 400U);
}

TEST(StepLegs, CountLateStepsSinceTheLastReport) {
  FakeLines lines;
  StepLegs legs(lines, kStep, Acceleration(2000));
  // The first step is due 4.5 ms after the ramp has begun.
  EXPECT_EQ(legs.run(40, Speed(50), LegUntil::kDone, monotonic_now() - 8ms).end, StepLegEnd::kDone);
  const StepRecord record = legs.take_record();
  EXPECT_EQ(record.steps, 40U);
  EXPECT_GE(record.late + record.standstills, 1U);
  EXPECT_GE(record.worst, 3500us);
  const StepRecord taken = legs.take_record();
  EXPECT_EQ(taken.steps, 0U);
  EXPECT_EQ(taken.late, 0U);
  EXPECT_EQ(taken.worst, 0ns) << "each report starts from zero";
}

TEST(StepLegs, IgnoreAGlitchOfTheEndStop) {
  FakeLines lines;
  StepLegs legs(lines, kStep, Acceleration(2000));
  std::atomic<bool> done = false;
  std::thread noise([&] {
    while (!done) {
      lines.glitch();
      std::this_thread::yield();
    }
  });
  lines.height = 100;
  const auto result = legs.run(300, Speed(50), LegUntil::kPressed, monotonic_now());
  done = true;
  noise.join();
  EXPECT_EQ(result.end, StepLegEnd::kDone);
  EXPECT_EQ(lines.height, 400);
}

TEST(StepLegs, KeepMovingIfTheEndStopHums) {
  FakeLines lines;
  StepLegs legs(lines, kStep, Acceleration(2000));
  lines.hums = true;
  lines.glitch();
  lines.height = 100;
  EXPECT_EQ(legs.run(300, Speed(50), LegUntil::kPressed, monotonic_now()).end, StepLegEnd::kDone);
  EXPECT_EQ(lines.height, 400);
}

TEST(StepLegs, ReportTheStepAtWhichTheEndStopClosed) {
  FakeLines lines;
  StepLegs legs(lines, kStep, Acceleration(2000));
  lines.height = 0;
  const auto result = legs.run(700, Speed(20), LegUntil::kPressed, monotonic_now());
  EXPECT_EQ(result.end, StepLegEnd::kSwitched);
  EXPECT_EQ(result.switched, 500);
  EXPECT_EQ(lines.height, legs.count());
  EXPECT_LT(legs.count(), 560)
      << "it brakes from there: v^2 / 2a is 5 steps, and some more pass until the switch counts";
}

TEST_F(Stage, HomesUpwardAndThenKnowsItsHeight) {
  home();
  EXPECT_TRUE(stage().homed());
  EXPECT_TRUE(lines_.enabled);
  EXPECT_NEAR(stage().position()->above_film().millimetres(), 9, kStep);
  EXPECT_NEAR(height_mm(), 9, kStep);
}

TEST_F(Stage, TellsWhereItsHomingBegan) {
  for (const std::int64_t height : {123, 7, 510}) {
    lines_.height = height;  // as if it had been moved without power
    lines_.touch();
    const auto homed = stage().home();
    ASSERT_TRUE(homed) << homed.error().message();
    ASSERT_TRUE(homed->began_at_height);
    EXPECT_NEAR(homed->began_at_height->above_film().millimetres(), static_cast<double>(height) * kStep, kStep);
  }
  EXPECT_FALSE(stage().move_to(ZPosition(2_mm), Speed(50))->began_at_height);
}

TEST_F(Stage, HomesFromAPressedEndStop) {
  lines_.height = 510;
  lines_.touch();
  home();
  EXPECT_NEAR(height_mm(), 9, kStep);
}

TEST_F(Stage, MovesToTheStepNearestToItsTarget) {
  home();
  for (const double target : {2.345, 0.0, 8.99, 5.0}) {
    const auto moved = stage().move_to(ZPosition(Distance::millimetres(target)), Speed(50));
    ASSERT_TRUE(moved) << moved.error().message();
    EXPECT_TRUE(moved->arrived);
    EXPECT_NEAR(height_mm(), target, kStep / 2 + 1e-9);
    EXPECT_NEAR(moved->position.above_film().millimetres(), height_mm(), 1e-6);
  }
}

TEST_F(Stage, ReportsLostStepsWhenItHomesAgain) {
  home();
  lines_.height -= 7;  // as if somebody had blocked the stage
  const auto homed = stage().home();
  ASSERT_TRUE(homed);
  EXPECT_NEAR(homed->steps_lost.millimetres(), 7 * kStep, kStep / 2);
  EXPECT_NEAR(height_mm(), 9, kStep);
}

TEST_F(Stage, StopsOnItsWayAndKnowsItsHeight) {
  home();
  auto motion = stage().begin_move(ZPosition(2_mm), Speed(10));
  ASSERT_TRUE(motion);
  ASSERT_TRUE(clock_.sleep_until(clock_.now() + 200ms));
  EXPECT_TRUE(stage().moving());
  ASSERT_TRUE(motion->stop());
  const auto report = motion->finish();
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->arrived);
  EXPECT_TRUE(stage().homed());
  EXPECT_GT(height_mm(), 2.5);
  EXPECT_NEAR(report->position.above_film().millimetres(), height_mm(), 1e-6);
}

TEST_F(Stage, ReportsAMissingEndStop) {
  lines_.never_pressed = true;
  const auto homed = stage().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().code(), ErrorCode::kEndStopNotFound);
  EXPECT_FALSE(stage().homed());
}

TEST_F(Stage, ReportsAStuckEndStop) {
  lines_.stuck = true;
  lines_.touch();
  const auto homed = stage().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().code(), ErrorCode::kEndStopStuck);
  EXPECT_GE(height_mm(), 9 - 1.1) << "at most a millimetre towards the film";
}

TEST_F(Stage, StopsAtAnEndStopThatClosesTooEarly) {
  home();
  ASSERT_TRUE(stage().move_to(ZPosition(1_mm), Speed(50)));
  lines_.stop_at = 200;  // as if the stage had slipped upward by 6 mm
  const auto moved = stage().move_to(ZPosition(8_mm), Speed(20));
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code(), ErrorCode::kEndStopStuck);
  EXPECT_LT(lines_.height, 260);
  EXPECT_FALSE(stage().homed());
}

TEST_F(Stage, ReportsADriverThatCannotBeSet) {
  home();
  lines_.broken = true;
  const auto moved = stage().move_to(ZPosition(5_mm), Speed(20));
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code(), ErrorCode::kStageStalled);
}

TEST_F(Stage, EndsAJogAtTheEndStopWhicheverWayItGoes) {
  for (const bool reversed : {false, true}) {
    lines_.reversed = reversed;
    lines_.height = 450;
    lines_.touch();
    auto jog = stage().begin_jog(reversed ? -5_mm : 5_mm);
    ASSERT_TRUE(jog) << jog.error().message();
    const auto report = jog->finish();
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_FALSE(report->arrived);
    EXPECT_GE(lines_.height, 500);
    EXPECT_LT(lines_.height, 505) << "1 mm/s stops within the time that confirms the switch";
    EXPECT_FALSE(stage().homed());
  }
}

TEST_F(Stage, CausesAnEventAtTheEndOfEachMotion) {
  home();
  ASSERT_TRUE(stage().move_to(ZPosition(8_mm), Speed(50)));
  EventQueue events;
  stage_->drain(events);
  ASSERT_TRUE(events.take());
  const auto second = events.take();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->kind, EventKind::kMotionEnded);
  EXPECT_FALSE(events.take());
}

}  // namespace
}  // namespace plumbline
