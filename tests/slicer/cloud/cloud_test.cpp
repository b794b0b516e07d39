#include "slicer/cloud/cloud.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(Cloud, GivesTheRoomOfPointsBackThatAreNotInUse) {
  constexpr std::uint32_t kPoints = 1000;
  for (const std::uint32_t left : {kPoints, kPoints - 1, 400U, 1U}) {
    ArenaBlock arena(kMiB);
    Cloud cloud = value_of(Cloud::create(kPoints, *arena));
    cloud.size = left;
    for (std::uint32_t i = 0; i < left; ++i) {
      const auto x = static_cast<float>(i);
      cloud.position[i] = {x, -x, 2 * x};
      cloud.radius[i] = 3 * x;
      cloud.normal[i].weight = static_cast<std::uint8_t>(i % 200);
    }
    check(cloud.give_back(*arena));
    EXPECT_EQ(cloud.capacity(), left);
    EXPECT_LT(arena->top_used(), Cloud::kBytesPerPoint * left + 3 * Arena::kAlignment);
    for (std::uint32_t i = 0; i < left; ++i) {
      const auto x = static_cast<float>(i);
      ASSERT_EQ(cloud.position[i], Vec3f(x, -x, 2 * x));
      ASSERT_EQ(cloud.radius[i], 3 * x);
      ASSERT_EQ(cloud.normal[i].weight, i % 200);
    }
  }
}

TEST(Cloud, KeepsTheViewOfEachPoint) {
  constexpr std::uint32_t kPoints = 1000;
  ArenaBlock arena(kMiB);
  Cloud cloud = value_of(Cloud::create(kPoints + 50, *arena, true));
  cloud.views.count = 200;
  cloud.views.scanner[7] = {1, 2, 3};
  cloud.size = kPoints;
  const auto view_at = [](const Vec3f& p) { return static_cast<std::uint8_t>(static_cast<std::uint32_t>(p[0]) % 199); };
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    cloud.position[i] = {static_cast<float>(i), 0, 0};
    cloud.views.of[i] = view_at(cloud.position[i]);
  }
  std::vector<std::uint32_t> order(kPoints);
  std::iota(order.begin(), order.end(), 0);
  std::reverse(order.begin(), order.end() - 100);
  cloud.reorder(order);
  cloud.keep([](std::uint32_t i) { return i % 3 > 0; });
  check(cloud.give_back(*arena));
  ASSERT_EQ(cloud.size, 666U);
  EXPECT_EQ(cloud.views.of.size(), 666U);
  for (std::uint32_t i = 0; i < cloud.size; ++i) ASSERT_EQ(cloud.view_of(i), view_at(cloud.position[i]));
  EXPECT_EQ(cloud.views.scanner[7], Vec3f(1, 2, 3));
  cloud.average_neighbours();
  EXPECT_EQ(cloud.view_of(0), kNoView) << "points of several views were averaged";
  check(cloud.give_back(*arena, false));
  const std::size_t scanners = kMaxViews * (sizeof(Vec3f) + sizeof(bool));
  EXPECT_LT(arena->top_used(), Cloud::kBytesPerPoint * cloud.size + scanners + 5 * Arena::kAlignment)
      << "all room is given back";
}

TEST(Cloud, ReplacesNeighboursByTheirMean) {
  ArenaBlock arena(kMiB);
  Cloud cloud = value_of(Cloud::create(100, *arena));
  // Clusters of four points a millimetre wide, 100 mm apart, in an order that mixes them.
  cloud.size = 64;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const auto cluster = static_cast<float>(i % 16);
    const auto corner = static_cast<float>(i / 16);
    cloud.position[i] = {100 * cluster, corner < 2 ? 1.0F : 0.0F, corner == 1 || corner == 3 ? 1.0F : 0.0F};
    cloud.normal[i].set({0, 0, 1});
    cloud.normal[i].weight = 3;
  }
  cloud.average_neighbours();
  ASSERT_EQ(cloud.size, 16U);
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    EXPECT_EQ(cloud.position[i], Vec3f(100 * static_cast<float>(i), 0.5F, 0.5F));
    EXPECT_FALSE(cloud.normal[i].known());
    EXPECT_EQ(cloud.normal[i].weight, 1);
  }
}

TEST(Cloud, AveragesPointsThatCoincide) {
  ArenaBlock arena(kMiB);
  Cloud cloud = value_of(Cloud::create(1000, *arena));
  cloud.size = 1000;
  std::fill_n(cloud.position.begin(), cloud.size, Vec3f(1, 2, 3));
  cloud.average_neighbours();
  EXPECT_EQ(cloud.size, 256U);
  for (const Vec3f& p : cloud.positions()) EXPECT_EQ(p, Vec3f(1, 2, 3));
}

TEST(Cloud, TakesAnOrderWithAllThatAPointHas) {
  constexpr std::uint32_t kPoints = 10000;
  ArenaBlock arena(kMiB);
  Cloud cloud = value_of(Cloud::create(kPoints + 5, *arena));
  cloud.size = kPoints;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const auto x = static_cast<float>(i);
    cloud.position[i] = {x, -x, 2 * x};
    cloud.radius[i] = 3 * x;
    cloud.normal[i] = {};
    cloud.normal[i].set({1, x, 0});
    cloud.normal[i].weight = static_cast<std::uint8_t>(i % 200);
  }
  const std::vector<PackedNormal> normals(cloud.normal.begin(), cloud.normal.begin() + kPoints);
  std::vector<std::uint32_t> order(kPoints);
  std::iota(order.begin(), order.end(), 0);
  Random random(3);
  for (std::uint32_t i = kPoints; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  const std::vector<std::uint32_t> wanted = order;
  cloud.reorder(order);
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const auto x = static_cast<float>(wanted[i]);
    ASSERT_EQ(order[i], i);
    ASSERT_EQ(cloud.position[i], Vec3f(x, -x, 2 * x));
    ASSERT_EQ(cloud.radius[i], 3 * x);
    ASSERT_EQ(cloud.normal[i].unpack(), normals[wanted[i]].unpack());
    ASSERT_EQ(cloud.normal[i].weight, wanted[i] % 200);
  }
}

}  // namespace
}  // namespace plumbline
