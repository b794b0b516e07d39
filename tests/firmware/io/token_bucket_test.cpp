#include "firmware/io/token_bucket.hpp"

#include <gtest/gtest.h>

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

TEST(TokenBucket, GrantsABurstThenARateAndNothingMoreToWhoeverGoesOn) {
  TokenBucket bucket({.burst = 10, .a_second = 2});
  TokenBucket::HostClock::time_point now{5h};
  int granted = 0;
  for (int i = 0; i < 15; ++i) granted += bucket.take(now) ? 1 : 0;
  EXPECT_EQ(granted, 10);
  EXPECT_FALSE(bucket.in_debt(now)) << "five in vain";
  EXPECT_EQ(bucket.wait(now), 3s) << "six are missing";
  EXPECT_FALSE(bucket.take(now));
  EXPECT_TRUE(bucket.in_debt(now));
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(bucket.take(now));
  EXPECT_EQ(bucket.wait(now), 5500ms) << "the debt is bounded";
  now += 5500ms;
  EXPECT_TRUE(bucket.take(now));
  EXPECT_FALSE(bucket.take(now));
  now += 1h;
  granted = 0;
  for (int i = 0; i < 15; ++i) granted += bucket.take(now) ? 1 : 0;
  EXPECT_EQ(granted, 10);
}

TEST(LogBound, TakesAFewLinesAMinuteAndCountsTheOthers) {
  LogBound bound({.burst = 10, .a_second = 10.0 / 60});
  TokenBucket::HostClock::time_point now{5h};
  unsigned lines = 0;
  for (int i = 0; i < 60'000; ++i, now += 1ms) lines += bound.takes_line(now) ? 1 : 0;
  EXPECT_GE(lines, 19U);
  EXPECT_LE(lines, 20U) << "in a minute";
  EXPECT_EQ(bound.take_left_out(), 60'000 - lines);
  EXPECT_EQ(bound.take_left_out(), 0U);
  now += 6s;
  EXPECT_TRUE(bound.takes_line(now)) << "whoever flooded it leaves it as it was";
}

}  // namespace
}  // namespace plumbline::firmware
