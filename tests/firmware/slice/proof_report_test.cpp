#include "firmware/slice/proof_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::firmware {
namespace {

using namespace testing;

TEST(ProofReport, AboveTwoThirdsAPrintIsRefused) {
  MemorySource scan("", "twice.ply");
  ByteSource* const sources[] = {&scan};
  EXPECT_TRUE(check_proof({.points = 100, .off = 66, .reach_mm = 1}, sources));
  EXPECT_TRUE(check_proof({}, sources)) << "a mesh has no points";
  const Status refused = check_proof({.points = 100, .off = 67, .reach_mm = 1}, sources);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kNoSurface);
  EXPECT_EQ(refused.error().told().code, ToldCode::kPointsOff);
  EXPECT_THAT(refused.error().message(),
              HasSubstr("twice.ply: 67 % of the points lie more than 1 mm off what is printed. Look at"));
}

TEST(ProofReport, SaysHowManyPointsLieWhere) {
  const PointProof proof{.points = 1000, .within_pixel = 928, .within_layer = 940, .off = 14, .reach_mm = 0.2F};
  EXPECT_EQ(proven_text(proof).view(),
            "98.6 % of the points lie within 0.2 mm of what is printed, 92.8 % within a pixel");
}

}  // namespace
}  // namespace plumbline::firmware
