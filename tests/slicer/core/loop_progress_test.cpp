#include "slicer/core/loop_progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace plumbline {
namespace {

class Recorder final : public ProgressSink {
 public:
  void begin(Stage /*stage*/) override {}
  bool advance(Stage /*stage*/, double fraction) override {
    reports.push_back(fraction);
    return reports.size() < limit;
  }
  void end(Stage /*stage*/, std::size_t /*peak_bytes*/) override {}

  std::vector<double> reports;
  std::size_t limit = 100;  ///< advances before it cancels
};

// Some OpenMP runtimes let an idle thread take steps that come before its last one.
TEST(LoopProgress, NeverGoesBackWhenStepsRunOutOfOrder) {
  Recorder recorder;
  LoopProgress progress({&recorder, Stage::kClustering, 0.5, 1}, 256);
  for (const std::uint32_t step : {128U, 192U, 193U, 0U, 64U}) EXPECT_TRUE(progress.step(step));
  EXPECT_THAT(recorder.reports, ::testing::ElementsAre(0.5, 0.625, 0.75, 0.875));
}

TEST(LoopProgress, SkipsAllStepsAfterACancel) {
  Recorder recorder;
  recorder.limit = 2;
  LoopProgress progress({&recorder, Stage::kClustering}, 256);
  EXPECT_TRUE(progress.step(0));
  EXPECT_FALSE(progress.step(64));
  EXPECT_FALSE(progress.step(65));
  EXPECT_TRUE(progress.stopped());
}

}  // namespace
}  // namespace plumbline
