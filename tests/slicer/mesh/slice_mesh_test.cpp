/// Meshes through slice(), from their bytes to the sections.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "slicer/inspect.hpp"
#include "tests/slicer/mesh/sliced_mesh.hpp"
#include "tests/slicer/support/shared_scan.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

bool same_rrep(const RRep& a, const RRep& b) {
  return a.grid.layers == b.grid.layers && a.grid.columns == b.grid.columns &&
         std::equal(a.first.begin(), a.first.end(), b.first.begin(), b.first.end()) &&
         std::equal(a.packed.begin(), a.packed.end(), b.packed.begin(), b.packed.end());
}

/// Whether they are the same but for parts of heights: the formats round coordinates to float, double or text.
bool same_but_for_rounding(const RRep& a, const RRep& b) {
  const CrossingPacking packing(a.grid);
  const auto alike = [&](std::uint32_t p, std::uint32_t q) {
    return packing.pixel(p) == packing.pixel(q) && std::max(p, q) - std::min(p, q) <= 1;
  };
  return std::ranges::equal(a.first, b.first) && std::ranges::equal(a.packed, b.packed, alike);
}

TEST(SliceMesh, ACubeWithCornersOnPixelCentresHasEveryPixelOnce) {
  // Pixels and layers of 0.5 mm, sampled at 0.25, 0.75, ...: the faces of the cube lie on sampling places on all sides.
  const Slicing cube = sliced(box_mesh({0.25, 0.25, 0.25}, {10.25, 10.25, 10.25}), settings_with_pitch(0.5F));
  ASSERT_TRUE(cube.report().mesh);
  EXPECT_TRUE(cube.report().mesh->closed);
  EXPECT_EQ(cube.report().mesh->broken_rays, 0U);
  // Half-open: of the 21 places along each axis 20 are inside.
  std::uint64_t voxels = 0;
  cube.for_each_section([&](std::uint32_t, ConstBitImage section) {
    EXPECT_EQ(section.count(), 400U);
    voxels += section.count();
  });
  EXPECT_EQ(voxels, 8000U);
  EXPECT_EQ(cube.report().object_pixels, 8000U);
  EXPECT_EQ(cube.rrep().crossings(), 400U);  // those where rays leave at the top are above the last layer
}

TEST(SliceMesh, PartsThatShareAFaceNeitherOverlapNorLeaveAGap) {
  TestMesh halves = box_mesh({0.25, 0.25, 0.25}, {5.25, 10.25, 10.25});
  append(halves, box_mesh({5.25, 0.25, 0.25}, {10.25, 10.25, 10.25}));
  const Slicing both = sliced(halves, settings_with_pitch(0.5F));
  const Slicing whole = sliced(box_mesh({0.25, 0.25, 0.25}, {10.25, 10.25, 10.25}), settings_with_pitch(0.5F));
  EXPECT_TRUE(same_rrep(both.rrep(), whole.rrep()));
}

TEST(SliceMesh, ATurnedBoxHasThePixelsThatAreInIt) {
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.placement.rotation_degrees = {33, 71, -12};
  const Slicing box = sliced(box_mesh({-3, -2, 0}, {4, 3, 5}), settings);
  EXPECT_GT(box.rrep().crossings(), 5000U);
  EXPECT_EQ(wrong(box, [](const Vec3d& p) { return in_box(p, {-3, -2, 0}, {4, 3, 5}); }), 0U);
  EXPECT_NEAR(box.volume(), 175, 0.5);
  std::uint64_t pixels = 0;
  box.for_each_section([&](std::uint32_t, ConstBitImage section) { pixels += section.count(); });
  EXPECT_EQ(box.report().object_pixels, pixels);
}

TEST(SliceMesh, ABallHasItsVolumeAndItsPixels) {
  const Slicing ball = sliced(ball_mesh({0, 0, 8}, 8, 5), settings_with_pitch(0.2F));
  // The flat triangles lie at most 8 (1 - cos(1.1 degrees)) inside the sphere.
  EXPECT_EQ(ball.wrong_voxels([](const Vec3d& p) { return (p - Vec3d(0, 0, 8)).norm() - 8; }, 0.006), 0U);
  EXPECT_NEAR(ball.volume(), 4.0 / 3 * std::numbers::pi * 512, 5);
}

