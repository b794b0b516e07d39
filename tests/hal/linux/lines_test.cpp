/// Lines and events without hardware: names, uses, bouncing contacts, order.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/shutdown_signal.hpp"
#include "hal/linux/gpio/contact.hpp"
#include "hal/linux/gpio/line_registry.hpp"
#include "hal/linux/keeper/gpio_keeper_lines.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

TEST(LineRegistry, RefusesAPinUsedTwiceAndNamesBothUses) {
  LineRegistry registry;
  EXPECT_TRUE(registry.claim({"gpiochip0", 17}, "the lamp"));
  EXPECT_TRUE(registry.claim({"gpiochip0", 18}, "the cover"));
  EXPECT_TRUE(registry.claim({"gpiochip1", 17}, "the end stop"));
  const auto twice = registry.claim({"gpiochip0", 17}, "the buzzer");
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().code(), ErrorCode::kBadSetting);
  EXPECT_STREQ(twice.error().message(),
               "the lamp and the buzzer use the same line, gpiochip0 17: correct the board file");
}

TEST(LineOption, ParsesBackToWhatWasWritten) {
  for (const bool low : {false, true}) {
    for (const auto bias : {LineBias::kAsIs, LineBias::kDisabled, LineBias::kPullUp, LineBias::kPullDown}) {
      LineSettings settings;
      settings.active_low = low;
      settings.bias = bias;
      const auto option = parse_line_option(line_option({"gpiochip3", 54}, settings));
      ASSERT_TRUE(option);
      EXPECT_EQ(option->place, (LinePlace{"gpiochip3", 54}));
      EXPECT_EQ(option->settings.active_low, low);
      EXPECT_EQ(option->settings.bias, bias);
    }
  }
}

TEST(LineOption, RefusesAnythingElse) {
  EXPECT_TRUE(parse_line_option("gpio:gpiochip0:0:low:pull-up"));
  for (const char* text : {"", "gpio", "gpio:gpiochip0:1:high", "gpio:gpiochip0:1:high:as-is:", "gpio::1:high:as-is",
                           "gpio:gpiochip0:-1:high:as-is", "gpio:gpiochip0:1x:high:as-is", "gpio:gpiochip0::high:as-is",
                           "gpio:gpiochip0:1:middle:as-is", "gpio:gpiochip0:1:high:upwards",
                           "pin:gpiochip0:1:high:as-is", "gpio:gpiochip0:4294967296:high:as-is"}) {
    EXPECT_FALSE(parse_line_option(text)) << text;
  }
}

TEST(Contact, GoesOnOnceAtItsFirstContactEvenIfItBounces) {
  Contact contact(false);
  EXPECT_TRUE(contact.update(true, 100ms));
  EXPECT_FALSE(contact.update(false, 101ms));
  EXPECT_FALSE(contact.update(true, 102ms));
  EXPECT_FALSE(contact.update(false, 103ms));
  EXPECT_FALSE(contact.update(true, 104ms));
  EXPECT_TRUE(contact.on());
  EXPECT_FALSE(contact.due());
  EXPECT_FALSE(contact.settle(10s));
}

TEST(Contact, GoesOffAfterTheBounceTime) {
  Contact contact(true);
  EXPECT_FALSE(contact.update(false, 100ms));
  EXPECT_FALSE(contact.update(true, 110ms));
  EXPECT_FALSE(contact.update(false, 120ms));
  EXPECT_FALSE(contact.update(false, 140ms)) << "a repeated reading is no new bounce";
  ASSERT_TRUE(contact.due());
  EXPECT_EQ(*contact.due(), 120ms + Contact::kBounceTime);
  EXPECT_FALSE(contact.settle(120ms + Contact::kBounceTime - 1ns));
  EXPECT_TRUE(contact.on());
  EXPECT_EQ(contact.settle(120ms + Contact::kBounceTime), std::optional<Contact::Time>(120ms));
  EXPECT_FALSE(contact.on());
  EXPECT_FALSE(contact.settle(10s)) << "only once";
  EXPECT_TRUE(contact.update(true, 11s)) << "it can go on again";
}

TEST(EventQueue, ReturnsTheEarliestEventEvenIfItWasReportedLast) {
  EventQueue queue;
  EXPECT_FALSE(queue.take());
  queue.add(EventKind::kMotionEnded, 5ms);
  queue.add(EventKind::kCoverOpened, 3ms);
  queue.add(EventKind::kExposureEnded, 3ms);
  queue.add(EventKind::kPausePressed, 9ms);
  std::vector<EventKind> kinds;
  while (const auto event = queue.take()) kinds.push_back(event->kind);
  EXPECT_THAT(kinds, testing::ElementsAre(EventKind::kCoverOpened, EventKind::kExposureEnded, EventKind::kMotionEnded,
                                          EventKind::kPausePressed));
}

TEST(EventQueue, DropsNewEventsWhenItIsFull) {
  EventQueue queue;
  for (std::size_t i = 0; i < EventQueue::kCapacity; ++i)
    queue.add(EventKind::kStartPressed, std::chrono::nanoseconds(i));
  queue.add(EventKind::kCancelPressed, 0ns);
  std::size_t taken = 0;
  while (const auto event = queue.take()) {
    EXPECT_EQ(event->kind, EventKind::kStartPressed);
    ++taken;
  }
  EXPECT_EQ(taken, EventQueue::kCapacity);
}

TEST(ShutdownSignal, TurnsSigtermIntoAnEvent) {
  EventQueue queue;
  {
    ShutdownSignal shutdown(queue);
    shutdown.drain(1ms);
    EXPECT_FALSE(queue.take());
    std::raise(SIGTERM);
    shutdown.drain(2ms);
    const auto event = queue.take();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->kind, EventKind::kShutdownRequested);
    EXPECT_EQ(event->at, TimePoint(2ms));
  }
  EXPECT_EXIT(std::raise(SIGTERM), testing::KilledBySignal(SIGTERM), "") << "the signal's old action is restored";
}

}  // namespace
}  // namespace plumbline
