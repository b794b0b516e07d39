#include "slicer/surface/refined_normals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

#include "slicer/normals/normals.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr double kLength = 2;     ///< wavelength, mm
constexpr double kHeight = 0.15;  ///< amplitude of the waves, mm

Vec3d wave_normal(double x, double blur) {
  // A scanner's window damps the slope that it sees.
  const double slope = blur * kHeight * 2 * kPi / kLength * std::cos(2 * kPi * x / kLength);
  const Vec3d n(-slope, 0, 1);
  return n / std::sqrt(n.dot(n));
}

/// Waves along x over 16 mm x 16 mm. Their normals show `blur` times the true slope.
Surface waves(double blur, double noise) {
  Random random(5);
  Surface surface;
  for (double y = 0; y < 16; y += 0.1) {
    for (double x = 0; x < 16; x += 0.1) {
      const double at = x + random.uniform(-0.05, 0.05);
      const double z = kHeight * std::sin(2 * kPi * at / kLength) + random.uniform(-noise, noise);
      surface.push_back({Vec3d(at, y + random.uniform(-0.05, 0.05), z), wave_normal(at, blur)});
    }
  }
  return surface;
}

/// The plane z = 0 over 16 mm x 16 mm with points up to `most` mm off it.
Surface noisy_plane(const Vec3d& normal, double most = 0.03) {
  Random random(2);
  Surface plane;
  for (double y = 0; y < 16; y += 0.1) {
    for (double x = 0; x < 16; x += 0.1) plane.push_back({Vec3d(x, y, random.uniform(-most, most)), normal});
  }
  return plane;
}

ClusteringResult clustered(Cloud& cloud, const KdTree3& tree, Arena& arena) {
  return value_of(cluster(cloud, tree, value_of(density_epsilon(cloud, tree, arena)), arena));
}

struct Refined {
  ArenaBlock block{32 * kMiB};
  ClusteringResult clustering;
  double before = 0, after = 0;  ///< mean error of the normals, degrees

  explicit Refined(const Surface& surface, NormalSource source = NormalSource::kScanner) {
    Arena& arena = *block;
    Cloud cloud = cloud_of(surface, arena);
    const KdTree3 tree = sort_by_tree(cloud, arena);
    clustering = clustered(cloud, tree, arena);
    std::vector<PackedNormal> refined(cloud.size);
    EXPECT_TRUE(refine_normals(cloud, tree, clustering, source, refined));
    std::uint32_t counted = 0;
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      const Vec3f& p = cloud.position[i];
      if (p[0] < 2 || p[0] > 14 || p[1] < 2 || p[1] > 14) continue;  // the rim has neighbours on one side only
      const Vec3d truth = wave_normal(static_cast<double>(p[0]), 1);
      before += angle(truth, cloud.normal[i].unpack());
      after += angle(truth, refined[i].unpack());
      EXPECT_EQ(refined[i].point_class, orientation_of(refined[i]));
      ++counted;
    }
    before /= counted;
    after /= counted;
  }
  static double angle(const Vec3d& a, const Vec3f& b) {
    return std::acos(std::min(1.0, a.dot(b.cast<double>()))) * 180 / kPi;
  }
};

TEST(RefinedNormals, AreSharperThanThoseOfAWideWindow) {
  const Refined waves_seen_flat(waves(0.6, 0));
  EXPECT_GT(waves_seen_flat.before, 5);
  EXPECT_LT(waves_seen_flat.after, 0.4 * waves_seen_flat.before);
}

TEST(RefinedNormals, OfAnExactScanStayExact) {
  const Refined exact(waves(1, 0));
  EXPECT_LT(exact.before, 0.2) << "rounding of packed normals";
  EXPECT_LT(exact.after, 3);
  EXPECT_LT(Refined(waves(1, 0), NormalSource::kPoints).after, 3);
}

TEST(RefinedNormals, DontFollowNoise) {
  ArenaBlock block(32 * kMiB);
  Cloud cloud = cloud_of(noisy_plane({0, 0, 1}), *block);
  const KdTree3 tree = sort_by_tree(cloud, *block);
  ClusteringResult clustering = clustered(cloud, tree, *block);
  const auto mean_error = [&] {
    std::vector<PackedNormal> refined(cloud.size);
    EXPECT_TRUE(refine_normals(cloud, tree, clustering, NormalSource::kScanner, refined));
    double sum = 0;
    for (const PackedNormal& n : refined) sum += Refined::angle(Vec3d(0, 0, 1), n.unpack());
    return sum / cloud.size;
  };
  const double error = mean_error();
  clustering.noise = 0;
  EXPECT_LT(error, 0.25 * mean_error()) << "degrees; against normals that follow every point";
}

