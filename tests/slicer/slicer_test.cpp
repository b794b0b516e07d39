#include "slicer/slicer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "slicer/plan/memory_plan.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

/// Counts how often it is read.
class CountingSource final : public ByteSource {
 public:
  explicit CountingSource(std::string bytes) : bytes_(std::move(bytes)), source_(bytes_, "counted.ply") {}
  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    ++reads_;
    return source_.read(buffer);
  }
  std::string_view name() const override { return source_.name(); }
  std::optional<std::uint64_t> size() const override { return source_.size(); }
  std::uint32_t reads() const { return reads_; }

 private:
  std::string bytes_;
  MemorySource source_;
  std::uint32_t reads_ = 0;
};

TEST(Slice, RefusesAJobThatCannotFitBeforeItReadsTheScan) {
  SliceSettings settings;
  settings.placement.printer = PrinterVolume{1440, 2560, 0.05F, 0.05F, 150};
  CountingSource source(binary_ply(sphere(2000, 10, {0, 0, 0})));
  ArenaBlock arena(3 * kMiB);
  SliceReport report;
  const auto rrep = slice(source, settings, *arena, nullptr, report);
  ASSERT_FALSE(rrep.has_value());
  EXPECT_EQ(rrep.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_EQ(source.reads(), 1U);  // its head, which shows that it is no mesh
  EXPECT_EQ(arena->used(), 0U);
}

/// A PLY with the given points, whose header declares `declared` points.
std::string promising(const Surface& surface, const std::string& declared) {
  std::string scan = binary_ply(surface);
  const std::string count = std::to_string(surface.size());
  return scan.replace(scan.find(count), count.size(), declared);
}

TEST(Slice, TakesNoMoreRoomThanTheHeaderPromises) {
  const Slicing sliced(binary_ply(sphere(2000, 10, {0, 0, 0})), settings_with_pitch(0.2F), 200 * kMiB);
  EXPECT_GT(sliced.report().cloud_capacity, 1'000'000U) << "the arena's room";
  EXPECT_LT(sliced.report().peak_bytes[static_cast<std::size_t>(Stage::kRead)], kMiB);
}

TEST(Slice, TakesNoRoomForPointsThatTheFileIsTooShortFor) {
  ArenaBlock arena(200 * kMiB);
  const std::string scan = promising(sphere(2000, 10, {0, 0, 0}), "4000000000");
  MemorySource source(scan, "promise.ply");
  SliceReport report;
  const auto rrep = slice(source, settings_with_pitch(0.2F), *arena, nullptr, report);
  ASSERT_FALSE(rrep.has_value());
  EXPECT_EQ(rrep.error().code(), ErrorCode::kTruncated);
  EXPECT_LT(report.peak_bytes[static_cast<std::size_t>(Stage::kRead)], 2 * kMiB);
  EXPECT_EQ(arena->used(), 0U);
}

/// Records which stages ran, and cancels one if asked to.
class Listener final : public ProgressSink {
 public:
  explicit Listener(std::optional<Stage> cancel = std::nullopt) : cancel_(cancel) {}
  void begin(Stage stage) override {
    EXPECT_FALSE(running_.has_value());
    running_ = last_ = stage;
    fraction_ = 0;
  }
  bool advance(Stage stage, double fraction) override {
    EXPECT_EQ(running_, stage);
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    EXPECT_GE(fraction, fraction_) << to_string(stage);
    fraction_ = fraction;
    ++advances_[static_cast<std::size_t>(stage)];
    return cancel_ != stage;
  }
  void end(Stage stage, std::size_t peak) override {
    EXPECT_EQ(running_, stage);
    EXPECT_GT(peak, 0U);
    running_.reset();
  }
  std::optional<Stage> last() const { return last_; }
  int advances(Stage stage) const { return advances_[static_cast<std::size_t>(stage)]; }

 private:
  std::optional<Stage> cancel_;
  std::optional<Stage> running_;
  std::optional<Stage> last_;
  double fraction_ = 0;
  std::array<int, kStageCount> advances_{};
};

// Without a printer the grid is known only once the object has been placed. The arena may turn out too small at that stage,
// but never while rays are shot.
TEST(Slice, LeavesTheArenaAsItWasWhereverItRunsOut) {
  // A rod across a large grid: its masks take more memory than its points.
  Random random(2);
  const std::string scan = binary_ply(box({0, 0, 0}, {100, 1.5, 1.5}, 0.4, 0.3, random));
  SliceSettings settings = settings_with_pitch(0.03F);
  settings.placement.rotation_degrees[2] = 45;
  int thinned_away = 0;
  int crossings_refused = 0;
  int sliced = 0;
  for (const std::size_t kib : {600U, 1000U, 1400U, 1800U, 2000U, 2200U, 2400U, 2600U, 2800U, 3000U, 3500U, 4000U,
                                5000U, 8000U, 16000U, 32000U}) {
    ArenaBlock arena(kib * 1024);
    ASSERT_TRUE(arena->take_bottom<std::byte>(1000, "of the caller").has_value());
    ASSERT_TRUE(arena->take_top<std::byte>(500, "of the caller").has_value());
    const std::size_t bottom = arena->bottom_mark();
    const std::size_t top = arena->top_mark();
    MemorySource source(scan, "test.ply");
    SliceReport report;
    Listener listener;
    const auto rrep = slice(source, settings, *arena, &listener, report);
    EXPECT_EQ(arena->top_mark(), top) << kib;
    if (rrep) {
      ++sliced;
      EXPECT_GT(arena->bottom_mark(), bottom);
      continue;
    }
    EXPECT_EQ(arena->bottom_mark(), bottom) << kib;
    EXPECT_NE(listener.last(), Stage::kRays) << kib;
    if (rrep.error().code() == ErrorCode::kNoSurface) {
      EXPECT_THAT(rrep.error().message(), HasSubstr("were thinned because"));
      ++thinned_away;
      continue;
    }
    EXPECT_EQ(rrep.error().code(), ErrorCode::kOutOfMemory);
    crossings_refused +=
        std::string_view(rrep.error().message()).find("crossings need") != std::string_view::npos ? 1 : 0;
  }
  EXPECT_LE(thinned_away, 2);
  EXPECT_GT(sliced, 0);
  EXPECT_GT(crossings_refused, 0);
}

// Each of these stages takes up to some seconds on a million points.
TEST(Slice, ReportsProgressInEveryLongStage) {
  Surface surface = sphere(100'000, 10, {0, 0, 0});
  for (SurfacePoint& p : surface) p.normal.setZero();
  const std::string scan = binary_ply(surface);
  ArenaBlock arena(64 * kMiB);
  MemorySource source(scan, "test.ply");
  SliceReport report;
  Listener listener;
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.threads = 1;  // the first thread reports; of two, a busy machine may leave it a small share
  ASSERT_TRUE(slice(source, settings, *arena, &listener, report).has_value());
  for (const Stage stage : {Stage::kRead, Stage::kTrees, Stage::kNormals, Stage::kClustering, Stage::kRayGrid}) {
    EXPECT_GE(listener.advances(stage), 20) << to_string(stage);
  }
}

TEST(Slice, LeavesTheArenaAsItWasWhenItIsCancelled) {
  Surface surface = sphere(30000, 10, {0, 0, 0});
  for (std::size_t i = 0; i < surface.size(); i += 2) surface[i].normal.setZero();
  const std::string scan = binary_ply(surface);
  for (const Stage stage :
       {Stage::kRead, Stage::kTrees, Stage::kNormals, Stage::kClustering, Stage::kRayGrid, Stage::kRays}) {
    ArenaBlock arena(64 * kMiB);
    MemorySource source(scan, "test.ply");
    SliceReport report;
    Listener listener(stage);
    const auto rrep = slice(source, settings_with_pitch(0.1F), *arena, &listener, report);
    ASSERT_FALSE(rrep.has_value()) << to_string(stage);
    EXPECT_EQ(rrep.error().code(), ErrorCode::kCancelled);
    EXPECT_EQ(listener.last(), stage);
    EXPECT_EQ(arena->used(), 0U);
  }
}

TEST(Slice, RefusesAnObjectTooLargeForTheArenaBeforeItsRays) {
  // The plan is for half of the panel with three crossings a ray. Twelve storeys that fill the panel have far more.
  Random random(3);
  Surface surface;
  for (int k = 0; k < 12; ++k) append(surface, box({0, 0, 1.0 * k}, {29, 29, 1.0 * k + 0.5}, 0.25, 0.3, random));
  SliceSettings settings = settings_with_pitch(0.05F);
  settings.placement.printer = PrinterVolume{600, 600, 0.05F, 0.05F, 60};
  ArenaBlock arena(16 * kMiB);
  const std::string scan = binary_ply(surface);
  MemorySource source(scan, "storeys.ply");
  SliceReport report;
  Listener listener;
  const auto rrep = slice(source, settings, *arena, &listener, report);
  ASSERT_FALSE(rrep.has_value());
  EXPECT_EQ(rrep.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(rrep.error().message(), HasSubstr("the arena has 16.0 MiB"));
  EXPECT_EQ(listener.last(), Stage::kRayGrid);
  EXPECT_EQ(arena->used(), 0U);
}

TEST(Slice, RefusesBeforeItsRaysAnObjectWhoseMasksCouldNotBeChecked) {
  // More than the half of a panel that the first plan is for, but not so much that sorting the crossings needs more.
  Random random(3);
  Surface surface;
  for (int k = 0; k < 2; ++k) append(surface, box({0, 0, 1.0 * k}, {29.7, 29.7, 1.0 * k + 0.5}, 0.25, 0.3, random));
  const std::string scan = binary_ply(surface);
  SliceSettings settings = settings_with_pitch(0.05F);
  settings.placement.printer = PrinterVolume{600, 600, 0.05F, 0.05F, 60};
  const Slicing ample(scan, settings, 64 * kMiB);
  // The R-Rep would fit, even beside the store that it is sorted from.
  const auto crossings = static_cast<double>(ample.rrep().crossings());
  const RayYield yield{0, 0.87 * crossings};
  const std::size_t checking = layers_stage_bytes(ample.grid(), 0, Grey::kOff);
  ASSERT_GT(checking, store_bytes(ample.grid(), {600 * 600, 1.1 * crossings}));
  ArenaBlock arena(kept_bytes(ample.report().cloud_points, 0, false) + rrep_bytes(ample.grid(), yield) + checking);
  MemorySource source(scan, "storeys.ply");
  SliceReport report;
  Listener listener;
  const auto rrep = slice(source, settings, *arena, &listener, report);
  ASSERT_FALSE(rrep.has_value());
  EXPECT_THAT(rrep.error().message(), HasSubstr("layers: the object's"));
  EXPECT_EQ(listener.last(), Stage::kRayGrid);
  EXPECT_EQ(arena->used(), 0U);
}

TEST(Slice, LeavesOnlyTheRRepAndItsProofInTheArena) {
  Slicing sliced(binary_ply(sphere(30000, 10, {0, 0, 0})), settings_with_pitch(0.1F), 64 * kMiB);
  const RRep& rrep = sliced.rrep();
  EXPECT_EQ(sliced.arena().top_used(), 0U);
  EXPECT_EQ(sliced.arena().bottom_used(), proof_bytes(sliced.report().cloud_points) +
                                              Arena::rounded(rrep.first.size_bytes()) +
                                              Arena::rounded(rrep.packed.size_bytes()));
}

TEST(Slice, SaysWhenPointsHaveNoSurface) {
  const Surface dust(200, {Vec3d(1, 2, 3), Vec3d(0, 0, 1)});  // all in one place
  ArenaBlock arena(16 * kMiB);
  const std::string scan = binary_ply(dust);
  MemorySource source(scan, "dust.ply");
  SliceReport report;
  const auto rrep = slice(source, settings_with_pitch(0.1F), *arena, nullptr, report);
  ASSERT_FALSE(rrep.has_value());
  EXPECT_EQ(rrep.error().code(), ErrorCode::kNoSurface);
  EXPECT_THAT(rrep.error().message(), HasSubstr("dust.ply"));
  EXPECT_EQ(arena->used(), 0U);
}

/// The error of a scan that is refused.
Error refusal(const Surface& surface, const SliceSettings& settings, Listener* listener = nullptr,
              std::size_t arena_bytes = 32 * kMiB) {
  ArenaBlock arena(arena_bytes);
  const std::string scan = binary_ply(surface);
  MemorySource source(scan, "scan.ply");
  SliceReport report;
  const auto rrep = slice(source, settings, *arena, listener, report);
  if (rrep) {
    ADD_FAILURE() << "was sliced";
    return Error::format(ErrorCode::kMalformed, "it was sliced");
  }
  EXPECT_EQ(arena->used(), 0U);
  return rrep.error();
}

SliceSettings on_a_printer_of_60_mm() {
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.placement.printer = PrinterVolume{600, 600, 0.1F, 0.1F, 60};
  return settings;
}

// It took a minute to say that a scan of a million points is too wide.
TEST(Slice, RefusesAnObjectTooLargeForThePrinterAsSoonAsItIsRead) {
  Listener listener;
  const Error large = refusal(sphere(20'000, 50, {7, 0, 0}), on_a_printer_of_60_mm(), &listener);
  EXPECT_EQ(large.code(), ErrorCode::kDoesNotFit);
  EXPECT_EQ(listener.last(), Stage::kRead);
  EXPECT_THAT(large.message(), HasSubstr("the object is 100.00 mm"));
  EXPECT_THAT(large.message(), HasSubstr("Use a scale of 0.5898 or less"));
}

TEST(Slice, MeasuresATooLargeObjectWithoutThePointsThatFlyFarAway) {
  Surface surface = sphere(20'000, 50, {7, 0, 0});
  for (int i = 0; i < 50; ++i) surface.push_back({Vec3d(0, 0, 5000.0 + i), Vec3d(0, 0, 1)});
  EXPECT_THAT(refusal(surface, on_a_printer_of_60_mm()).message(), HasSubstr("the object is 100.00 mm wide"));
}

TEST(Slice, DoesNotRefuseAnObjectForItsStrayPiece) {
  Surface surface = sphere(20'000, 20, {0, 0, 0});
  for (const auto& point : sphere(400, 1, {90, 0, 0})) surface.push_back(point);
  const Slicing sliced(binary_ply(surface), on_a_printer_of_60_mm(), 64 * kMiB);
  EXPECT_GT(sliced.report().strays.points, 0U);
}

TEST(Slice, RefusesMetresThatBecomeASpeckAndSaysWhichUnitToUse) {
  const Error speck = refusal(sphere(20'000, 0.1, {0, 0, 0}), settings_with_pitch(0.05F));
  EXPECT_EQ(speck.code(), ErrorCode::kNoSurface);
  EXPECT_THAT(speck.message(), HasSubstr("scan.ply: the object would be 0.2 mm long, less than 8 pixels"));
  EXPECT_THAT(std::string(speck.advice()), HasSubstr("Check its unit"));
  // Thinned to so few cells that no point of a surface is left.
  EXPECT_THAT(refusal(sphere(20'000, 0.02, {0, 0, 0}), settings_with_pitch(0.05F)).message(),
              HasSubstr("the object would be 0.038 mm long"));
  SliceSettings metres = settings_with_pitch(1);
  metres.placement.units = Units::kMetres;
  EXPECT_GT(Slicing(binary_ply(sphere(20'000, 0.1, {0, 0, 0})), metres, 64 * kMiB).grid().layers, 150U);
}

// A small scan of many points was told to take a larger arena, which would not have changed anything.
TEST(Slice, NamesTheArenaOnlyWhereItWasTooSmall) {
  Surface dense;
  Random random(5);
  for (int i = 0; i < 300'000; ++i) {
    const Vec3d normal = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
    dense.push_back({Vec3d(random.uniform(0, 2), random.uniform(0, 2), random.uniform(0, 2)), normal});
  }
  const Error wrong_normals = refusal(dense, settings_with_pitch(0.2F), nullptr, 8 * kMiB);
  EXPECT_EQ(wrong_normals.code(), ErrorCode::kNoSurface);
  EXPECT_THAT(wrong_normals.message(), Not(HasSubstr("arena")));
}

TEST(Slice, RefusesAPlaneThatBecomesNothing) {
  Surface plane;
  for (int x = 0; x < 100; ++x) {
    for (int y = 0; y < 100; ++y) plane.push_back({Vec3d(0.3 * x, 0.3 * y, 0), Vec3d(0, 0, 1)});
  }
  const Error flat = refusal(plane, settings_with_pitch(0.05F));
  EXPECT_EQ(flat.code(), ErrorCode::kNoSurface);
  EXPECT_THAT(flat.message(), HasSubstr("no layer has a pixel"));
}

}  // namespace
}  // namespace plumbline
