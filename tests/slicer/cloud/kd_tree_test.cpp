#include "slicer/cloud/kd_tree.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;
using Points = std::vector<Vec3f>;

Points uniform_points(std::uint32_t count, Random& random) {
  Points points(count);
  for (Vec3f& p : points) p = Vec3d(random.uniform(0, 10), random.uniform(0, 10), random.uniform(0, 10)).cast<float>();
  return points;
}
/// Points with integer coordinates: many equal distances, many equal points.
Points lattice_points(std::uint32_t count, Random& random) {
  Points points(count);
  for (Vec3f& p : points) {
    for (int a = 0; a < 3; ++a) p[a] = static_cast<float>(random.below(6));
  }
  return points;
}
Points collinear_points(std::uint32_t count, Random& random) {
  Points points(count);
  for (Vec3f& p : points) p = Vec3f(1, 2, 3) + static_cast<float>(random.uniform(0, 10)) * Vec3f(1, -1, 0.5F);
  return points;
}
Points equal_points(std::uint32_t count, Random& /*random*/) { return Points(count, Vec3f(1, 2, 3)); }

/// Summed as the tree does: in floats, one dimension after another.
template <int Dimension>
float distance2(const Vec3f& a, const Vec3f& b) {
  float sum = 0;
  for (int d = 0; d < Dimension; ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

template <int Dimension, class Accept>
std::vector<Neighbour> nearest_by_looking(const Points& points, const Vec3f& query, std::size_t count, Accept accept) {
  std::vector<Neighbour> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (accept(i)) all.push_back({i, distance2<Dimension>(points[i], query)});
  }
  std::sort(all.begin(), all.end(), [](const Neighbour& a, const Neighbour& b) {
    return std::tie(a.distance2, a.index) < std::tie(b.distance2, b.index);
  });
  all.resize(std::min(all.size(), count));
  return all;
}

template <int Dimension>
void expect_nearest(const KdTree<Dimension>& tree, const Points& points, Random& random) {
  const auto even = [](std::uint32_t i) { return i % 2 == 0; };
  const auto any = [](std::uint32_t) { return true; };
  for (int i = 0; i < 60; ++i) {
    Vec3f query = Vec3d(random.uniform(-2, 12), random.uniform(-2, 12), random.uniform(-2, 12)).cast<float>();
    if (i % 2 == 0) query = points[random.below(static_cast<std::uint32_t>(points.size()))];
    for (const std::size_t wanted : {1U, 7U, 61U}) {
      std::vector<Neighbour> found(wanted);
      for (const bool only_even : {false, true}) {
        found.resize(wanted);
        found.resize(only_even ? tree.nearest(query, found, even) : tree.nearest(query, found));
        const auto expected = only_even ? nearest_by_looking<Dimension>(points, query, wanted, even)
                                        : nearest_by_looking<Dimension>(points, query, wanted, any);
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t k = 0; k < found.size(); ++k) {
          ASSERT_EQ(found[k].index, expected[k].index) << "neighbour " << k << " of " << wanted;
          ASSERT_EQ(found[k].distance2, expected[k].distance2);
        }
        if (expected.empty()) continue;
        const float most2 = 1.001F * expected[expected.size() / 2].distance2;
        const auto within =
            std::count_if(expected.begin(), expected.end(), [&](const Neighbour& n) { return n.distance2 <= most2; });
        const auto limited =
            only_even ? tree.nearest(query, found, even, most2) : tree.nearest(query, found, any, most2);
        ASSERT_EQ(limited, within);
        for (std::size_t k = 0; k < limited; ++k) ASSERT_EQ(found[k].index, expected[k].index);
      }
    }
  }
}

template <int Dimension>
void expect_within(const KdTree<Dimension>& tree, const Points& points, Random& random) {
  for (int i = 0; i < 60; ++i) {
    const Vec3f query = points[random.below(static_cast<std::uint32_t>(points.size()))];
    const auto most2 = static_cast<float>(i % 4);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t p = 0; p < points.size(); ++p) {
      if (distance2<Dimension>(points[p], query) <= most2) expected.push_back(p);
    }
    std::vector<Neighbour> room(points.size() + 1);
    room.resize(tree.within(query, most2, room));
    std::vector<std::uint32_t> found;
    for (const Neighbour& n : room) {
      EXPECT_EQ(n.distance2, distance2<Dimension>(points[n.index], query));
      found.push_back(n.index);
    }
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found, expected);
    std::array<Neighbour, 2> few;
    ASSERT_EQ(tree.within(query, most2, few), std::min<std::size_t>(2, expected.size())) << "ends where its room does";
  }
}