TEST(SliceMesh, EveryFormatOrderAndNumberOfThreadsGivesTheSameCrossings) {
  TestMesh mesh = ball_mesh({1, 2, 6}, 5, 3);
  append(mesh, box_mesh({2, 2, 1}, {9, 9, 4}));
  SliceSettings settings = settings_with_pitch(0.15F);
  settings.placement.rotation_degrees = {10, 20, 30};
  const Slicing expected = sliced(mesh, settings);
  for (const SurfaceFile& file : files_of(mesh)) {
    const Slicing other(MemorySource(file.bytes, file.name), settings, kArena);
    EXPECT_TRUE(other.report().mesh) << file.name;
    EXPECT_TRUE(same_but_for_rounding(other.rrep(), expected.rrep())) << file.name;
  }
  for (std::uint32_t seed = 1; seed < 4; ++seed) {
    EXPECT_TRUE(same_rrep(sliced(shuffled(mesh, seed), settings).rrep(), expected.rrep()));
  }
  settings.threads = 3;
  EXPECT_TRUE(same_rrep(sliced(mesh, settings).rrep(), expected.rrep()));
}

TEST(SliceMesh, ShellsInsideOfEachOtherAndOverlappingOnesAreOneSolid) {
  TestMesh mesh = box_mesh({0, 0, 0}, {10, 10, 10});
  append(mesh, box_mesh({3, 3, 3}, {6, 6, 6}));    // inside, facing outwards
  append(mesh, box_mesh({8, 8, 2}, {14, 14, 8}));  // across the wall
  const Slicing joined = sliced(mesh, settings_with_pitch(0.25F));
  EXPECT_TRUE(joined.report().mesh->closed);
  EXPECT_EQ(wrong(joined,
                  [](const Vec3d& p) {
                    return std::max(in_box(p, {0, 0, 0}, {10, 10, 10}), in_box(p, {8, 8, 2}, {14, 14, 8}));
                  }),
            0U);
}

TEST(SliceMesh, AShellThatFacesInwardsIsAHollow) {
  TestMesh mesh = box_mesh({0, 0, 0}, {10, 10, 10});
  TestMesh hollow = box_mesh({3, 3, 3}, {6, 6, 6});
  flip(hollow, 0, 12);
  append(mesh, hollow);
  const Slicing pocket = sliced(mesh, settings_with_pitch(0.25F));
  EXPECT_EQ(wrong(pocket,
                  [](const Vec3d& p) {
                    const int inner = in_box(p, {3, 3, 3}, {6, 6, 6});
                    return inner > 0 ? -1 : inner == 0 ? 0 : in_box(p, {0, 0, 0}, {10, 10, 10});
                  }),
            0U);
}

TEST(SliceMesh, AMeshThatIsInsideOutIsSolid) {
  TestMesh mesh = box_mesh({0, 0, 0}, {10, 10, 10});
  const Slicing expected = sliced(mesh, settings_with_pitch(0.25F));
  flip(mesh, 0, 12);
  EXPECT_TRUE(same_rrep(sliced(mesh, settings_with_pitch(0.25F)).rrep(), expected.rrep()));
}

TEST(SliceMesh, AThinPartStaysAndTheMaskIsTheSection) {
  // A wall of one pixel, which opening would remove.
  TestMesh mesh = box_mesh({0, 0, 0}, {10, 0.2, 5});
  append(mesh, box_mesh({0, 0, 0}, {10, 10, 0.4}));
  Slicing slicing = sliced(mesh, settings_with_pitch(0.2F));
  EXPECT_TRUE(slicing.rrep().is_exact);
  LayerStream stream = value_of(LayerStream::create(slicing.rrep(), slicing.arena()));
  slicing.for_each_section([&](std::uint32_t k, ConstBitImage section) {
    const ConstBitImage mask = stream.mask(k);
    EXPECT_TRUE(std::equal(mask.words().begin(), mask.words().end(), section.words().begin())) << k;
  });
  EXPECT_EQ(stream.mask(slicing.grid().layers - 1).count(), 50U);
}

