/// The words of the bar, and how much of the whole of slicing it shows.

#include "firmware/io/progress_lines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "firmware/io/whole_progress.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;

const std::vector<Stage> kScan = {Stage::kRead,       Stage::kTrees,       Stage::kNormals, Stage::kViews,
                                  Stage::kClustering, Stage::kWindingTree, Stage::kRayGrid, Stage::kRays,
                                  Stage::kRRep,       Stage::kSupports,    Stage::kLayers};
const std::vector<Stage> kMesh = {Stage::kRead, Stage::kRayGrid, Stage::kRays, Stage::kRRep, Stage::kLayers};
/// No surface was found at first.
const std::vector<Stage> kAveraged = {Stage::kRead,       Stage::kTrees,       Stage::kNormals, Stage::kViews,
                                      Stage::kClustering, Stage::kTrees,       Stage::kNormals, Stage::kViews,
                                      Stage::kClustering, Stage::kWindingTree, Stage::kRayGrid, Stage::kRays,
                                      Stage::kRRep,       Stage::kLayers};

/// The whole at the beginning, in the middle and at the end of each stage.
std::vector<double> reached(WholeProgress whole, const std::vector<Stage>& stages) {
  std::vector<double> all;
  for (const Stage stage : stages) {
    for (const double fraction : {0.0, 0.5, 1.0}) all.push_back(whole.reach(stage, fraction));
  }
  return all;
}

TEST(WholeProgress, NeverFallsAndEndsAtOneWhateverStagesRun) {
  for (const auto& stages : {kScan, kMesh, kAveraged}) {
    for (const bool writes : {false, true}) {
      const auto whole = reached(WholeProgress(Stage::kLayers, writes), stages);
      EXPECT_EQ(whole.front(), 0);
      EXPECT_TRUE(std::ranges::is_sorted(whole));
      EXPECT_EQ(whole.back(), 1);
      EXPECT_LT(*(whole.end() - 2), 1);
    }
  }
  EXPECT_EQ(reached(WholeProgress(Stage::kNormals), {Stage::kRead, Stage::kTrees, Stage::kNormals}).back(), 1);
  EXPECT_EQ(
      reached(WholeProgress(Stage::kSupports), {Stage::kRead, Stage::kTrees, Stage::kNormals, Stage::kSupports}).back(),
      1);
}

TEST(WholeProgress, GivesStagesTheSharesThatTheyTake) {
  const auto printed = reached(WholeProgress(), kScan), written = reached(WholeProgress(Stage::kLayers, true), kScan);
  const std::size_t rays = 3 * 7, layers = 3 * 10;
  EXPECT_NEAR(printed[rays + 2] - printed[rays], 0.45, 0.02);
  EXPECT_NEAR(1 - printed[layers], 0.13, 0.01);
  EXPECT_NEAR(1 - written[layers], 0.46, 0.02);
}

TEST(WholeProgress, StandsStillWhereAFractionFalls) {
  WholeProgress whole;
  whole.reach(Stage::kRead, 1);
  const double before = whole.reach(Stage::kRays, 0.6);
  EXPECT_EQ(whole.reach(Stage::kRays, 0.4), before);
  EXPECT_GT(whole.reach(Stage::kRays, 0.7), before);
}

TEST(ProgressText, TellsTheTimeLeftOnceItIsNoGuess) {
  EXPECT_EQ(progress_text("slicing", 0.5, 12).view(),
            "  slicing              ############............  50 %   12.0 s, 12 s left");
  EXPECT_EQ(progress_text("slicing", 0.1, 60).view(),
            "  slicing              ##......................  10 %   60.0 s, 9 min 00 s left");
  EXPECT_EQ(progress_text("slicing", 1, 12).view(),
            "  slicing              ######################## 100 %   12.0 s, 0 s left");
  EXPECT_EQ(progress_text("slicing", 0.5, 0.9).view(),
            "  slicing              ############............  50 %    0.9 s");
  EXPECT_EQ(progress_text("slicing", 0.04, 9).view(), "  slicing              ........................   4 %    9.0 s");
}

TEST(DurationText, GivesTimesInTheUnitsThatMatter) {
  EXPECT_EQ(duration_text(0s).view(), "0 s");
  EXPECT_EQ(duration_text(59s).view(), "59 s");
  EXPECT_EQ(duration_text(200s).view(), "3 min 20 s");
  EXPECT_EQ(duration_text(45min + 59s).view(), "45 min");
  EXPECT_EQ(duration_text(125min).view(), "2 h 05 min");
}

}  // namespace
}  // namespace plumbline::firmware
