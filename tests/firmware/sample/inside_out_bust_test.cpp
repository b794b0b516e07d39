/// Slices the sample scan with normals that face into the bust. The oracle is the same scan with the right normals.

#include <gtest/gtest.h>

#include "firmware/sample/scan_sample.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/wrong_normals.hpp"

namespace plumbline::firmware {
namespace {

using namespace testing;
using ::testing::TestParamInfo;
using ::testing::TestWithParam;
using ::testing::ValuesIn;

constexpr std::uint64_t kPoints = 60'000;
constexpr std::size_t kViews = 22;

/// Keeps the points, and which view they are of.
class BustScan final : public PointSink {
 public:
  BustScan() { check(scan_bust({.points = kPoints}, *this)); }
  Status begin(const ScanHeader& /*header*/) override { return {}; }
  Status take(std::span<const ScanPoint> points) override {
    for (const ScanPoint& p : points) {
      surface.push_back({{p.x, p.y, p.z}, Vec3f(p.nx, p.ny, p.nz).cast<double>()});
      view_of.push_back(view_);
    }
    return {};
  }
  bool progress(double fraction) override {
    // Counting takes the first tenth, then come the views. A batch may hold the last points of the view before.
    view_ = static_cast<std::size_t>(std::max(0.0, fraction - 0.1) / 0.9 * kViews);
    return true;
  }

  Surface surface;
  std::vector<std::size_t> view_of;

 private:
  std::size_t view_ = 0;
};

class WronglyOrientedBust : public TestWithParam<WrongNormals> {};

TEST_P(WronglyOrientedBust, HasTheVolumeOfTheRightOne) {
  const BustScan scan;
  Random random(12);
  const auto sliced = [](const Surface& surface) {
    return Slicing(binary_ply(surface), settings_with_pitch(0.2F), 96 * kMiB);
  };
  const double right = sliced(scan.surface).volume();
  const Slicing slicing = sliced(with_wrong_normals(scan.surface, GetParam(), scan.view_of, random));
  EXPECT_NEAR(slicing.volume(), right, 0.02 * right);
  EXPECT_EQ(slicing.report().normals.inside_out, GetParam() == WrongNormals::kAllInward);
}

INSTANTIATE_TEST_SUITE_P(Each, WronglyOrientedBust, ValuesIn(kWrongNormals),
                         [](const TestParamInfo<WrongNormals>& test) { return to_string(test.param); });

}  // namespace
}  // namespace plumbline::firmware
