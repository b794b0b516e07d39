/// Contract of every back end: time and events.

#include "tests/hal/contract.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

using EventsContract = Contract;

TEST_P(EventsContract, TimePassesAndNeverGoesBack) {
  Clock& clock = rig_->machine().clock;
  const TimePoint start = clock.now();
  ASSERT_TRUE(clock.sleep_until(start + 20ms));
  EXPECT_GE(clock.now(), start + 20ms);
  EXPECT_LT(clock.now(), start + 120ms);
  ASSERT_TRUE(clock.sleep_until(start));
  EXPECT_LT(clock.now(), start + 120ms);
}

TEST_P(EventsContract, WaitingEndsAtTheDeadline) {
  const Machine machine = rig_->machine();
  const TimePoint start = machine.clock.now();
  const auto event = machine.events.next_event(start + 50ms);
  ASSERT_TRUE(event);
  EXPECT_FALSE(event->has_value());
  EXPECT_GE(machine.clock.now(), start + 50ms);
  EXPECT_LT(machine.clock.now(), start + 150ms);
}

TEST_P(EventsContract, EventsArriveInOrderWithTheTimeAtWhichTheyHappened) {
  const Machine machine = rig_->machine();
  const TimePoint start = machine.clock.now();
  rig_->press(EventKind::kPausePressed, 30ms);
  rig_->press(EventKind::kCancelPressed, 60ms);
  const auto first = machine.events.next_event(start + 1s).value();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, EventKind::kPausePressed);
  EXPECT_LT(machine.clock.now() - first->at, 10ms);
  ASSERT_TRUE(machine.clock.sleep_until(start + 500ms));
  const auto second = machine.events.next_event(start + 1s).value();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->kind, EventKind::kCancelPressed);
  EXPECT_NEAR(std::chrono::duration<double>(second->at - start).count(), 0.06, 0.01);
  EXPECT_FALSE(machine.events.next_event(start).value());
}

INSTANTIATE_TEST_SUITE_P(Hal, EventsContract, testing::ValuesIn(rig_makers()), kRigName);

}  // namespace
}  // namespace plumbline
