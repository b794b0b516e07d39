/// Every block that a small job asks of the arena is refused once.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slicer/inspect.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/support_finder.hpp"
#include "tests/slicer/support/meshes.hpp"
#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/surface_files.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::ContainsRegex;

constexpr std::size_t kArena = 16 * kMiB;

/// Two balls on a plate with an open underside. A third of the points has no normal, and of one ball half face inwards.
Surface small_scan() {
  Random random(17);
  Surface surface = sphere(500, 3, {0, 0, 6});
  append(surface, sphere(300, 2, {7, 0, 6}));
  append(surface, sheet({-4, -4, 2}, {14, 0, 0}, {0, 8, 0}, 0.6, 0.3, random));
  add_noise(surface, 0.02, 0.05, random);
  for (std::size_t i = 0; i < surface.size(); i += 3) surface[i].normal.setZero();
  for (std::size_t i = 500; i < 800; i += 2) surface[i].normal *= -1;
  return surface;
}

/// Remembers which stage asked for which block.
class StageOfBlock final : public ProgressSink {
 public:
  explicit StageOfBlock(const Arena& arena) : arena_(arena) {}
  void begin(Stage stage) override { starts_.push_back({arena_.requests(), stage}); }
  bool advance(Stage /*stage*/, double /*fraction*/) override { return true; }
  void end(Stage /*stage*/, std::size_t /*peak*/) override {}
  std::optional<Stage> of(std::uint64_t block) const {
    std::optional<Stage> stage;
    for (const Start& start : starts_) {
      if (start.requests <= block) stage = start.stage;
    }
    return stage;
  }

 private:
  struct Start {
    std::uint64_t requests;
    Stage stage;
  };
  const Arena& arena_;
  std::vector<Start> starts_;
};

/// Calls job(arena, progress) with arenas that refuse block 0, 1, 2, ..., until all blocks have been refused once.
/// @param may_go_on  stage that does without the block if it must
/// @returns errors
template <class Job>
std::uint32_t refuse_each_block(Job job, std::optional<Stage> may_go_on = std::nullopt) {
  std::uint32_t errors = 0;
  for (std::uint64_t refused = 0;; ++refused) {
    ArenaBlock arena(kArena, refused);
    StageOfBlock stages(*arena);
    const Status status = job(*arena, stages);
    if (arena->requests() <= refused) {
      EXPECT_TRUE(status.has_value()) << status.error().message();
      return errors;
    }
    SCOPED_TRACE("block " + std::to_string(refused));
    if (status) {
      EXPECT_EQ(stages.of(refused), may_go_on);
      continue;
    }
    ++errors;
    EXPECT_EQ(status.error().code(), ErrorCode::kOutOfMemory) << status.error().message();
    EXPECT_THAT(status.error().message(), ContainsRegex("[a-zA-Z]: .*MiB.*\\. Use a larger arena"));
    EXPECT_EQ(arena->used(), 0U) << status.error().message();
  }
}

SliceSettings coarse() {
  SliceSettings settings = settings_with_pitch(0.5F);
  settings.confidence = true;
  return settings;
}

TEST(RefusedMemory, IsAnErrorOfTheStageInASlice) {
  const std::string scan = binary_ply(small_scan());
  const std::uint32_t errors = refuse_each_block(
      [&](Arena& arena, ProgressSink& progress) -> Status {
        MemorySource source(scan, "test.ply");
        SliceReport report;
        PLUMBLINE_TRY(slice(source, coarse(), arena, &progress, report));
        return {};
      },
      Stage::kRRep);
  EXPECT_GT(errors, 50U);
}

TEST(RefusedMemory, IsAnErrorOfTheStageForAMesh) {
  TestMesh mesh = ball_mesh({0, 0, 5}, 5, 3);
  mesh.faces.resize(mesh.faces.size() - 9);  // with a hole, so that its winding number is needed
  for (const auto& file : {SurfaceFile{"mesh.stl", binary_stl(mesh)}, SurfaceFile{"mesh.ply", ascii_ply(mesh)}}) {
    const std::uint32_t errors = refuse_each_block(
        [&](Arena& arena, ProgressSink& progress) -> Status {
          MemorySource source(file.bytes, file.name);
          source.be_a_pipe();
          SliceReport report;
          SliceSettings settings = coarse();
          settings.as = ReadAs::kMesh;
          settings.orient = true;
          settings.absolute_correction_mm = std::string_view(file.name) == "mesh.ply" ? -0.05 : 0;
          PLUMBLINE_TRY(slice(source, settings, arena, &progress, report));
          EXPECT_TRUE(report.mesh && !report.mesh->closed);
          return {};
        },
        Stage::kRRep);
    EXPECT_GT(errors, 25U);
  }
}

TEST(RefusedMemory, IsAnErrorWhileSeveralFilesAreRead) {
  const auto files = files_of(small_scan());
  refuse_each_block(
      [&](Arena& arena, ProgressSink& progress) -> Status {
        std::vector<MemorySource> sources;
        for (const SurfaceFile& file : files) sources.emplace_back(file.bytes, file.name);
        std::vector<ByteSource*> pointers;
        for (MemorySource& source : sources) pointers.push_back(&source);
        SliceReport report;
        PLUMBLINE_TRY(slice(pointers, coarse(), arena, &progress, report));
        return {};
      },
      Stage::kRRep);
}

TEST(RefusedMemory, IsNoErrorOfAnInspectionOnceTheScanIsPrepared) {
  Random random(18);
  const std::string scan = binary_ply(box({0, 0, 0}, {24, 3, 3}, 0.4, 0.3, random));  // long: few rays are shot
  std::uint32_t not_sliced = 0;
  refuse_each_block(
      [&](Arena& arena, ProgressSink& progress) -> Status {
        MemorySource source(scan, "test.ply");
        ByteSource* const sources[] = {&source};
        InspectReport report;
        const Status status = inspect(sources, coarse(), arena, &progress, report);
        EXPECT_EQ(arena.used(), 0U);
        if (status) {
          not_sliced += report.sliced ? 0 : 1;
          return report.sliced;
        }
        return status;
      },
      Stage::kRRep);
  EXPECT_GT(not_sliced, 10U);
}

TEST(RefusedMemory, IsAnErrorWhileSupportsAreFoundAndMasksAreMade) {
  const std::string scan = binary_ply(small_scan());
  const Slicing slicing(scan, coarse(), kArena);
  const std::uint32_t errors = refuse_each_block([&](Arena& arena, ProgressSink& progress) -> Status {
    const std::size_t bottom = arena.bottom_mark();
    SupportCounts counts;
    RRep rrep = slicing.rrep();
    const auto supports = find_supports(rrep, SupportSettings{}, PrintGrid::kMaxLayers, arena, &progress, counts);
    PLUMBLINE_TRY(supports);
    const auto masks = MaskStream::create(rrep, *supports, arena);
    arena.release_bottom(bottom);
    PLUMBLINE_TRY(masks);
    return {};
  });
  EXPECT_GT(errors, 8U);
}

}  // namespace
}  // namespace plumbline
