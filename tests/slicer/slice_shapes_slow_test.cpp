/// A sphere at the full resolution of a panel.

#include <gtest/gtest.h>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

TEST(SliceShapesSlow, ASphereOfTwentyMillimetresAtFiftyMicrometresHasItsVolumeWithinAThousandth) {
  const Slicing sliced(binary_ply(sphere(200000, 20, {0, 0, 0})), settings_with_pitch(0.05F), 256 * kMiB);
  EXPECT_NEAR(sliced.volume() / (4.0 / 3 * kPi * 8000), 1, 0.001);
  EXPECT_EQ(sliced.wrong_voxels([](const Vec3d& p) { return p.norm() - 20; }, 0.04), 0U);
  EXPECT_EQ(sliced.report().components.solids, 1U);
}

}  // namespace
}  // namespace plumbline
