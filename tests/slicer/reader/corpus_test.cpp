#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace {

constexpr std::nullopt_t kRead = std::nullopt;

struct CorpusFile {
  const char* path;
  std::uint64_t points;
  std::uint64_t not_finite;
  std::optional<ErrorCode> code;
};

/// Files of other projects' tests. A script that shares no code with the reader counted the points: vertices that the header
/// declares and the bytes hold, lines that begin with "v", columns decompressed with another LZF.
///
/// corrupted_invalid_vertex_count.ply declares 14 vertices instead of 12, and its faces have enough bytes for two more. A
/// reader that ignores faces can't notice. cturtle.pcd does not fit in the smallest workspace; see below.
constexpr CorpusFile kFiles[] = {
    // clang-format off
    {"assimp/LICENSE", 0, 0, ErrorCode::kUnknownFormat},
    {"assimp/OBJ/WusonOBJ.obj", 2117, 0, kRead},
    {"assimp/OBJ/box.obj", 8, 0, kRead},
    {"assimp/OBJ/box_UTF16BE.obj", 0, 0, ErrorCode::kUnsupported},
    {"assimp/OBJ/box_longline.obj", 8, 0, kRead},
    {"assimp/OBJ/box_mat_with_spaces.obj", 8, 0, kRead},
    {"assimp/OBJ/box_without_lineending.obj", 8, 0, kRead},
    {"assimp/OBJ/concave_polygon.obj", 64, 0, kRead},
    {"assimp/OBJ/cube_mtllib_after_g.obj", 8, 0, kRead},
    {"assimp/OBJ/cube_usemtl.obj", 8, 0, kRead},
    {"assimp/OBJ/cube_with_vertexcolors.obj", 8, 0, kRead},
    {"assimp/OBJ/cube_with_vertexcolors_uni.obj", 8, 0, kRead},
    {"assimp/OBJ/empty_mat.obj", 130, 0, kRead},
    {"assimp/OBJ/multiple_spaces.obj", 4, 0, kRead},
    {"assimp/OBJ/number_formats.obj", 0, 0, ErrorCode::kMalformed},
    {"assimp/OBJ/point_cloud.obj", 3, 0, kRead},
    {"assimp/OBJ/regr01.obj", 2108, 0, kRead},
    {"assimp/OBJ/regr_3429812.obj", 4, 0, kRead},
    {"assimp/OBJ/space_in_material_name.obj", 64, 0, kRead},
    {"assimp/OBJ/spider.obj", 762, 0, kRead},
    {"assimp/OBJ/testline.obj", 8, 0, kRead},
    {"assimp/OBJ/testmixed.obj", 8, 0, kRead},
    {"assimp/OBJ/testpoints.obj", 8, 0, kRead},
    {"assimp/PLY/Wuson.ply", 11184, 0, kRead},
    {"assimp/PLY/cube.ply", 8, 0, kRead},
    {"assimp/PLY/cube_binary.ply", 8, 0, kRead},
    {"assimp/PLY/cube_uv.ply", 24, 0, kRead},
    {"assimp/PLY/float-color.ply", 3, 0, kRead},
    {"assimp/PLY/issue623.ply", 24, 0, kRead},
    {"assimp/PLY/points.ply", 4, 0, kRead},
    {"assimp/invalid/OutOfMemory.off", 0, 0, ErrorCode::kUnsupported},
    {"assimp/invalid/empty.3ds", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.ase", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.lwo", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.md5mesh", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.obj", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.off", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.ply", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.raw", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.smd", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/empty.x", 0, 0, ErrorCode::kNoPoints},
    {"assimp/invalid/emptyIrrMesh.xml", 0, 0, ErrorCode::kUnknownFormat},
    {"assimp/invalid/malformed.obj", 8, 0, kRead},
    {"assimp/invalid/malformed2.obj", 8, 0, kRead},
    {"assimp/invalid/readme.txt", 0, 0, ErrorCode::kUnknownFormat},
    {"crlf/bun000.ply", 40256, 0, kRead},
    {"draco/Box.ply", 24, 0, kRead},
    {"draco/LICENSE", 0, 0, ErrorCode::kUnknownFormat},
    {"draco/cube_att.obj", 8, 0, kRead},
    {"draco/cube_att.ply", 24, 0, kRead},
    {"draco/cube_att_partial.obj", 8, 0, kRead},
    {"draco/cube_att_sub_o.obj", 8, 0, kRead},
    {"draco/cube_att_sub_o_2.obj", 8, 0, kRead},
    {"draco/cube_quads.obj", 8, 0, kRead},
    {"draco/cube_quads.ply", 8, 0, kRead},
    {"draco/cube_subd.obj", 1538, 0, kRead},
    {"draco/deg_faces.obj", 6, 0, kRead},
    {"draco/degenerate_mesh.obj", 3, 0, kRead},
    {"draco/delim_test.ply", 24, 0, kRead},
    {"draco/empty_name.obj", 3, 0, kRead},
    {"draco/eof_test.obj", 3, 0, kRead},
    {"draco/extra_vertex.obj", 10, 0, kRead},
    {"draco/float_inf_point_cloud.ply", 13, 3, kRead},
    {"draco/float_two_att_point_cloud.ply", 3, 0, kRead},
    {"draco/inf_nan.obj", 0, 0, ErrorCode::kNoPoints},
    {"draco/int_point_cloud.ply", 16, 0, kRead},
    {"draco/mat_test.obj", 3576, 0, kRead},
    {"draco/multiple_isolated_triangles.obj", 15, 0, kRead},
    {"draco/multiple_tetrahedrons.obj", 20, 0, kRead},
    {"draco/octagon.obj", 8, 0, kRead},
    {"draco/octagon_preserved.obj", 8, 0, kRead},
    {"draco/one_face_123.obj", 3, 0, kRead},
    {"draco/one_face_312.obj", 3, 0, kRead},
    {"draco/one_face_321.obj", 3, 0, kRead},
    {"draco/point_cloud_test_pos.obj", 4, 0, kRead},
    {"draco/point_cloud_test_pos.ply", 4, 0, kRead},
    {"draco/point_cloud_test_pos_norm.obj", 4, 0, kRead},
    {"draco/point_cloud_test_pos_norm.ply", 4, 0, kRead},
    {"draco/sphere.obj", 114, 0, kRead},
    {"draco/test_extra_whitespace.ply", 3, 0, kRead},
    {"draco/test_generic.ply", 114, 0, kRead},
    {"draco/test_lines.obj", 484, 0, kRead},
    {"draco/test_more_datatypes.ply", 3, 0, kRead},
    {"draco/test_nm.obj", 114, 0, kRead},
    {"draco/test_nm_trans.obj", 114, 0, kRead},
    {"draco/test_pos_color.ply", 114, 0, kRead},
    {"draco/test_pos_color_ascii.ply", 114, 0, kRead},
    {"draco/test_sphere.obj", 114, 0, kRead},
    {"draco/test_wrong_attribute_mapping.obj", 3, 0, kRead},
    {"draco/three_faces_123.obj", 6, 0, kRead},
    {"draco/three_faces_312.obj", 6, 0, kRead},
    {"draco/triangle.obj", 3, 0, kRead},
    {"draco/triangle_with_degenerate_tex_coords.obj", 3, 0, kRead},
    {"draco/two_faces_123.obj", 6, 0, kRead},
    {"draco/two_faces_312.obj", 6, 0, kRead},
    {"geogram_corrupt/corrupted_invalid_double.obj", 0, 0, ErrorCode::kMalformed},
    {"geogram_corrupt/corrupted_invalid_double.off", 0, 0, ErrorCode::kUnsupported},
    {"geogram_corrupt/corrupted_invalid_face_count.meshb", 0, 0, ErrorCode::kUnknownFormat},
    {"geogram_corrupt/corrupted_invalid_face_count.ply", 12, 0, kRead},
    {"geogram_corrupt/corrupted_invalid_facet_vertex.meshb", 0, 0, ErrorCode::kUnknownFormat},
    {"geogram_corrupt/corrupted_invalid_facet_vertex.obj", 6, 0, kRead},
    {"geogram_corrupt/corrupted_invalid_facet_vertex.off", 0, 0, ErrorCode::kUnsupported},
    {"geogram_corrupt/corrupted_invalid_facet_vertex_count.off", 0, 0, ErrorCode::kUnsupported},
    {"geogram_corrupt/corrupted_invalid_int.obj", 6, 0, kRead},
    {"geogram_corrupt/corrupted_invalid_int.off", 0, 0, ErrorCode::kUnsupported},
    {"geogram_corrupt/corrupted_invalid_triangle_count.stl", 0, 0, ErrorCode::kUnsupported},
    {"geogram_corrupt/corrupted_invalid_vertex_count.off", 0, 0, ErrorCode::kUnsupported},
    {"geogram_corrupt/corrupted_invalid_vertex_count.ply", 14, 0, kRead},
    {"geogram_corrupt/cube.obj", 8, 0, kRead},
    {"geogram_corrupt/icosa.obj", 12, 0, kRead},
    {"geogram_corrupt/truncated.meshb", 0, 0, ErrorCode::kUnknownFormat},
    {"geogram_corrupt/truncated.obj", 0, 0, ErrorCode::kTruncated},
    {"geogram_corrupt/truncated.off", 0, 0, ErrorCode::kUnsupported},
    {"geogram_corrupt/truncated.ply", 0, 0, ErrorCode::kTruncated},
    {"geogram_corrupt/truncated.stl", 0, 0, ErrorCode::kUnsupported},
    {"pcl_pcd/brisk_descriptors_gt.pcd", 0, 0, ErrorCode::kNoPoints},
    {"pcl_pcd/brisk_image_gt.pcd", 0, 0, ErrorCode::kNoPoints},
    {"pcl_pcd/brisk_keypoints_gt.pcd", 1860, 0, kRead},
    {"pcl_pcd/bun0.pcd", 397, 0, kRead},
    {"pcl_pcd/bun01.pcd", 200, 0, kRead},
    {"pcl_pcd/bun02.pcd", 217, 0, kRead},
    {"pcl_pcd/bun03.pcd", 197, 0, kRead},
    {"pcl_pcd/bun4.pcd", 361, 0, kRead},
    {"pcl_pcd/bunny.pcd", 397, 0, kRead},
    {"pcl_pcd/car6.pcd", 10031, 0, kRead},
    {"pcl_pcd/colored_cloud.pcd", 1000, 0, kRead},
    {"pcl_pcd/cturtle.pcd", 167198, 0, kRead},
    {"pcl_pcd/cube.ply", 24, 0, kRead},
    {"pcl_pcd/curve2d.pcd", 51, 0, kRead},
    {"pcl_pcd/curve3d.pcd", 110, 0, kRead},
    {"pcl_pcd/curve_close.pcd", 110, 0, kRead},
    {"pcl_pcd/ism_test.pcd", 3400, 0, kRead},
    {"pcl_pcd/ism_train.pcd", 3400, 0, kRead},
    {"pcl_pcd/lamppost.pcd", 1771, 0, kRead},
    {"pcl_pcd/milk.pcd", 13704, 0, kRead},
    {"pcl_pcd/milk_color.pcd", 13704, 0, kRead},
    {"pcl_pcd/nhood_test.pcd", 36, 0, kRead},
    {"pcl_pcd/noisy_slice_displaced.pcd", 3782, 0, kRead},
    {"pcl_pcd/octants.pcd", 8, 0, kRead},
    {"pcl_pcd/office1_keypoints.pcd", 1318, 0, kRead},
    {"pcl_pcd/office2_keypoints.pcd", 1123, 0, kRead},
    {"pcl_pcd/pcl_logo.pcd", 12909, 0, kRead},
    {"pcl_pcd/rops_cloud.pcd", 32087, 0, kRead},
    {"pcl_pcd/sac_plane_test.pcd", 3283, 0, kRead},
    // clang-format on
};

std::filesystem::path corpus() { return std::filesystem::path(PLUMBLINE_SOURCE_DIR) / "../shared/corpus"; }

std::string bytes_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

TEST(ScanCorpus, EveryFileGivesTheExpectedPointsOrError) {
  if (!std::filesystem::exists(corpus()))
    GTEST_SKIP() << "needs " << corpus() << ", which is not part of the repository";
  for (const auto& file : kFiles) {
    const auto bytes = bytes_of_file(corpus() / file.path);
    for (const auto& pieces : std::vector<std::vector<std::size_t>>{{}, {1021}}) {
      const auto reading = read(bytes, file.path, pieces, 8 * kReaderWorkspace);
      EXPECT_EQ(reading.code(), file.code) << file.path << ": " << reading.message();
      EXPECT_EQ(reading.sink.complaint, "") << file.path;
      if (!reading.summary) {
        EXPECT_THAT(reading.message(), ::testing::StartsWith(file.path));
        continue;
      }
      EXPECT_EQ(reading.summary->points, file.points) << file.path;
      EXPECT_EQ(reading.summary->not_finite, file.not_finite) << file.path;
      EXPECT_EQ(reading.sink.points.size(), file.points) << file.path;
    }
  }
}

TEST(ScanCorpus, TestsEveryFileOfTheFolder) {
  if (!std::filesystem::exists(corpus()))
    GTEST_SKIP() << "needs " << corpus() << ", which is not part of the repository";
  std::map<std::string, int> known;
  for (const auto& file : kFiles) known[file.path] = 1;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus())) {
    if (!entry.is_regular_file()) continue;
    EXPECT_EQ(known.count(std::filesystem::relative(entry.path(), corpus()).string()), 1U) << entry.path();
  }
}

TEST(ScanCorpus, TheSmallestWorkspaceReadsAllButTheOneLargeCompressedFile) {
  if (!std::filesystem::exists(corpus()))
    GTEST_SKIP() << "needs " << corpus() << ", which is not part of the repository";
  for (const auto& file : kFiles) {
    const auto reading = read(bytes_of_file(corpus() / file.path), file.path);
    const bool too_large = std::string_view(file.path) == "pcl_pcd/cturtle.pcd";
    EXPECT_EQ(reading.code(), too_large ? ErrorCode::kUnsupported : file.code)
        << file.path << ": " << reading.message();
  }
}

}  // namespace
}  // namespace plumbline::testing
