#include "hal/linux/keeper/silence.hpp"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

using namespace std::chrono_literals;

/// Ticks on time until the silence is too long. @returns when that is
Silence::Time until_too_long(Silence& silence) {
  Silence::Time now{};
  while (!silence.too_long()) {
    now = silence.due();
    silence.tick(now);
  }
  return now;
}

TEST(Silence, IsTooLongWellBefore50MsWhileLit) {
  Silence silence;
  silence.begin(kLitPace, 1000ms);
  // The other one stops right after the answer to the first ping.
  EXPECT_EQ(until_too_long(silence) - 1000ms, 30ms);
  EXPECT_LE(until_too_long(silence), 1050ms - 20ms) << "what is left for killing and taking the line";
}

TEST(Silence, IsTooLongAfterAboutASecondInTheDark) {
  Silence silence;
  silence.begin(kDarkPace, 1000ms);
  EXPECT_EQ(until_too_long(silence) - 1000ms, 1250ms);
}

TEST(Silence, EndsWithAWord) {
  Silence silence;
  silence.begin(kLitPace, 0ms);
  for (int i = 0; i < 100; ++i) {
    for (int tick = 1; tick < kLitPace.patience; ++tick) silence.tick(silence.due());
    EXPECT_FALSE(silence.too_long());
    EXPECT_FALSE(silence.well());
    silence.heard();
    silence.tick(silence.due());
    EXPECT_TRUE(silence.well());
  }
}

TEST(Silence, CountsATickThatComesLateOnce) {
  Silence silence;
  silence.begin(kLitPace, 0ms);
  silence.tick(0ms);
  silence.tick(10s);
  EXPECT_FALSE(silence.too_long()) << "the board stood still, and with it whoever should have answered";
  EXPECT_EQ(silence.due(), 10s + kLitPace.tick);
}

}  // namespace
}  // namespace plumbline
