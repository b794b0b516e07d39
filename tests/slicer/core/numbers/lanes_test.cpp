#include "slicer/core/numbers/lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace plumbline {
namespace {

using Numbers = std::array<float, kLanes>;
constexpr Numbers kA = {1.5F, -2.25F, 0.1F, 1e8F, -0.0F, 7, -1e-3F, 3};
constexpr Numbers kB = {0.5F, 3, 0.1F, -2, 4, 7, 1e-3F, -5};

void load_both(Lanes& a, Lanes& b) {
  load(a, kA.data());
  load(b, kB.data());
}

void expect_lanes(const Lanes& lanes, const Numbers& expected) {
  Numbers found;
  store(found.data(), lanes);
  for (std::size_t k = 0; k < kLanes; ++k) {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(found[k]), std::bit_cast<std::uint32_t>(expected[k])) << "lane " << k;
  }
}

template <class Operation>
Numbers each(Operation operation) {
  Numbers to;
  for (std::size_t k = 0; k < kLanes; ++k) to[k] = operation(kA[k], kB[k]);
  return to;
}

TEST(Lanes, CalculateAsSingleNumbersDo) {
  Lanes a, b;
  load_both(a, b);
  expect_lanes(a + b, each([](float x, float y) { return x + y; }));
  expect_lanes(a - b, each([](float x, float y) { return x - y; }));
  expect_lanes(a * b, each([](float x, float y) { return x * y; }));
  expect_lanes(a / b, each([](float x, float y) { return x / y; }));
  expect_lanes(-a, each([](float x, float) { return -x; }));
  expect_lanes(2 * a + 1, each([](float x, float) { return 2 * x + 1; }));
  expect_lanes(a * -0.0F, each([](float x, float) { return x * -0.0F; }));
  Lanes changed = a;
  changed += b;
  changed *= b;
  changed -= a;
  expect_lanes(changed, each([](float x, float y) { return (x + y) * y - x; }));
}

TEST(Lanes, ChooseByComparisons) {
  Lanes a, b, chosen;
  load_both(a, b);
  choose(chosen, a > b, a, b);
  expect_lanes(chosen, each([](float x, float y) { return x > y ? x : y; }));
  choose(chosen, (a >= b) & (b != 7.0F), a, b);
  expect_lanes(chosen, each([](float x, float y) { return x >= y && y != 7 ? x : y; }));
  choose(chosen, (a == b) | (a < 0.0F), a, b);
  expect_lanes(chosen, each([](float x, float y) { return x == y || x < 0 ? x : y; }));
  IntLanes count{};
  count -= a <= b;
  EXPECT_EQ(sum(count), std::ranges::count(each([](float x, float y) { return x <= y ? 1.0F : 0.0F; }), 1.0F));
}

TEST(Lanes, TellWhetherAComparisonHoldsInAnyOfThem) {
  EXPECT_FALSE(any(Lanes{} > 0.0F));
  for (std::size_t k = 0; k < kLanes; ++k) {
    Numbers one = {};
    one[k] = 1;
    Lanes lanes;
    load(lanes, one.data());
    EXPECT_TRUE(any(lanes > 0.0F)) << "lane " << k;
  }
}

TEST(Lanes, TakeRootsAndTheSmallest) {
  Lanes a, b, root;
  load_both(a, b);
  square_root(root, a * a + b * b);
  expect_lanes(root, each([](float x, float y) { return std::sqrt(x * x + y * y); }));
  EXPECT_EQ(smallest(b), -5);
  EXPECT_EQ(smallest(-b), -7);
}

TEST(Lanes, AreSummedInOneOrder) {
  Lanes a, b;
  load_both(a, b);
  EXPECT_EQ(sum(a), ((kA[0] + kA[4]) + (kA[1] + kA[5])) + ((kA[2] + kA[6]) + (kA[3] + kA[7])));
  EXPECT_EQ(sum(b), ((kB[0] + kB[4]) + (kB[1] + kB[5])) + ((kB[2] + kB[6]) + (kB[3] + kB[7])));
}

TEST(Lanes, LoadPoints) {
  std::array<float, 3 * kLanes> points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = static_cast<float>(i);
  Lanes x, y, z;
  load_points(x, y, z, points.data());
  expect_lanes(x, {0, 3, 6, 9, 12, 15, 18, 21});
  expect_lanes(y, {1, 4, 7, 10, 13, 16, 19, 22});
  expect_lanes(z, {2, 5, 8, 11, 14, 17, 20, 23});
}

}  // namespace
}  // namespace plumbline