TEST(SliceMesh, SeveralFilesInOneFrameAreOneObject) {
  const std::string a = binary_stl(box_mesh({0, 0, 0}, {5, 5, 5}));
  const std::string b = obj_of(box_mesh({4, 0, 0}, {9, 5, 5}));
  MemorySource first(a, "a.stl");
  MemorySource second(b, "b.obj");
  ByteSource* const sources[] = {&first, &second};
  ArenaBlock arena(kArena);
  SliceReport report;
  SliceSettings settings = settings_with_pitch(0.25F);
  settings.as = ReadAs::kMesh;
  ASSERT_TRUE(slice(ScanSources(sources), settings, *arena, nullptr, report));
  EXPECT_EQ(report.mesh->triangles, 24U);
  EXPECT_NEAR(report.placement.size_mm[0], 9, 1e-6);
  EXPECT_EQ(report.scans.count, 2U);
}

TEST(SliceMesh, APipeIsKeptInTheArenaAndRefusedWithAdviceWhereItDoesNotFit) {
  const TestMesh mesh = ball_mesh({0, 0, 8}, 8, 4);
  const std::string bytes = binary_stl(mesh);
  const Slicing expected = sliced(mesh, settings_with_pitch(0.2F));
  for (const bool knows_size : {true, false}) {
    MemorySource pipe(bytes, "mesh.stl", {1000});
    pipe.be_a_pipe();
    if (!knows_size) pipe.forget_size();
    const Slicing slicing(static_cast<ByteSource&>(pipe), settings_with_pitch(0.2F), kArena);
    EXPECT_TRUE(same_rrep(slicing.rrep(), expected.rrep()));
    EXPECT_EQ(pipe.rewound, 0);
  }
  MemorySource pipe(bytes, "mesh.stl");
  pipe.be_a_pipe();
  pipe.forget_size();
  ArenaBlock small(600 * 1024);
  SliceReport report;
  const auto refused = slice(pipe, settings_with_pitch(0.2F), *small, nullptr, report);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_EQ(small->used(), 0U);
}

TEST(SliceMesh, WhatDoesNotFitIsRefusedBeforeItIsReadAgain) {
  const std::string bytes = binary_stl(box_mesh({0, 0, 0}, {60, 60, 60}));
  MemorySource source(bytes, "box.stl");
  ArenaBlock arena(6 * kMiB);
  SliceReport report;
  const auto refused = slice(source, settings_with_pitch(0.05F), *arena, nullptr, report);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(refused.error().message(), HasSubstr("arena of 6.0 MiB: stage '"));
  EXPECT_THAT(refused.error().message(), HasSubstr("2880000 crossings"));
  EXPECT_THAT(refused.error().message(), HasSubstr("a larger arena"));
  EXPECT_EQ(source.rewound, 3);  // to be rewound at all, after the look at its head, and before the survey
  EXPECT_EQ(arena->used(), 0U);
}

TEST(SliceMesh, ThePlanHoldsWhatEveryStageTakes) {
  TestMesh open = ball_mesh({0, 0, 20}, 20, 4);
  open.faces.resize(open.faces.size() - 40);
  for (const TestMesh& mesh : {ball_mesh({0, 0, 20}, 20, 6), box_mesh({0, 0, 0}, {40, 30, 20}), open}) {
    for (const SurfaceFile& file : files_of(mesh)) {
      const Slicing slicing(MemorySource(file.bytes, file.name), settings_with_pitch(0.2F), kArena);
      const SliceReport& report = slicing.report();
      for (const Stage stage : {Stage::kRead, Stage::kRayGrid, Stage::kRays, Stage::kRRep}) {
        const auto s = static_cast<std::size_t>(stage);
        EXPECT_LE(report.peak_bytes[s], report.planned_bytes[s]) << file.name << ' ' << to_string(stage);
      }
    }
  }
}

