/// Sessions and reports without a print.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/print/print_summary.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline {
namespace {

using ::testing::HasSubstr;

/// Cancels after `layer` calls in the last stage.
class CancelsAtLayer final : public ProgressSink {
 public:
  explicit CancelsAtLayer(int layer) : left_(layer) {}
  void begin(Stage /*stage*/) override {}
  bool advance(Stage stage, double /*fraction*/) override { return stage != Stage::kLayers || left_-- > 0; }
  void end(Stage /*stage*/, std::size_t /*peak_bytes*/) override {}

 private:
  int left_;
};

TEST(Session, CancelledWhileCountingResinStoresNothing) {
  const TemporaryFolder folder;
  const std::string scan = folder / "ball.ply";
  write_sphere_scan(scan, 4000, 2);
  auto store = JobStore::open(folder / "state");
  ASSERT_TRUE(store);
  std::vector<std::byte> block(std::size_t{24} << 20U);
  Arena arena{std::span(block)};
  const BoardFile board = session_board();
  const MachineFile machine = rig_machine();
  const auto profile = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml");
  ASSERT_TRUE(profile);
  {
    PrintSession session(board, machine, arena, &*store);
    auto source = FileSource::open(scan);
    ASSERT_TRUE(source);
    CancelsAtLayer progress(3);
    // A short span forces supports. Without supports slicing would already have counted the pixels.
    SupportSettings supports;
    supports.overhang_span = 0.4;
    const auto sliced = session.slice_scan(*source, slicing_for(board), supports, *profile, &progress);
    ASSERT_FALSE(sliced);
    EXPECT_EQ(sliced.error().code(), ErrorCode::kCancelled);
    EXPECT_THAT(sliced.error().message(), HasSubstr("at layer 3 of"));
  }
  EXPECT_FALSE(store->has_job());
  EXPECT_EQ(arena.used(), 0U);
}

/// @returns the report of a print that has not started
std::string report_with(const std::optional<StepFigures>& steps) {
  const TemporaryFolder folder;
  std::vector<std::byte> block(std::size_t{24} << 20U);
  Arena arena{std::span(block)};
  const BoardFile board = session_board();
  const MachineFile machine = rig_machine();
  const PrintSession session(board, machine, arena, nullptr);
  const auto profile = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml").value();
  const std::string path = folder / "report.json";
  auto file = OutputFile::create(path.c_str());
  JsonWriter json(*file);
  const auto part = steps ? std::nullopt : std::optional(PartFigures());
  write_print_report(json, {PrintReport(), session, profile, {}, steps, part});
  EXPECT_TRUE(json.finish() && file->close());
  return read_text(path);
}

TEST(Report, HasTheStepsOfARealStageAndNoneOfASimulatedOne) {
  const std::string text = report_with(StepFigures{.steps = 123'456,
                                                   .late = 7,
                                                   .worst_lateness = std::chrono::microseconds(1250),
                                                   .standstills = 1,
                                                   .real_time = true,
                                                   .memory_locked = false});
  for (const char* words : {"\"steps\": 123456", "\"late_steps\": 7", "\"worst_lateness_ms\": 1.25",
                            "\"standstills\": 1", "\"real_time_priority\": true", "\"locked_memory\": false"}) {
    EXPECT_THAT(text, HasSubstr(words));
  }
  EXPECT_THAT(report_with(std::nullopt), HasSubstr("\"stage\": null"));
}

}  // namespace
}  // namespace plumbline
