#include "hal/linux/keeper/light_budget.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace plumbline {
namespace {

using namespace std::chrono_literals;
using Time = LightBudget::Time;

TEST(LightBudget, AllowsNoExposureAboveTheLongest) {
  LightBudget budget({.longest = 40s, .per_minute = 60s});
  EXPECT_FALSE(budget.allows(100s, 0s));
  EXPECT_FALSE(budget.allows(100s, -1s));
  EXPECT_TRUE(budget.allows(100s, 40s));
  EXPECT_FALSE(budget.allows(100s, 40s + 1ns));
}

TEST(LightBudget, CountsTheMinuteThatEndsWithTheExposure) {
  LightBudget budget({.longest = 60s, .per_minute = 30s});
  ASSERT_TRUE(budget.allows(100s, 20s));
  budget.add(100s, 120s);
  EXPECT_TRUE(budget.allows(120s, 10s));
  EXPECT_FALSE(budget.allows(120s, 10s + 1ns));
  EXPECT_FALSE(budget.allows(149s, 20s)) << "11 s are left";
  EXPECT_TRUE(budget.allows(150s, 20s)) << "10 s are left";
  EXPECT_TRUE(budget.allows(160s, 20s)) << "none is left of the first";
}

TEST(LightBudget, HoldsEveryMinuteOfARandomFirmwareBelowTheLimit) {
  std::mt19937 random(7);
  LightBudget budget({.longest = 20s, .per_minute = 25s});
  struct Lit {
    Time from, until;
  };
  std::vector<Lit> all;
  Time now = 1000s;
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    now += std::chrono::milliseconds(std::uniform_int_distribution<int>(0, 8000)(random));
    const Time cure = std::chrono::milliseconds(std::uniform_int_distribution<int>(1, 20000)(random));
    if (!budget.allows(now, cure)) {
      ++refused;
      continue;
    }
    all.push_back({now, now + cure});
    budget.add(now, now + cure);
    now += cure;
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(all.size(), 500U);
  // Brute force over all minutes that end with an exposure.
  Time most{};
  for (const Lit& last : all) {
    Time light{};
    for (const Lit& one : all) {
      const Time from = std::max(one.from, last.until - 60s);
      const Time until = std::min(one.until, last.until);
      if (until > from) light += until - from;
    }
    most = std::max(most, light);
  }
  EXPECT_LE(most, 25s);
  EXPECT_GT(most, 24s) << "the budget is used";
}

TEST(LightBudget, RefusesWhatItCannotRemember) {
  LightBudget budget({.longest = 1s, .per_minute = 60s});
  Time now = 1000s;
  int allowed = 0;
  while (budget.allows(now, 1ms) && allowed < 10'000) {
    budget.add(now, now + 1ms);
    now += 2ms;
    ++allowed;
  }
  EXPECT_EQ(allowed, 1024);
  EXPECT_TRUE(budget.allows(now + 60s, 1ms));
}

}  // namespace
}  // namespace plumbline