// Two fifths of these points are farther off than the noise, and once lost their good normals to those of twenty noisy points.
TEST(RefinedNormals, OfPointsThatNoisePutOffTheirSheetAreKept) {
  ArenaBlock block(32 * kMiB);
  Cloud cloud = cloud_of(noisy_plane({0, 0, 1}, 0.1), *block);
  const KdTree3 tree = sort_by_tree(cloud, *block);
  const ClusteringResult clustering = clustered(cloud, tree, *block);
  std::vector<PackedNormal> refined(cloud.size);
  ASSERT_TRUE(refine_normals(cloud, tree, clustering, NormalSource::kScanner, refined));
  std::uint32_t off = 0;
  std::uint32_t tilted = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (cloud.normal[i].point_class == PointClass::kNoise) continue;
    off += std::abs(cloud.position[i][2]) > clustering.noise ? 1 : 0;
    tilted += Refined::angle(Vec3d(0, 0, 1), refined[i].unpack()) > 5 ? 1 : 0;
  }
  EXPECT_GT(off, cloud.size / 4);
  EXPECT_LT(tilted, cloud.size / 100);
}

// A noisy scan without normals once got a rougher surface than the same scan with normals.
TEST(RefinedNormals, AreFittedToMorePointsIfEstimatedFromANoisyScan) {
  ArenaBlock block(32 * kMiB);
  Cloud cloud = cloud_of(noisy_plane({0, 0, 0}), *block);
  const KdTree3 tree = sort_by_tree(cloud, *block);
  EXPECT_EQ(value_of(complete_normals(cloud, tree, *block)).estimated, cloud.size);
  const ClusteringResult clustering = clustered(cloud, tree, *block);
  const auto mean_error = [&](std::span<const PackedNormal> normals) {
    double sum = 0;
    for (const PackedNormal& n : normals) sum += std::asin(std::hypot(n.unpack()[0], n.unpack()[1])) * 180 / kPi;
    return sum / cloud.size;
  };
  std::vector<PackedNormal> as_scanned(cloud.size);
  std::vector<PackedNormal> as_estimated(cloud.size);
  EXPECT_TRUE(refine_normals(cloud, tree, clustering, NormalSource::kScanner, as_scanned));
  EXPECT_TRUE(refine_normals(cloud, tree, clustering, NormalSource::kPoints, as_estimated));
  EXPECT_LT(mean_error(as_estimated), 0.5 * mean_error(as_scanned)) << "degrees";
}

// A bore was once closed because its walls had the normals of the face around its mouth.
TEST(RefinedNormals, BelowAnEdgeDontStayThoseOfTheFaceAbove) {
  Random random(3);
  Surface scan = sheet({0, 0, 0}, {8, 0, 0}, {0, 8, 0}, 0.1, 0.5, random);
  for (const SurfacePoint& p : sheet({8, 0, -8}, {0, 8, 0}, {0, 0, 8}, 0.1, 0.5, random)) {
    const bool blurred = p.position[2] > -0.25;
    scan.push_back({p.position, blurred ? Vec3d(0, 0, 1) : p.normal});
  }
  ArenaBlock block(32 * kMiB);
  Cloud cloud = cloud_of(scan, *block);
  const KdTree3 tree = sort_by_tree(cloud, *block);
  const ClusteringResult clustering = clustered(cloud, tree, *block);
  std::vector<PackedNormal> refined(cloud.size);
  ASSERT_TRUE(refine_normals(cloud, tree, clustering, NormalSource::kScanner, refined));
  std::uint32_t wrong = 0;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    const Vec3f& p = cloud.position[i];
    if (p[0] < 7.999F || p[2] > -0.1F || p[2] < -0.25F || p[1] < 1 || p[1] > 7) continue;
    ++count;
    wrong += Refined::angle(Vec3d(1, 0, 0), refined[i].unpack()) > 30 ? 1 : 0;
  }
  EXPECT_GT(count, 60U);
  EXPECT_LT(wrong, count / 3) << "all of them are wrong as scanned";
}

}  // namespace
}  // namespace plumbline
