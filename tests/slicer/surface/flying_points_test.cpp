/// Flying points around an object: its size and its place are those without them.

#include "slicer/surface/flying_points.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

constexpr float kPitch = 0.25F;  ///< mm, of pixels and layers

/// 100 points around a surface.
using Strays = std::function<Surface(const Surface& object, Random& random)>;

Box3d bounds_of(const Surface& surface) {
  Box3d box;
  for (const SurfacePoint& p : surface) box.extend(p.position);
  return box;
}

/// A place in a box 1.8 times as large as the object's.
Vec3d around(const Box3d& box, Random& random) {
  const Vec3d at(random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9));
  return box.centre() + box.size().cwiseProduct(at);
}

Surface lone(const Surface& object, Random& random) {
  Surface strays;
  for (int i = 0; i < 100; ++i) strays.push_back({around(bounds_of(object), random), random.vector().normalized()});
  return strays;
}

Surface clumps(const Surface& object, Random& random) {
  Surface strays;
  for (int clump = 0; clump < 10; ++clump) {
    const Vec3d at = around(bounds_of(object), random);
    const Vec3d normal = random.vector().normalized();
    for (int i = 0; i < 10; ++i) strays.push_back({at + 0.05 * random.vector(), normal});
  }
  return strays;
}

/// Flying pixels: off the surface, with its normals.
Surface flying(const Surface& object, Random& random) {
  Surface strays;
  for (int i = 0; i < 100; ++i) {
    const SurfacePoint& p = object[random.below(static_cast<std::uint32_t>(object.size()))];
    strays.push_back({p.position + random.uniform(0, 5) * p.normal, p.normal});
  }
  return strays;
}

/// Strings of flying pixels that begin at the surface.
Surface strings(const Surface& object, Random& random) {
  Surface strays;
  for (int string = 0; string < 5; ++string) {
    const SurfacePoint& p = object[random.below(static_cast<std::uint32_t>(object.size()))];
    for (int i = 1; i <= 20; ++i) strays.push_back({p.position + 0.3 * i * p.normal, p.normal});
  }
  return strays;
}

std::vector<std::pair<std::string, Surface>> objects() {
  Random random(11);
  std::vector<std::pair<std::string, Surface>> all;
  all.emplace_back("ball", sphere(8000, 10, {0, 0, 10}));
  all.emplace_back("box", box({-10, -6, 0}, {10, 6, 16}, 0.4, 0.3, random));
  all.emplace_back("torus", torus(10, 4, {0, 0, 4}, 0.4, 2));
  for (auto& [name, surface] : all) add_noise(surface, 0.005, 0.01, random);
  return all;
}

SliceSettings on_a_printer(bool fit) {
  SliceSettings settings = settings_with_pitch(kPitch);
  settings.placement.printer = PrinterVolume{320, 320, kPitch, kPitch, 80};
  settings.placement.fit = fit;
  return settings;
}

Placement placement_of(const Surface& surface, bool fit) {
  return Slicing(binary_ply(surface), on_a_printer(fit), 64 * kMiB).report().placement;
}

void expect_alike(const Strays& strays, bool fit) {
  for (const auto& [name, object] : objects()) {
    SCOPED_TRACE(name);
    Random random(7);
    Surface with = object;
    append(with, strays(object, random));
    shuffle(with, random);
    const Placement expected = placement_of(object, fit);
    const Placement found = placement_of(with, fit);
    // At the scale of the print; the test compares places of the scan's own points.
    const Vec3d size = found.size_mm - expected.size_mm;
    const Vec3d centre = (found.scale - expected.scale) * bounds_of(object).centre() + found.shift - expected.shift;
    EXPECT_LT(size.cwiseAbs().maxCoeff(), static_cast<double>(kPitch)) << size.transpose();
    EXPECT_LT(centre.cwiseAbs().maxCoeff(), static_cast<double>(kPitch)) << centre.transpose();
  }
}

TEST(FlyingPoints, LoneOnesDoNotChangeSizeOrPlace) { expect_alike(lone, false); }
TEST(FlyingPoints, LoneOnesDoNotChangeTheScaleThatFits) { expect_alike(lone, true); }
TEST(FlyingPoints, ClumpsDoNotChangeSizeOrPlace) { expect_alike(clumps, false); }
TEST(FlyingPoints, ClumpsDoNotChangeTheScaleThatFits) { expect_alike(clumps, true); }
TEST(FlyingPoints, OffTheSurfaceDoNotChangeSizeOrPlace) { expect_alike(flying, false); }
TEST(FlyingPoints, StringsDoNotChangeSizeOrPlace) { expect_alike(strings, false); }
TEST(FlyingPoints, StringsDoNotChangeTheScaleThatFits) { expect_alike(strings, true); }

/// How many points of a surface count as flying.
std::uint32_t flying_in(const Surface& surface) {
  ArenaBlock arena(64 * kMiB);
  Cloud cloud = cloud_of(surface, *arena);
  const KdTree3 tree = sort_by_tree(cloud, *arena);
  const float epsilon = value_of(density_epsilon(cloud, tree, *arena));
  ClusteringResult clustering = value_of(cluster(cloud, tree, epsilon, *arena));
  return value_of(mark_flying_points(cloud, tree, clustering, *arena));
}

TEST(FlyingPoints, AreNotInAScanWithoutThem) {
  for (const auto& [name, object] : objects()) EXPECT_EQ(flying_in(object), 0U) << name;
}

/// A cone, whose tip is the highest point.
Surface cone(double radius, double height, double spacing) {
  Surface surface;
  const double slant = std::sqrt(radius * radius + height * height);
  for (double along = 0; along < slant; along += spacing) {
    const double r = radius * (1 - along / slant);
    const auto count = static_cast<int>(2 * kPi * r / spacing) + 1;
    for (int i = 0; i < count; ++i) {
      const double a = 2 * kPi * (i + 0.4 * along) / count;
      const Vec3d out(std::cos(a), std::sin(a), 0);
      surface.push_back(
          {r * out + Vec3d(0, 0, height * along / slant), (height * out + Vec3d(0, 0, radius)).normalized()});
    }
  }
  return surface;
}

TEST(FlyingPoints, AreNotTheTipOfACone) {
  for (const double radius : {3.0, 6.0, 12.0}) EXPECT_EQ(flying_in(cone(radius, 20, 0.4)), 0U) << radius;
}

TEST(FlyingPoints, AreNotInAScanOfAFewPoints) { EXPECT_EQ(flying_in(sphere(24, 10, {0, 0, 0})), 0U); }

}  // namespace
}  // namespace plumbline
