/// Meshes from other projects' test suites, in a folder beside the repository: whole, odd and broken.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slicer/reader/triangles/mesh_reader.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/shared_scan.hpp"

namespace plumbline {
namespace {

using namespace testing;

class Counter final : public TriangleSink {
 public:
  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) {
      for (const Vec3d& p : t) EXPECT_TRUE(p.allFinite());
    }
    count += triangles.size();
    return {};
  }
  bool progress(double /*fraction*/) override { return true; }
  std::uint64_t count = 0;
};

Expected<MeshSummary> read_file(const std::filesystem::path& path, const std::string& name,
                                std::vector<std::size_t> pieces, Counter& sink) {
  const std::string bytes = content_of(path);
  MemorySource source(bytes, name, std::move(pieces));
  ArenaBlock arena(8 * kMiB);
  VertexList vertices = *VertexList::create(100'000, *arena);
  std::vector<std::byte> workspace(kReaderWorkspace, std::byte{0xA5});
  return read_mesh(source, sink, vertices, workspace);
}

struct CorpusMesh {
  const char* path;
  std::uint64_t triangles;
  std::optional<ErrorCode> code;
};
constexpr auto kRead = std::nullopt;

constexpr CorpusMesh kMeshes[] = {
    {"assimp/PLY/cube.ply", 12, kRead},
    {"assimp/PLY/cube_binary.ply", 12, kRead},
    {"assimp/invalid/OutOfMemory.off", 0, ErrorCode::kTruncated},
    {"assimp/invalid/empty.off", 0, ErrorCode::kNoPoints},
    {"draco/Box.ply", 12, kRead},
    {"draco/cube_att.obj", 12, kRead},
    {"draco/cube_att_sub_o.obj", 12, kRead},
    {"draco/cube_quads.obj", 12, kRead},
    {"draco/cube_quads.ply", 12, kRead},
    {"draco/octagon.obj", 6, kRead},
    {"draco/one_face_312.obj", 1, kRead},
    {"draco/sphere.obj", 224, kRead},
    {"draco/triangle.obj", 1, kRead},
    {"geogram_corrupt/corrupted_invalid_double.obj", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_double.off", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_face_count.ply", 0, ErrorCode::kTruncated},
    {"geogram_corrupt/corrupted_invalid_facet_vertex.obj", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_facet_vertex.off", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_facet_vertex_count.off", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_int.obj", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_int.off", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_triangle_count.stl", 0, ErrorCode::kTruncated},
    {"geogram_corrupt/corrupted_invalid_vertex_count.off", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/cube.obj", 12, kRead},
    {"geogram_corrupt/icosa.obj", 20, kRead},
    {"geogram_corrupt/truncated.off", 0, ErrorCode::kMalformed},
    {"geogram_corrupt/truncated.stl", 0, ErrorCode::kTruncated},
};

std::filesystem::path corpus() { return std::filesystem::path(PLUMBLINE_SOURCE_DIR) / "../shared/corpus"; }

TEST(MeshCorpus, FilesGiveTheExpectedTrianglesOrError) {
  if (!std::filesystem::exists(corpus())) GTEST_SKIP() << "needs " << corpus();
  for (const CorpusMesh& mesh : kMeshes) {
    for (const std::vector<std::size_t>& pieces : {std::vector<std::size_t>{}, {61}}) {
      Counter sink;
      const auto summary = read_file(corpus() / mesh.path, mesh.path, pieces, sink);
      EXPECT_EQ(summary ? std::nullopt : std::optional(summary.error().code()), mesh.code)
          << mesh.path << ": " << (summary ? "" : summary.error().message());
      if (summary) {
        EXPECT_EQ(sink.count, mesh.triangles) << mesh.path;
      } else {
        EXPECT_THAT(summary.error().message(), ::testing::StartsWith(mesh.path));
      }
    }
  }
}

TEST(MeshCorpus, EveryFileIsReadOrRefusedInWords) {
  if (!std::filesystem::exists(corpus())) GTEST_SKIP() << "needs " << corpus();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus())) {
    if (!entry.is_regular_file()) continue;
    Counter sink;
    const std::string name = entry.path().filename().string();
    const auto summary = read_file(entry.path(), name, {}, sink);
    if (!summary) {
      EXPECT_THAT(summary.error().message(), ::testing::StartsWith(name + ": "));
    }
  }
}

}  // namespace
}  // namespace plumbline