template <int Dimension>
void expect_boxes(const KdTree<Dimension>& tree, const Points& points, Random& random) {
  const auto order = tree.order();
  for (int i = 0; i < 60; ++i) {
    Vec3f low;
    Vec3f high;
    for (int a = 0; a < 3; ++a) {
      low[a] = static_cast<float>(random.uniform(-1, 10));
      high[a] = low[a] + static_cast<float>(i % 3 == 0 ? 0 : random.uniform(0, 5));
    }
    if (i % 5 == 0) low = high = points[random.below(static_cast<std::uint32_t>(points.size()))];
    std::vector<bool> visited(points.size(), false);
    std::uint32_t end = 0;
    bool first_call = true;
    tree.visit_box(low, high, [&](std::uint32_t first, std::uint32_t last) {
      ASSERT_LT(first, last);
      ASSERT_LE(last, points.size());
      ASSERT_TRUE(first_call || first > end) << "ascending, adjacent ranges joined";
      first_call = false;
      end = last;
      for (std::uint32_t k = first; k < last; ++k) visited[order[k]] = true;
    });
    for (std::uint32_t p = 0; p < points.size(); ++p) {
      bool inside = true;
      for (int a = 0; a < Dimension; ++a) inside &= points[p][a] >= low[a] && points[p][a] <= high[a];
      ASSERT_TRUE(!inside || visited[p]) << "point " << p << " was not visited";
    }
  }
}

template <int Dimension>
void expect_brute_force(Points (*make)(std::uint32_t, Random&)) {
  for (const std::uint32_t count : {1U, 2U, 10U, 11U, 1000U}) {
    Random random(count);
    const Points points = make(count, random);
    ArenaBlock arena(kMiB);
    const auto tree = value_of(KdTree<Dimension>::build(points, *arena, "test"));
    std::vector<std::uint32_t> order(tree.order().begin(), tree.order().end());
    std::sort(order.begin(), order.end());
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0);
    ASSERT_EQ(order, all) << "the order is a permutation";
    expect_nearest<Dimension>(tree, points, random);
    expect_within<Dimension>(tree, points, random);
    expect_boxes<Dimension>(tree, points, random);
  }
}

TEST(KdTree, AgreesWithBruteForceInThreeDimensions) { expect_brute_force<3>(uniform_points); }
TEST(KdTree, AgreesWithBruteForceInTwoDimensions) { expect_brute_force<2>(uniform_points); }
TEST(KdTree, BreaksTiesByIndexInThreeDimensions) { expect_brute_force<3>(lattice_points); }
TEST(KdTree, BreaksTiesByIndexInTwoDimensions) { expect_brute_force<2>(lattice_points); }
TEST(KdTree, AcceptsPointsOnALine) {
  expect_brute_force<3>(collinear_points);
  expect_brute_force<2>(collinear_points);
}
TEST(KdTree, AcceptsPointsAllInOnePlace) {
  expect_brute_force<3>(equal_points);
  expect_brute_force<2>(equal_points);
}

TEST(KdTree, FindsTheSameAfterThePointsTookItsOrder) {
  Random random(8);
  Points points = uniform_points(2000, random);
  ArenaBlock arena(kMiB);
  KdTree3 tree = value_of(KdTree3::build(points, *arena, "test"));
  const std::vector<std::uint32_t> order(tree.order().begin(), tree.order().end());
  const Points before = points;
  for (std::uint32_t i = 0; i < points.size(); ++i) points[i] = before[order[i]];
  std::iota(tree.order().begin(), tree.order().end(), 0);
  expect_nearest<3>(tree, points, random);
  expect_boxes<3>(tree, points, random);
}

TEST(KdTree, IgnoresTheThirdCoordinateInTwoDimensions) {
  const Points points = {{1, 1, 900}, {2, 1, 0}, {4, 1, -900}};
  ArenaBlock arena(kMiB);
  const KdTree2 tree = value_of(KdTree2::build(points, *arena, "test"));
  std::vector<Neighbour> found(3);
  ASSERT_EQ(tree.nearest({0, 1, 0}, found), 3U);
  EXPECT_EQ(found[0].index, 0U);
  EXPECT_EQ(found[1].index, 1U);
  EXPECT_EQ(found[2].distance2, 16);
}

TEST(KdTree, TakesNoMoreOfTheArenaThanPlanned) {
  Random random(9);
  Surface surface = sphere(200000, 20, {20, 20, 20});
  add_noise(surface, 0.02, 0, random);
  shuffle(surface, random);
  Points points;
  for (const SurfacePoint& p : surface) points.push_back(p.position.cast<float>());
  ArenaBlock arena(32 * kMiB);
  ASSERT_TRUE(KdTree3::build(points, *arena, "test").has_value());
  const std::size_t three = arena->top_used();
  EXPECT_GT(three, points.size() * sizeof(std::uint32_t)) << "the index alone needs this";
  EXPECT_LT(three, points.size() * KdTree3::kBytesPerPoint);
  EXPECT_EQ(arena->bottom_used(), 0U);
  ASSERT_TRUE(KdTree2::build(points, *arena, "test").has_value());
  EXPECT_LT(arena->top_used() - three, points.size() * KdTree2::kBytesPerPoint);
}

