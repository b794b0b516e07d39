#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace obj_reader_test {

using ::testing::HasSubstr;

const std::vector<ScanPoint> kBare = {{1, 2, 3, 0, 0, 0}, {4, 5, 6, 0, 0, 0}};
const std::vector<ScanPoint> kWithNormals = {{1, 2, 3, 0, 0, 1}, {4, 5, 6, 0, 1, 0}};

void expect_points(Reading reading, const std::vector<ScanPoint>& points, bool normals) {
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.sink.complaint, "");
  EXPECT_TRUE(same_points(reading.points(), points));
  EXPECT_EQ(reading.summary->header.has_normals, normals);
  EXPECT_EQ(reading.summary->header.format, ScanFormat::kObj);
}

TEST(ObjReader, ReadsVerticesAndIgnoresEverythingElse) {
  const std::string file =
      "# made by hand\nmtllib a.mtl\no head\ng a b\ns off\nv 1 2 3\nvt 0 0\nv 4 +5 6.0\nvp 1\nusemtl skin\nf 1 2 1\nl "
      "1 "
      "2\np 1\nnonsense \x01\x02\n";
  expect_points(read(file), kBare, false);
  expect_points(read(replaced(file, "\n", "\r\n")), kBare, false);
  expect_points(read(replaced(file, "\n", "\r")), kBare, false);
  expect_points(read("\xef\xbb\xbf" + file), kBare, false);
}

TEST(ObjReader, IgnoresWeightsAndColoursAfterTheCoordinates) {
  expect_points(read("v 1 2 3 1.0\nv 4 5 6 0.5 0.5 0.5\n"), kBare, false);
}

TEST(ObjReader, TakesANormalBeforeOrAfterEachVertex) {
  expect_points(read("vn 0 0 1\nv 1 2 3\nvn 0 1 0\nv 4 5 6\n"), kWithNormals, true);
  expect_points(read("v 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 0 1 0\n"), kWithNormals, true);
  expect_points(read("v 1 2 3\n# a\nvt 0 0\nvn 0 0 1\n\nv 4 5 6\nvn 0 1 0\nf 1//1 2//2\n"), kWithNormals, true);
}

TEST(ObjReader, IgnoresNormalsInASeparateBlock) {
  expect_points(read("v 1 2 3\nv 4 5 6\nvn 0 0 1\nvn 0 1 0\n"), kBare, false);
  expect_points(read("vn 0 0 1\nvn 0 1 0\nv 1 2 3\nv 4 5 6\n"), kBare, false);
}

TEST(ObjReader, LeavesAPointWithoutNormalWhereThePatternBreaks) {
  expect_points(read("vn 0 0 1\nv 1 2 3\nv 4 5 6\n"), {kWithNormals[0], kBare[1]}, true);
  expect_points(read("v 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 0 1 0\nvn 1 0 0\n"), {kWithNormals[0], kBare[1]}, true);
  expect_points(read("vn 0 0 1\nv 1 2 3\nvn 0 1 0\nvn 1 0 0\nv 4 5 6\n"), {kWithNormals[0], kBare[1]}, true);
  EXPECT_EQ(read("vn 0 0 1\nv 1 2 3\nv 4 5 6\n").summary->without_normal, 1U);
}

TEST(ObjReader, ABackslashContinuesTheLine) {
  expect_points(read("v 1 \\\n2 \\\r\n 3\nf 1 \\\nv 9 9 9 \\\n2\nv 4 5 6\n"), kBare, false);
  expect_points(read("# C:\\scans\\\nv 1 2 3\nv 4 5 6 \\"), kBare, false);
  const auto cut = read("v 1 2 3\nv 4 5 \\");
  EXPECT_EQ(cut.code(), ErrorCode::kTruncated);
  std::string parts = "v 1 ";
  for (int i = 0; i < 3000; ++i) parts += "\\\n   ";
  EXPECT_EQ(read(parts + "2 3\n", "a.obj").code(), ErrorCode::kUnsupported);
}

TEST(ObjReader, SkipsLinesOfAnyLength) {
  std::string face = "f";
  for (int i = 0; i < 100000; ++i) face += " 1 2";
  expect_points(read("v 1 2 3\n" + face + "\nv 4 5 6\n"), kBare, false);
  expect_points(read("v 1 2 3\n" + face + "\\\nv 9 9 9\nv 4 5 6\n"), kBare, false);
  expect_points(read(std::string("v 1 2 3\n# ") + std::string(200000, '\\') + "\nv 4 5 6\n"), kBare, false);
  expect_points(read(std::string("v 1 2 3") + std::string(200000, ' ') + "\nv 4 5 6\n"), kBare, false);
}

TEST(ObjReader, DoesNotReadHalfANumberAtTheEndOfACutLine) {
  const auto reading = read(std::string("v 1 2") + std::string(65536 - 8, ' ') + "1.2345\n", "a.obj");
  EXPECT_EQ(reading.code(), ErrorCode::kUnsupported) << reading.message();
}

TEST(ObjReader, NamesTheLineWithTheError) {
  const auto reading = read("v 1 2 3\nv 4 XXX5 6\n", "head.obj");
  EXPECT_EQ(reading.code(), ErrorCode::kMalformed);
  EXPECT_THAT(reading.message(), HasSubstr("head.obj: line 2: expected a number for y, found 'XXX5'"));
  EXPECT_EQ(read("v 1 2\n").code(), ErrorCode::kMalformed);
  EXPECT_EQ(read("v\n").code(), ErrorCode::kMalformed);
  EXPECT_EQ(read("v 1 2 3\nvn 1 0\nv 4 5 6\n").code(), ErrorCode::kMalformed);
  EXPECT_EQ(read("v 1 2 3\nv 4 5").code(), ErrorCode::kTruncated);
}

TEST(ObjReader, FindsNoPointsInAFileWithoutVertices) {
  EXPECT_EQ(read("o head\nf 1 2 3\n").code(), ErrorCode::kNoPoints);
  const auto nowhere = read("v inf nan +inf\nv 3 NaN -NaN\n");
  EXPECT_EQ(nowhere.code(), ErrorCode::kNoPoints);
  EXPECT_THAT(nowhere.message(), HasSubstr("(2 in all)"));
}

}  // namespace obj_reader_test
}  // namespace plumbline::testing
