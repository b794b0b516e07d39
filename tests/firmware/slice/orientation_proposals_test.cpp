#include "firmware/slice/orientation_proposals.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <vector>

namespace plumbline::firmware {
namespace {

/// The faces of a box of 10 x 20 x 40, in patches of a side of 1.
std::vector<SurfaceSample> box_patches() {
  constexpr std::array kSize = {10, 20, 40};
  std::vector<SurfaceSample> patches;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int side : {0, 1}) {
      for (int i = 0; i < kSize[u]; ++i) {
        for (int k = 0; k < kSize[v]; ++k) {
          SurfaceSample& patch = patches.emplace_back();
          patch.position[static_cast<int>(axis)] = static_cast<float>(side * kSize[axis]);
          patch.position[static_cast<int>(u)] = static_cast<float>(i) + 0.5F;
          patch.position[static_cast<int>(v)] = static_cast<float>(k) + 0.5F;
          patch.normal = Vec3f::Zero();
          patch.normal[static_cast<int>(axis)] = side == 1 ? 1.0F : -1.0F;
          patch.area = 1;
        }
      }
    }
  }
  return patches;
}

Proposals propose(const PlacementSettings& placement) {
  const auto patches = box_patches();
  const SurfaceSamples samples{.patches = patches, .cell = 1, .area = 2 * (200 + 400 + 800)};
  SliceSettings settings;
  settings.placement = placement;
  std::vector<std::byte> block(1U << 16U);
  Arena arena(block);
  return propose_orientations({}, samples, {}, settings, arena, {}).value();
}

/// Of the box, turned.
double height_of(const Proposal& way) {
  const Mat3d turn = rotation_matrix({way.degrees[0], way.degrees[1], 0});
  return turn.row(2).cwiseAbs().dot(Vec3d(10, 20, 40).transpose());
}

TEST(OrientationProposals, AreInMillimetresOfThePrint) {
  PlacementSettings placement;
  placement.scale = 0.5;
  const Proposals proposals = propose(placement);
  EXPECT_EQ(proposals[0].degrees, (std::array<double, 2>{0, 0}));
  EXPECT_NEAR(proposals[0].height_mm, 20, 1e-3);
  EXPECT_EQ(proposals[0].layers, 400U);
  EXPECT_EQ(proposals[0].counted, 0U) << "no supports are wanted";
  EXPECT_NEAR(proposals[0].peel_mm2, 5 * 10, 1);
  EXPECT_NEAR(proposals[0].support_mm2, 0, 1e-6) << "it stands on a flat foot";
  for (std::size_t i = 2; i < proposals.size(); ++i) EXPECT_LE(proposals[i - 1].cost, proposals[i].cost);
  for (const Proposal& way : proposals) EXPECT_LE(proposals[best_of(proposals)].cost, way.cost);
}

// Regression: each had the height that was asked for, so their sizes differed, and none was what a turn of the scan gave.
TEST(OrientationProposals, AllHaveTheSizeOfTheScanAsItCame) {
  PlacementSettings placement;
  placement.size = PrintSize{Side::kHeight, 30};
  const Proposals proposals = propose(placement);
  EXPECT_NEAR(proposals[0].height_mm, 30, 0.1);
  for (const Proposal& way : proposals) {
    EXPECT_NEAR(way.height_mm, 0.75 * height_of(way), 0.75) << way.degrees[0] << ", " << way.degrees[1];
  }
  EXPECT_NEAR(proposals[0].peel_mm2, 10 * 20 * 0.75 * 0.75, 2);
  placement.size = PrintSize{Side::kLength, 80};
  EXPECT_NEAR(propose(placement)[0].height_mm, 80, 0.5);
}

TEST(OrientationProposals, CanBeCancelled) {
  struct Never final : ProgressSink {
    void begin(Stage /*stage*/) override {}
    bool advance(Stage /*stage*/, double /*fraction*/) override { return false; }
    void end(Stage /*stage*/, std::size_t /*peak_bytes*/) override {}
  } never;
  const auto patches = box_patches();
  const SurfaceSamples samples{.patches = patches, .cell = 1, .area = 2800};
  std::vector<std::byte> block(1U << 16U);
  Arena arena(block);
  EXPECT_EQ(propose_orientations({}, samples, {}, {}, arena, {&never}).error().code(), ErrorCode::kCancelled);
}

}  // namespace
}  // namespace plumbline::firmware
