#include "slicer/cloud/thinning.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "slicer/placement/placement.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;
using Cell = std::tuple<std::int64_t, std::int64_t, std::int64_t>;

class Thinning {
 public:
  Thinning(std::uint32_t capacity, double cell, const Mat3d& rotation = Mat3d::Identity())
      : arena_(std::size_t{capacity} * 64 + 64 * 1024),
        cloud_(value_of(Cloud::create(capacity, *arena_, true))),
        thinner_(cloud_, capacity, value_of(arena_->take_top<std::byte>(PointThinner::table_bytes(capacity), "test")),
                 rotation, cell) {}
  Thinning(const Thinning&) = delete;
  Thinning& operator=(const Thinning&) = delete;

  Status take(const Vec3d& p, const Vec3d& n = {0, 0, 1}) {
    const ScanPoint point{
        p[0], p[1], p[2], static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
    return thinner_.take({&point, 1});
  }
  void take(const Surface& surface) {
    for (const SurfacePoint& p : surface) check(take(p.position, p.normal));
  }
  void begin_view(const std::optional<Vec3d>& scanner) { thinner_.begin_view({.scanner = scanner}); }
  Vec3d scan_position(std::uint32_t i) const { return cloud_.position[i].cast<double>() + thinner_.offset(); }
  const Cloud& cloud() const { return cloud_; }
  const PointThinner& thinner() const { return thinner_; }

 private:
  ArenaBlock arena_;
  Cloud cloud_;
  PointThinner thinner_;
};

Cell cell_of(const Vec3d& p, double side) {
  return {static_cast<std::int64_t>(std::floor(p[0] / side)), static_cast<std::int64_t>(std::floor(p[1] / side)),
          static_cast<std::int64_t>(std::floor(p[2] / side))};
}

TEST(PointThinner, KeepsAScanThatFitsUnchanged) {
  Random random(1);
  Surface surface = sphere(5000, 10, {100, 200, -300});
  shuffle(surface, random);
  Thinning thinning(5000, 0);
  thinning.take(surface);
  ASSERT_EQ(thinning.cloud().size, 5000U);
  EXPECT_EQ(thinning.thinner().cell(), 0);
  EXPECT_EQ(thinning.thinner().points_averaged(), 0U);
  for (std::uint32_t i = 0; i < 5000; ++i) {
    ASSERT_LT((thinning.scan_position(i) - surface[i].position).norm(), 1e-5);
    ASSERT_LT((thinning.cloud().normal[i].unpack().cast<double>() - surface[i].normal).norm(), 1e-4);
    ASSERT_EQ(thinning.cloud().normal[i].weight, 1);
  }
}

TEST(PointThinner, AveragesThePointsOfEachCell) {
  const double side = 0.5;
  Random random(2);
  Surface surface = sphere(4000, 4, {0, 0, 0});
  shuffle(surface, random);
  Thinning thinning(5000, side);
  thinning.take(surface);
  EXPECT_EQ(thinning.thinner().cell(), side);

  // The expected cells: counted from the first point, in the order of their first points.
  std::map<Cell, std::vector<Vec3d>> cells;
  for (const SurfacePoint& p : surface) {
    cells[cell_of((p.position - surface[0].position).cast<float>().cast<double>(), side)].push_back(p.position);
  }
  ASSERT_EQ(thinning.cloud().size, cells.size());
  EXPECT_EQ(thinning.thinner().points_averaged(), 4000U - cells.size());
  std::uint64_t weights = 0;
  for (std::uint32_t i = 0; i < thinning.cloud().size; ++i) {
    const auto it = cells.find(cell_of(thinning.cloud().position[i].cast<double>(), side));
    ASSERT_NE(it, cells.end());
    Vec3d mean = Vec3d::Zero();
    for (const Vec3d& p : it->second) mean += p / static_cast<double>(it->second.size());
    EXPECT_LT((thinning.scan_position(i) - mean).norm(), 1e-5);
    EXPECT_EQ(thinning.cloud().normal[i].weight, it->second.size());
    weights += thinning.cloud().normal[i].weight;
    cells.erase(it);
  }
  EXPECT_EQ(weights, 4000U);
}

/// Fills 100 cells with two points each.
/// @param often  the second normal of one cell in this many faces the opposite side
/// @returns cells whose normal has the direction of both
std::uint32_t cells_with_the_direction(std::uint32_t often) {
  Random random(6);
  Thinning thinning(200, 1);
  const Vec3d n = Vec3d(1, 2, 2) / 3;
  for (std::uint32_t cell = 0; cell < 100; ++cell) {
    check(thinning.take({cell + 0.1, 0, 0}, n + 0.1 * random.vector()));
    check(thinning.take({cell + 0.2, 0, 0}, (cell % often == 0 ? Vec3d(-n) : n) + 0.1 * random.vector()));
  }
  EXPECT_EQ(thinning.cloud().size, 100U);
  std::uint32_t right = 0;
  for (std::uint32_t i = 0; i < 100; ++i) {
    right += std::abs(thinning.cloud().normal[i].unpack().cast<double>().dot(n)) > 0.95 ? 1 : 0;
  }
  return right;
}

TEST(PointThinner, KeepsTheDirectionOfNormalsThatFaceEitherSideAtRandom) {
  EXPECT_GE(cells_with_the_direction(2), 90U) << "but for the first few";
  // A few are on both sides of a thin wall, and have no common direction.
  EXPECT_LT(cells_with_the_direction(20), 98U);
}

TEST(PointThinner, DoublesItsCellsAndStaysWithinItsCapacity) {
  Random random(3);
  Surface surface = sphere(60000, 10, {0, 0, 0});
  shuffle(surface, random);
  const double first_cell = 0.01;
  Thinning thinning(2000, first_cell);
  double cell = first_cell;
  for (const SurfacePoint& p : surface) {
    check(thinning.take(p.position, p.normal));
    ASSERT_LE(thinning.cloud().size, 2000U);
    if (thinning.thinner().cell() == cell) continue;
    const double doublings = std::log2(thinning.thinner().cell() / cell);
    ASSERT_EQ(doublings, std::round(doublings));
    ASSERT_GE(doublings, 1);
    ASSERT_LE(thinning.cloud().size, 1801U) << "the share that may stay used, and one new point";
    cell = thinning.thinner().cell();
  }
  EXPECT_GT(cell, first_cell);
  EXPECT_GT(thinning.cloud().size, 400U) << "on a surface, four cells become one, so a quarter stays";
  // Means of the points in a cell lie at most the cell's sagitta below the sphere.
  for (std::uint32_t i = 0; i < thinning.cloud().size; ++i) {
    const Vec3d p = thinning.scan_position(i);
    ASSERT_NEAR(p.norm(), 10, cell * cell * 3 / 20 + 1e-3);
    ASSERT_GT(thinning.cloud().normal[i].unpack().cast<double>().dot(p.normalized()), 0.99);
  }
}

TEST(PointThinner, DependsOnTheOrderOfThePointsAndNotOnHowTheyAreBatched) {
  Random random(4);
  Surface surface = sphere(20000, 10, {0, 0, 0});
  shuffle(surface, random);
  Thinning one_by_one(1500, 0);
  one_by_one.take(surface);
  Thinning at_once(1500, 0);
  std::vector<ScanPoint> all;
  for (const SurfacePoint& p : surface) {
    all.push_back({p.position[0], p.position[1], p.position[2], static_cast<float>(p.normal[0]),
                   static_cast<float>(p.normal[1]), static_cast<float>(p.normal[2])});
  }
  ArenaBlock arena(kMiB);
  Cloud cloud = value_of(Cloud::create(1500, *arena));
  PointThinner thinner(cloud, 1500, value_of(arena->take_top<std::byte>(PointThinner::table_bytes(1500), "test")),
                       Mat3d::Identity(), 0);
  check(thinner.take(all));
  ASSERT_EQ(cloud.size, one_by_one.cloud().size);
  EXPECT_EQ(thinner.cell(), one_by_one.thinner().cell());
  for (std::uint32_t i = 0; i < cloud.size; ++i) ASSERT_EQ(cloud.position[i], one_by_one.cloud().position[i]);
}

TEST(PointThinner, ChoosesACellFromTheExtentWhenItIsFull) {
  Random random(5);
  Surface surface = sphere(3000, 1000, {0, 0, 0});
  shuffle(surface, random);
  Thinning thinning(2000, 0);
  thinning.take(surface);
  EXPECT_GT(thinning.thinner().cell(), 0);
  EXPECT_LE(thinning.cloud().size, 2000U);
  EXPECT_GT(thinning.cloud().size, 400U);
}

TEST(PointThinner, ChoosesACellForTheScanAndNotForAPointFarAway) {
  Random random(4);
  Surface surface = sphere(3000, 10, {0, 0, 0});
  shuffle(surface, random);
  surface[100].position = Vec3d(1e6, 0, 0);
  Thinning thinning(1000, 0);
  thinning.take(surface);
  EXPECT_GT(thinning.cloud().size, 300U);
  EXPECT_LT(thinning.thinner().cell(), 2.5) << "1e6 / 4096 is 244";
}

TEST(PointThinner, RotatesPositionsAndNormals) {
  Random random(6);
  const Surface surface = sphere(100, 10, {1, 2, 3});
  const Mat3d rotation = rotation_matrix({30, 40, 50});
  Thinning thinning(100, 0, rotation);
  thinning.take(surface);
  for (std::uint32_t i = 0; i < 100; ++i) {
    EXPECT_LT((thinning.scan_position(i) - rotation * surface[i].position).norm(), 1e-5);
    EXPECT_LT((thinning.cloud().normal[i].unpack().cast<double>() - rotation * surface[i].normal).norm(), 1e-4);
  }
}

TEST(PointThinner, KeepsItsPrecisionFarFromTheOrigin) {
  Random random(7);
  const Vec3d far(6.1e6, -4.2e6, 1.7e5);  // coordinates as of a land survey
  const Surface surface = sphere(1000, 5, far);
  Thinning thinning(1000, 0);
  thinning.take(surface);
  for (std::uint32_t i = 0; i < 1000; ++i) EXPECT_LT((thinning.scan_position(i) - surface[i].position).norm(), 1e-5);
}

TEST(PointThinner, AcceptsExtentsThatOverflowTheIndexOfACell) {
  Random random(8);
  Thinning thinning(50, 1e-9);
  for (int i = 0; i < 5000; ++i) check(thinning.take(1e17 * random.vector()));
  EXPECT_LE(thinning.cloud().size, 50U);
  EXPECT_GT(thinning.cloud().size, 0U);
}

TEST(PointThinner, RefusesCoordinatesThatNoFloatHolds) {
  Thinning thinning(50, 0.1);
  check(thinning.take({0, 0, 0}));
  const Status status = thinning.take({1e30, 0, 0});
  ASSERT_FALSE(status.has_value());
  EXPECT_EQ(status.error().code(), ErrorCode::kMalformed);
}

TEST(PointThinner, AcceptsAnyNumberOfPointsInOnePlace) {
  for (const double cell : {0.0, 0.1}) {
    Thinning thinning(16, cell);
    for (int i = 0; i < 5000; ++i) check(thinning.take({1, 2, 3}, {0, 0, -1}));
    EXPECT_LE(thinning.cloud().size, 16U);
    EXPECT_LT((thinning.scan_position(0) - Vec3d(1, 2, 3)).norm(), 1e-6);
    EXPECT_LT((thinning.cloud().normal[0].unpack() - Vec3f(0, 0, -1)).norm(), 1e-4F);
  }
}

TEST(PointThinner, KnowsTheViewOfEachPoint) {
  Mat3d quarter;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Thinning thinning(2000, 0, quarter);
  const auto place = [](double v) { return Vec3d(10 * v, 5, -7); };
  for (int v = 0; v < 300; ++v) {
    const bool known = v != 3;
    thinning.begin_view(known ? std::optional(place(v)) : std::nullopt);
    if (v == 4) continue;  // nothing was seen
    for (int k = 0; k < 5; ++k) check(thinning.take({100.0 + v, k * 1.0, 0}));
  }
  thinning.begin_view(std::nullopt);
  check(thinning.take({0, 0, 0}));
  thinning.begin_view(place(12.4));
  check(thinning.take({0, 0, 1}));
  const CloudViews& views = thinning.cloud().views;
  ASSERT_EQ(views.count, kMaxViews);
  EXPECT_FALSE(views.has_scanner[3]);
  for (const std::uint32_t v : {0U, 2U, 4U, 254U}) {  // view 4 has no number
    const double asked = v < 4 ? v : v + 1;
    EXPECT_TRUE(views.has_scanner[v]);
    const Vec3d in_scan = quarter.transpose() * (views.scanner[v].cast<double>() + thinning.thinner().offset());
    EXPECT_LT((in_scan - place(asked)).norm(), 1e-4);
    EXPECT_EQ(thinning.cloud().view_of(5 * v), v);
    EXPECT_EQ(thinning.cloud().view_of(5 * v + 4), v);
  }
  EXPECT_EQ(thinning.cloud().view_of(5 * 280), 254) << "the nearest of those that there are";
  EXPECT_EQ(thinning.cloud().view_of(5 * 299), kNoView);
  EXPECT_EQ(thinning.cloud().view_of(5 * 299 + 1), 11) << "that of view 12";
}

TEST(PointThinner, IgnoresAMissingNormalWhenItAverages) {
  Thinning thinning(16, 1);
  check(thinning.take({0.1, 0.1, 0.1}, {0, 0, 0}));
  EXPECT_FALSE(thinning.cloud().normal[0].known());
  check(thinning.take({0.2, 0.1, 0.1}, {0, 1, 0}));
  check(thinning.take({0.3, 0.1, 0.1}, {0, 0, 0}));
  ASSERT_EQ(thinning.cloud().size, 1U);
  EXPECT_LT((thinning.cloud().normal[0].unpack() - Vec3f(0, 1, 0)).norm(), 1e-4F);
}

}  // namespace
}  // namespace plumbline
