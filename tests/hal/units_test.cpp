#include "hal/units.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace plumbline {
namespace {

template <class A, class B>
concept Adds = requires(A a, B b) {
  a + b;
};
template <class A, class B>
concept Subtracts = requires(A a, B b) {
  a - b;
};
template <class A, class B>
concept Compares = requires(A a, B b) {
  a < b;
};

TEST(Units, CannotBeMixedInSums) {
  static_assert(Adds<ZPosition, Distance> && !Adds<ZPosition, ZPosition> && !Adds<Distance, ZPosition>);
  static_assert(Subtracts<ZPosition, ZPosition> && !Subtracts<Distance, ZPosition>);
  static_assert(!Compares<ZPosition, Distance>);
  static_assert(!Adds<Distance, int> && !Adds<Distance, double>);
  static_assert(Adds<Speed, Speed> && !Adds<Speed, Acceleration> && !Adds<Speed, double>);
  static_assert(!Adds<Irradiance, Dose> && !Compares<Irradiance, Dose>);
  static_assert(!Adds<Celsius, Dose> && !Adds<std::chrono::seconds, Distance>);
  static_assert(!std::is_convertible_v<double, Speed> && !std::is_convertible_v<Distance, ZPosition>);
}

TEST(Units, LayersAddUpWithoutRounding) {
  ZPosition height;
  for (int layer = 0; layer < 65535; ++layer) height = height + Distance::millimetres(0.035);
  EXPECT_EQ(height, ZPosition(Distance::nanometres(std::int64_t{65535} * 35000)));
  EXPECT_EQ(height - ZPosition(), 35_um * 65535);
}

TEST(Units, RoundToTheNearestNanometre) {
  EXPECT_EQ(Distance::micrometres(0.0014).nanometres(), 1);
  EXPECT_EQ(Distance::micrometres(0.0016).nanometres(), 2);
  EXPECT_EQ(Distance::micrometres(-0.0016).nanometres(), -2);
  EXPECT_EQ(Distance::millimetres(0.05), 50_um);
  EXPECT_EQ(1.5_mm, 1500_um);
  EXPECT_EQ(12.5_um, Distance::nanometres(12500));
}

TEST(Units, DoseIsIrradianceTimesTime) {
  EXPECT_DOUBLE_EQ(dose_of(Irradiance(3), std::chrono::milliseconds(2500)).value(), 7.5);
  EXPECT_DOUBLE_EQ(mm_per_min(180).value(), 3);
}

}  // namespace
}  // namespace plumbline
