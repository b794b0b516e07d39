#include "hal/linux/screen/touch_panel.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace plumbline {
namespace {

input_event event_of(int type, int code, int value) {
  input_event event{};
  event.type = static_cast<std::uint16_t>(type);
  event.code = static_cast<std::uint16_t>(code);
  event.value = value;
  return event;
}

/// The events of a finger that comes down, moves and leaves.
std::vector<input_event> touch_at(int x, int y, bool place_first) {
  std::vector<input_event> events;
  const auto place = [&] {
    events.push_back(event_of(EV_ABS, ABS_X, x));
    events.push_back(event_of(EV_ABS, ABS_Y, y));
  };
  if (place_first) place();
  events.push_back(event_of(EV_KEY, BTN_TOUCH, 1));
  if (!place_first) place();
  events.push_back(event_of(EV_SYN, SYN_REPORT, 0));
  events.push_back(event_of(EV_ABS, ABS_X, x + 50));
  events.push_back(event_of(EV_SYN, SYN_REPORT, 0));
  events.push_back(event_of(EV_KEY, BTN_TOUCH, 0));
  events.push_back(event_of(EV_SYN, SYN_REPORT, 0));
  return events;
}

std::vector<ScreenPlace> places(TouchReader& reader, const std::vector<input_event>& events) {
  std::vector<ScreenPlace> found;
  for (const input_event& event : events) {
    if (const auto place = reader.take(event)) found.push_back(*place);
  }
  return found;
}

TEST(TouchReader, ReportsATouchOnceWhereTheFingerCameDown) {
  TouchReader reader({320, 240, 0, 16}, {0, 4095}, {0, 4095});
  for (const bool place_first : {true, false}) {
    EXPECT_EQ(places(reader, touch_at(0, 4095, place_first)), (std::vector{ScreenPlace{0, 239}}));
    EXPECT_EQ(places(reader, touch_at(2048, 2048, place_first)), (std::vector{ScreenPlace{160, 120}}));
  }
  EXPECT_EQ(places(reader, touch_at(9000, -5, true)), (std::vector{ScreenPlace{319, 0}}))
      << "beyond what it says it can report";
}

// A panel of 240 x 320 that is mounted on its side: the picture's upper left corner is sent to the lower left one.
TEST(TouchReader, TurnsThePlaceWithThePicture) {
  TouchReader reader({320, 240, 90, 16}, {0, 239}, {0, 319});
  EXPECT_EQ(places(reader, touch_at(0, 319, true)), (std::vector{ScreenPlace{0, 0}}));
  EXPECT_EQ(places(reader, touch_at(239, 0, true)), (std::vector{ScreenPlace{319, 239}}));
}

TEST(TouchPanel, IsRefusedIfItIsNone) {
  const auto missing = TouchPanel::open("/nowhere/event0", {320, 240, 0, 16});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code(), ErrorCode::kCannotOpen);
  EXPECT_FALSE(TouchPanel::open("/dev/null", {320, 240, 0, 16}));
}

}  // namespace
}  // namespace plumbline