TEST(SliceMesh, A3mfIsReadOnceUnlessItsCopyLeavesTooLittleRoomForTheHits) {
  const TestMesh ball = ball_mesh({0, 0, 8}, 8, 5);
  std::string points;
  for (int i = 0; i < 225'000; ++i) points += "<vertex x=\"1\" y=\"1\" z=\"1\"/>";
  const std::string beside = "<object id=\"2\"><mesh><vertices>" + points + "</vertices></mesh></object>";
  const std::string bytes = threemf_with(
      model_of("<resources>" + object_of(ball, 1, "") + beside + "</resources><build><item objectid=\"1\"/></build>"));
  const SliceSettings settings = settings_with_pitch(0.1F);
  MemorySource source(bytes, "ball.3mf");
  const Slicing once(static_cast<ByteSource&>(source), settings, kArena);
  EXPECT_EQ(source.rewound, 3);  // before its first byte is parsed, see above
  MemorySource again(bytes, "ball.3mf");
  const Slicing thrice(static_cast<ByteSource&>(again), settings, 3517 * 1024);
  EXPECT_EQ(again.rewound, 5);  // and for two passes
  EXPECT_TRUE(same_rrep(once.rrep(), thrice.rrep()));
}

TEST(SliceMesh, ThePlanHoldsTheImagesOfAPanelThatIsMuchLargerThanTheMesh) {
  SliceSettings settings = settings_with_pitch(0.1F);
  settings.placement.printer = PrinterVolume{1440, 2560, 0.1F, 0.1F, 60};
  const SurfaceFile file = files_of(box_mesh({0, 0, 0}, {4, 3, 2})).front();
  const Slicing slicing(MemorySource(file.bytes, file.name), settings, kArena);
  constexpr auto kRRep = static_cast<std::size_t>(Stage::kRRep);
  EXPECT_LE(slicing.report().peak_bytes[kRRep], slicing.report().planned_bytes[kRRep]);
}

struct AsCase {
  const char* name;
  std::string bytes;
  ReadAs as;
  bool is_mesh;
};

TEST(SliceMesh, PointsWithFacesAreAMeshIfTheFacesAreTheSurfaceOfAnObject) {
  const TestMesh ball = ball_mesh({0, 0, 8}, 8, 5);
  TestMesh half = ball;
  std::erase_if(half.faces, [&](const auto& f) { return ball.vertices[f[0]][2] < 8; });
  TestMesh beside = ball;  // a mesh of a tenth of the points
  beside.faces.resize(ball.faces.size() / 10);
  const std::vector<AsCase> cases = {
      {"ball.ply", ascii_ply(ball), ReadAs::kAuto, true},      {"ball.obj", obj_of(ball), ReadAs::kAuto, true},
      {"ball.ply", ascii_ply(ball), ReadAs::kPoints, false},   {"half.ply", ascii_ply(half), ReadAs::kAuto, false},
      {"half.ply", ascii_ply(half), ReadAs::kMesh, true},      {"half.obj", obj_of(half), ReadAs::kAuto, false},
      {"beside.ply", ascii_ply(beside), ReadAs::kAuto, false}, {"beside.obj", obj_of(beside), ReadAs::kAuto, false}};
  for (const AsCase& test : cases) {
    for (const bool is_pipe : {false, true}) {
      MemorySource source(test.bytes, test.name);
      if (is_pipe) source.be_a_pipe();
      SliceSettings settings = settings_with_pitch(0.4F);
      settings.as = test.as;
      const Slicing slicing(static_cast<ByteSource&>(source), settings, kArena);
      EXPECT_EQ(slicing.report().mesh.has_value(), test.is_mesh) << test.name << ' ' << to_string(test.as);
    }
  }
}

TEST(SliceMesh, OneWrongFaceIsAnErrorAndNoScan) {
  const TestMesh ball = ball_mesh({0, 0, 8}, 8, 5);
  const std::string obj = obj_of(ball);
  const std::string ply = ascii_ply(ball);
  const std::tuple<const char*, std::string, ErrorCode, const char*> cases[] = {
      {"a.obj", obj + "f 1 2 x\n", ErrorCode::kMalformed, "expected the number of a vertex, found 'x'"},
      {"a.obj", obj + "f 1 2 9999999\n", ErrorCode::kMalformed, "a face names vertex 9999999"},
      {"a.ply", ply.substr(0, ply.size() - 40), ErrorCode::kTruncated, "faces that its header declares"},
  };
  for (const auto& [name, bytes, code, text] : cases) {
    ArenaBlock arena(kArena);
    SliceReport report;
    SliceSettings settings = settings_with_pitch(0.4F);
    MemorySource broken(bytes, name);
    const auto sliced = slice(broken, settings, *arena, nullptr, report);
    ASSERT_FALSE(sliced) << text;
    EXPECT_EQ(sliced.error().code(), code) << sliced.error().message();
    EXPECT_THAT(sliced.error().message(), AllOf(HasSubstr(text), HasSubstr("or read it as points")));
    settings.as = ReadAs::kPoints;
    MemorySource again(bytes, name);
    EXPECT_TRUE(slice(again, settings, *arena, nullptr, report)) << text;
  }
}

TEST(SliceMesh, WhatHasNoFacesIsNoMesh) {
  ArenaBlock arena(kArena);
  SliceReport report;
  SliceSettings settings = settings_with_pitch(0.4F);
  settings.as = ReadAs::kMesh;
  MemorySource points("0 0 0\n1 1 1\n", "a.xyz");
  const auto no_faces = slice(points, settings, *arena, nullptr, report);
  ASSERT_FALSE(no_faces);
  EXPECT_THAT(no_faces.error().message(), HasSubstr("a.xyz: the file has points but no faces; read it as points"));
  settings.as = ReadAs::kPoints;
  const std::string stl = binary_stl(box_mesh({0, 0, 0}, {1, 1, 1}));
  MemorySource mesh(stl, "a.stl");
  const auto no_points = slice(mesh, settings, *arena, nullptr, report);
  ASSERT_FALSE(no_points);
  EXPECT_THAT(no_points.error().message(), HasSubstr("read it as a mesh"));
}

TEST(SliceMesh, IsMeasuredAnewWhenItHasBeenTurnedTheBestWayUp) {
  TestMesh pyramid{{{0, -10, -10}, {0, 10, -10}, {0, 10, 10}, {0, -10, 10}, {25, 0, 0}}, {}};
  pyramid.faces = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.orient = true;
  const Slicing slicing = sliced(pyramid, settings);
  ASSERT_TRUE(slicing.report().turned);
  EXPECT_TRUE(slicing.report().mesh->closed);
  const auto& degrees = slicing.report().turned->degrees;
  const Mat3d turn = rotation_matrix({degrees[0], degrees[1], 0});
  EXPECT_FALSE(turn.isIdentity());
  Box3d box;
  for (const Vec3d& v : pyramid.vertices) box.extend(turn * v);
  EXPECT_LT((slicing.report().placement.size_mm - box.size()).norm(), 1e-9);
  EXPECT_NEAR(slicing.volume(), 20 * 20 * 25 / 3.0, 30);
  // A height is that of the mesh as it came, 20.
  settings.placement.size = PrintSize{Side::kHeight, 30};
  const Slicing sized = sliced(pyramid, settings);
  EXPECT_NEAR(sized.report().placement.scale, 1.5, 1e-9);
  EXPECT_TRUE(sized.report().turned_since);
  // Whoever types these angles gets the same.
  settings.orient = false;
  settings.placement.rotation_degrees = {degrees[0], degrees[1], 0};
  const Slicing typed = sliced(pyramid, settings);
  EXPECT_NEAR(typed.report().placement.scale, 1.5, 1e-9);
}

TEST(SliceMesh, AScanWithFacesStaysAScan) {
  const auto path = shared_scan("ucicouple_front.ply");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no ../shared/scans";
  const std::string bytes = content_of(path);
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.placement.size = PrintSize{Side::kLength, 20};
  const Slicing slicing(MemorySource(bytes, "ucicouple_front.ply"), settings, 256 * kMiB);
  EXPECT_FALSE(slicing.report().mesh);
}

TEST(InspectMesh, MeasuresPlacesAndSlicesCoarsely) {
  const std::string bytes = binary_stl(box_mesh({0, 0, 0}, {40, 30, 20}));
  MemorySource source(bytes, "box.stl");
  ByteSource* const one[] = {&source};
  ArenaBlock arena(kArena);
  InspectReport report;
  std::uint64_t crossings = 0;
  const auto look = [&](const RRep& rrep, const SliceReport&) -> Status {
    crossings = rrep.crossings();
    return {};
  };
  ASSERT_TRUE(inspect(ScanSources(one), settings_with_pitch(0.05F), *arena, nullptr, report, look));
  ASSERT_TRUE(report.mesh);
  EXPECT_TRUE(report.mesh->closed);
  EXPECT_EQ(report.mesh->triangles, 12U);
  ASSERT_TRUE(report.placement);
  EXPECT_EQ(report.placement->grid.layers, 400U);
  EXPECT_EQ(crossings, 160U * 120);
  EXPECT_EQ(arena->used(), 0U);
}

}  // namespace
}  // namespace plumbline