TEST(KdTree, ReturnsOutOfMemoryInEveryArenaThatIsTooSmall) {
  Random random(10);
  const Points points = uniform_points(20000, random);
  std::size_t built = 0;
  std::size_t refused = 0;
  for (std::size_t bytes = 0; bytes < kMiB; bytes += 8191) {
    ArenaBlock arena(bytes);
    const auto tree = KdTree3::build(points, *arena, "the stage");
    if (tree) {
      ++built;
      continue;
    }
    ++refused;
    EXPECT_EQ(tree.error().code(), ErrorCode::kOutOfMemory);
    EXPECT_NE(std::string(tree.error().message()).find("the stage"), std::string::npos);
  }
  EXPECT_GT(built, 0U);
  EXPECT_GT(refused, 0U);
}

/// Leaves the number of threads as it was.
class ManyThreads {
 public:
  explicit ManyThreads(int threads) { omp_set_num_threads(threads); }
  ~ManyThreads() { omp_set_num_threads(before_); }
  ManyThreads(const ManyThreads&) = delete;
  ManyThreads& operator=(const ManyThreads&) = delete;

 private:
  int before_ = omp_get_max_threads();
};

/// Enough points that several threads build their tree; most in a corner, so that the parts are of very different sizes.
Points crowded_points(std::uint32_t count, Random& random) {
  Points points = uniform_points(count, random);
  for (std::uint32_t i = 0; i < count; ++i) points[i] *= i % 16 == 0 ? 1 : 0.01F;
  return points;
}

template <int Dimension>
void expect_same_for_any_number_of_threads(const Points& points) {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> ranges;
  for (const int threads : {1, 2, 3, 8}) {
    const ManyThreads set(threads);
    ArenaBlock arena(8 * kMiB);
    const auto tree = value_of(KdTree<Dimension>::build(points, *arena, "test"));
    EXPECT_LT(arena->top_used(), points.size() * KdTree<Dimension>::kBytesPerPoint) << threads;
    std::vector<std::uint32_t> visited;
    for (const Vec3f& at : {points[0], points[1], points[points.size() / 2]}) {
      const Vec3f half = Vec3f::Constant(0.05F);
      tree.visit_box(at - half, at + half, [&](std::uint32_t first, std::uint32_t last) {
        visited.insert(visited.end(), {first, last});
      });
    }
    if (threads == 1) {
      order.assign(tree.order().begin(), tree.order().end());
      ranges = visited;
    }
    EXPECT_TRUE(std::ranges::equal(tree.order(), order)) << threads;
    EXPECT_EQ(visited, ranges) << threads;
  }
}

TEST(KdTree, IsTheSameForAnyNumberOfThreads) {
  Random random(11);
  const Points points = crowded_points(300000, random);
  expect_same_for_any_number_of_threads<3>(points);
  expect_same_for_any_number_of_threads<2>(points);
  Random others(12);
  expect_same_for_any_number_of_threads<3>(lattice_points(100000, others));
  expect_same_for_any_number_of_threads<3>(equal_points(100000, others));
}

TEST(KdTree, ReturnsOutOfMemoryWhenSeveralThreadsBuildIt) {
  const ManyThreads set(3);
  Random random(13);
  const Points points = crowded_points(100000, random);
  std::size_t built = 0;
  for (std::size_t bytes = 0; bytes < 2 * kMiB; bytes += 65521) {
    ArenaBlock arena(bytes);
    const auto tree = KdTree3::build(points, *arena, "the stage");
    built += tree ? 1 : 0;
    if (!tree) {
      EXPECT_EQ(tree.error().code(), ErrorCode::kOutOfMemory);
    }
  }
  EXPECT_GT(built, 0U);
  EXPECT_LT(built, 32U);
}

/// Cancels at the given report.
class Cancelling final : public ProgressSink {
 public:
  explicit Cancelling(int at) : at_(at) {}
  void begin(Stage /*stage*/) override {}
  bool advance(Stage /*stage*/, double fraction) override {
    EXPECT_GE(fraction, last_);
    last_ = fraction;
    return at_-- > 0;
  }
  void end(Stage /*stage*/, std::size_t /*peak*/) override {}

 private:
  int at_;
  double last_ = 0;
};

TEST(KdTree, CanBeCancelled) {
  Random random(14);
  const Points points = crowded_points(100000, random);
  // Only the caller's thread reports. Of several threads it may build little, so only its first report is certain.
  for (const auto& [threads, at] : {std::pair{3, 0}, std::pair{1, 1}, std::pair{1, 20}}) {
    const ManyThreads set(threads);
    Cancelling progress(at);
    ArenaBlock arena(4 * kMiB);
    const auto tree = KdTree3::build(points, *arena, "the stage", {&progress, Stage::kTrees});
    ASSERT_FALSE(tree.has_value()) << at;
    EXPECT_EQ(tree.error().code(), ErrorCode::kCancelled);
  }
}

}  // namespace
}  // namespace plumbline
