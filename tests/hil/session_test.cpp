/// Sessions and reports without a print.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/print/print_summary.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
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
    const auto sliced = slice_into(session, *source, slicing_for(board), supports, *profile, machine, arena, &progress);
    ASSERT_FALSE(sliced);
    EXPECT_EQ(sliced.error().code(), ErrorCode::kCancelled);
    EXPECT_THAT(sliced.error().message(), HasSubstr("at layer 3 of"));
  }
  EXPECT_FALSE(store->has_job());
  EXPECT_EQ(arena.used(), 0U);
}

/// Prints that were stored and are loaded again.
class StoredSession : public testing::Test {
 protected:
  StoredSession() { write_sphere_scan(folder_ / "ball.ply", 4000, 2); }

  void store(const std::string& state) {
    auto store = JobStore::open(folder_ / state);
    ASSERT_TRUE(store) << store.error().message();
    std::vector<std::byte> block(kBytes);
    Arena arena{std::span(block)};
    PrintSession session(board_, *board_.machine, arena, &*store);
    auto source = FileSource::open(folder_ / "ball.ply");
    ASSERT_TRUE(source);
    const auto profile = read_print_profile(PLUMBLINE_SOURCE_DIR "/board/profiles/standard.toml").value();
    const auto sliced =
        slice_into(session, *source, slicing_for(board_), std::nullopt, profile, *board_.machine, arena);
    ASSERT_TRUE(sliced) << sliced.error().message();
  }
  Status load(const std::string& state, const BoardFile& board) {
    auto store = JobStore::open(folder_ / state);
    PLUMBLINE_TRY(store);
    std::vector<std::byte> block(kBytes);
    Arena arena{std::span(block)};
    PrintSession session(board, *board.machine, arena, &*store);
    return session.load();
  }

  static constexpr std::size_t kBytes = std::size_t{24} << 20U;
  TemporaryFolder folder_;
  BoardFile board_ = session_board();
};

TEST_F(StoredSession, IsNotResumedWithTheJournalOfAnotherPrintOfTheSameScan) {
  store("one");
  store("other");
  EXPECT_TRUE(load("one", board_));
  std::filesystem::copy_file(folder_ / "other/journal", folder_ / "one/journal",
                             std::filesystem::copy_options::overwrite_existing);
  const auto loaded = load("one", board_);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code(), ErrorCode::kMalformed);
  EXPECT_THAT(loaded.error().message(), HasSubstr("are of different prints"));
}

TEST_F(StoredSession, IsNotResumedOnABoardWhoseMasksHeightsOrLightAreOthers) {
  store("state");
  const std::function<void(BoardFile&)> changes[] = {
      [](BoardFile& board) { board.name = "other"; },
      [](BoardFile& board) { board.columns += 64; },
      [](BoardFile& board) { board.pixel_pitch_y_mm *= 1.01; },
      [](BoardFile& board) { board.machine->rotation_distance_mm *= 2; },
      [](BoardFile& board) { board.machine->microsteps *= 2; },
      [](BoardFile& board) { board.machine->end_stop_height_mm += 1; },
      [](BoardFile& board) { board.machine->power_mw_cm2 += 0.1; },
      [](BoardFile& board) { board.machine->panel.rotation_deg = 180; },
  };
  for (const auto& change : changes) {
    SCOPED_TRACE(&change - changes);
    BoardFile other = board_;
    change(other);
    const auto loaded = load("state", other);
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().code(), ErrorCode::kUnsupported);
    EXPECT_THAT(loaded.error().message(), HasSubstr("was made for printer sim2k"));
  }
  EXPECT_TRUE(load("state", board_)) << "and it is still there";
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
}  // namespace plumbline::firmware
