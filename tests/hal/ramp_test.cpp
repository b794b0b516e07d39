#include "hal/ramp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace plumbline {
namespace {

using Seconds = Ramp::Seconds;

TEST(Ramp, TakesTheTimeOfATrapezoid) {
  // d / v + v / a = 6 / 3 + 3 / 50
  const Ramp ramp(6_mm, Speed(3), Acceleration(50));
  EXPECT_DOUBLE_EQ(ramp.duration().count(), 6.0 / 3 + 3.0 / 50);
  EXPECT_DOUBLE_EQ(ramp.peak().value(), 3);
}

TEST(Ramp, TakesTheTimeOfATriangleIfItNeverCruises) {
  // 2 sqrt(d / a) = 2 sqrt(0.05 / 50)
  const Ramp ramp(50_um, Speed(3), Acceleration(50));
  EXPECT_DOUBLE_EQ(ramp.duration().count(), 2 * std::sqrt(0.05 / 50));
  EXPECT_DOUBLE_EQ(ramp.peak().value(), std::sqrt(0.05 * 50));
}

TEST(Ramp, CoversTheIntegralOfItsSpeedWithinItsAcceleration) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const double way = std::uniform_real_distribution(0.001, 20.0)(random);
    const double speed = std::uniform_real_distribution(0.1, 20.0)(random);
    const double acceleration = std::uniform_real_distribution(5.0, 500.0)(random);
    const Ramp ramp(Distance::millimetres(way), Speed(speed), Acceleration(acceleration));
    constexpr int kSteps = 2000;
    const double dt = ramp.duration().count() / kSteps;
    double area = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double here = ramp.speed_at(Seconds(k * dt)).value();
      const double there = ramp.speed_at(Seconds((k + 1) * dt)).value();
      area += 0.5 * (here + there) * dt;
      ASSERT_LE(std::abs(there - here), acceleration * dt * (1 + 1e-9));
      ASSERT_LE(there, speed * (1 + 1e-12));
      ASSERT_NEAR(ramp.travelled_mm(Seconds((k + 1) * dt)), area, 1e-3 * way);
    }
    EXPECT_NEAR(ramp.length_mm(), way, 1e-6);
  }
}

TEST(Ramp, KnowsWhenItPassesADistance) {
  for (const Distance way : {40_um, 6_mm}) {
    const Ramp ramp(way, Speed(3), Acceleration(50));
    for (int percent = 0; percent <= 100; ++percent) {
      const double place = ramp.length_mm() * percent / 100;
      EXPECT_NEAR(ramp.travelled_mm(ramp.time_at_mm(place)), place, 1e-9);
    }
    EXPECT_EQ(ramp.time_at_mm(1e9), ramp.duration());
    EXPECT_EQ(ramp.time_at_mm(-1), Seconds(0));
  }
}

TEST(Ramp, BrakesFromAnyMomentWithinItsBrakingDistance) {
  const Acceleration acceleration(50);
  const Ramp ramp(6_mm, Speed(3), acceleration);
  for (int percent = 0; percent < 100; ++percent) {
    const Seconds time(ramp.duration() * percent / 100);
    const Ramp stopped = ramp.stopped_at(time);
    const double speed = ramp.speed_at(time).value();
    EXPECT_DOUBLE_EQ(stopped.travelled_mm(time), ramp.travelled_mm(time));
    // v^2 / (2 a) further, v / a later
    EXPECT_NEAR(stopped.length_mm() - ramp.travelled_mm(time), speed * speed / (2 * acceleration.value()), 1e-9);
    EXPECT_NEAR((stopped.duration() - time).count(), speed / acceleration.value(), 1e-9);
  }
}

TEST(Ramp, TakesNoTimeForNoDistance) {
  const Ramp ramp(0_mm, Speed(3), Acceleration(50));
  EXPECT_EQ(ramp.duration(), Seconds(0));
  EXPECT_EQ(ramp.travelled_mm(Seconds(1)), 0);
  EXPECT_EQ(Ramp().duration(), Seconds(0));
}

}  // namespace
}  // namespace plumbline
