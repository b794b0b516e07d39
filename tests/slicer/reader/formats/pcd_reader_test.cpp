#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace pcd_reader_test {

using ::testing::HasSubstr;

const std::string kHead =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH "
    "2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";
const std::vector<ScanPoint> kTwo = {{1, 2, 3, 0, 0, 0}, {-4, 5.5, 60, 0, 0, 0}};

void expect_points(Reading reading, const std::vector<ScanPoint>& points, bool normals = false) {
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.sink.complaint, "");
  EXPECT_TRUE(same_points(reading.points(), points));
  EXPECT_EQ(reading.summary->header.has_normals, normals);
  EXPECT_EQ(reading.summary->header.format, ScanFormat::kPcd);
}

std::string compressed(std::string_view columns) {
  const auto block = lzf_compress(columns);
  return little(static_cast<std::uint32_t>(block.size()), static_cast<std::uint32_t>(columns.size())) + block;
}

TEST(PcdReader, ReadsAllThreeEncodings) {
  expect_points(read(kHead + "DATA ascii\n1 2 3\n-4 5.5 60\n"), kTwo);
  expect_points(read(kHead + "DATA binary\n" + little(1.0F, 2.0F, 3.0F, -4.0F, 5.5F, 60.0F)), kTwo);
  expect_points(read(kHead + "DATA binary_compressed\n" + compressed(little(1.0F, -4.0F, 2.0F, 5.5F, 3.0F, 60.0F))),
                kTwo);
}

TEST(PcdReader, TellsWhereTheScannerStood) {
  const auto views_of = [](const std::string& head) {
    const auto reading = read(head + "DATA ascii\n1 2 3\n-4 5.5 60\n1 2 4\n1 2 5\n");
    EXPECT_TRUE(reading.summary.has_value()) << reading.message();
    EXPECT_EQ(reading.sink.complaint, "");
    EXPECT_EQ(reading.sink.points.front().x, 1) << "points are not relative to it";
    return reading.sink.views;
  };
  const std::string list = replaced(replaced(kHead, "WIDTH 2", "WIDTH 4"), "POINTS 2", "POINTS 4");
  const std::string grid = replaced(replaced(kHead, "HEIGHT 1", "HEIGHT 2"), "POINTS 2", "POINTS 4");
  using Views = std::vector<BegunView>;
  EXPECT_EQ(views_of(list), Views{}) << "programs write the default if they don't know";
  EXPECT_EQ(views_of(grid), (Views{{0, Vec3d(0, 0, 0)}}));
  EXPECT_EQ(views_of(replaced(list, "T 0 0 0 1", "T 1 -2 3.5 1")), (Views{{0, Vec3d(1, -2, 3.5)}}));
  EXPECT_EQ(views_of(replaced(grid, "T 0 0 0 1", "T 1 -2 3.5 1")), (Views{{0, Vec3d(1, -2, 3.5)}}));
  EXPECT_EQ(views_of(replaced(list, "T 0 0 0 1", "T nan 2 3 1")), Views{});
  EXPECT_EQ(views_of(replaced(list, "T 0 0 0 1 0 0 0", "T 1 2 3")), Views{});
}

TEST(PcdReader, RefusesMorePointsThanItsHeaderDeclares) {
  const std::string ascii = kHead + "DATA ascii\n1 2 3\n-4 5.5 60\n";
  const std::string binary = kHead + "DATA binary\n" + little(1.0F, 2.0F, 3.0F, -4.0F, 5.5F, 60.0F);
  expect_points(read(ascii + "\n# the end\n"), kTwo);
  expect_points(read(binary + std::string(4096, '\0')), kTwo);
  EXPECT_THAT(read(ascii + "7 8 9\n", "bust.pcd").message(),
              HasSubstr("bust.pcd: line 14: its header declares 2 points, but '7 8 9' follows them"));
  const auto reading = read(binary + little(7.0F, 8.0F, 9.0F), "bust.pcd");
  EXPECT_EQ(reading.code(), ErrorCode::kMalformed);
  EXPECT_THAT(reading.message(), HasSubstr("declares 2 points, but 12 bytes follow them, enough for 1 more"));
}

TEST(PcdReader, AcceptsEveryLineEnd) {
  for (const char* end : {"\r\n", "\r"}) {
    expect_points(read(replaced(kHead + "DATA ascii\n1 2 3\n-4 5.5 60\n", "\n", end)), kTwo);
    expect_points(read(replaced(kHead + "DATA binary\n", "\n", end) + little(1.0F, 2.0F, 3.0F, -4.0F, 5.5F, 60.0F)),
                  kTwo);
  }
}

TEST(PcdReader, DoesNotNeedHeightViewpointAndPointsInOlderVersions) {
  for (const char* version : {".5", "0.5", ".6", ".7"}) {
    expect_points(read(std::string("# .PCD v.5\nVERSION ") + version +
                       "\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nDATA ascii\n1 2 3\n-4 5.5 60\n"),
                  kTwo);
  }
  expect_points(read("VERSION .7\nFIELDS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n-4 5.5 60\n"), kTwo);
  EXPECT_EQ(read(replaced(kHead, "VERSION 0.7", "VERSION 0.8") + "DATA ascii\n1 2 3\n4 5 6\n").code(),
            ErrorCode::kUnsupported);
}

/// Fields of every type in an unusual order, with padding between them.
const std::string kOddHead =
    "VERSION 0.7\nFIELDS _ normal_y z rgb x normal_z descriptor y normal_x empty\nSIZE 1 4 8 4 2 4 1 4 8 4\nTYPE U F F "
    "U "
    "I F U U F F\nCOUNT 3 1 1 1 1 1 5 1 1 0\nWIDTH 1\nHEIGHT 2\nPOINTS 2\n";
const std::vector<ScanPoint> kOdd = {{-7, 4e9, 0.125, 0, 1, 0}, {9, 1, -8, -1, 0, 0}};

TEST(PcdReader, AcceptsFieldsOfAnyOrderPaddingAndType) {
  const auto row = [](float ny, double z, std::int16_t x, float nz, std::uint32_t y, double nx) {
    return "___" + little(ny, z) + "rgba" + little(x, nz) + "descr" + little(y, nx);
  };
  expect_points(read(kOddHead + "DATA binary\n" + row(1, 0.125, -7, 0, 4000000000U, 0) + row(0, -8, 9, 0, 1, -1)), kOdd,
                true);
  expect_points(read(kOddHead + "DATA binary_compressed\n" +
                     compressed("______" + little(1.0F, 0.0F) + little(0.125, -8.0) + "rgbargba" +
                                little(std::int16_t{-7}, std::int16_t{9}) + little(0.0F, 0.0F) + "descrdescr" +
                                little(4000000000U, 1U) + little(0.0, -1.0))),
                kOdd, true);
  expect_points(read(kOddHead + "DATA ascii\n9 9 9 1 0.125 5 -7 0 1 2 3 4 5 4000000000 0\n"
                                "9 9 9 0 -8 5 9 0 1 2 3 4 5 1 -1\n"),
                kOdd, true);
}

TEST(PcdReader, DropsAndCountsPointsThatAreNotFinite) {
  const auto reading = read(kHead + "DATA ascii\nnan nan nan\n1 2 3\n");
  ASSERT_TRUE(reading.summary.has_value());
  EXPECT_EQ(reading.summary->points, 1U);
  EXPECT_EQ(reading.summary->not_finite, 1U);
  const auto binary = read(kHead + "DATA binary\n" + little(1.0F, 2.0F, std::nanf(""), 1.0F, 2.0F, 3.0F));
  EXPECT_EQ(binary.summary->not_finite, 1U);
}

TEST(PcdReader, SaysHowManyOfTheDeclaredPointsItRead) {
  for (const auto& file :
       {kHead + "DATA ascii\n1 2 3\n", kHead + "DATA binary\n" + little(1.0F, 2.0F, 3.0F, -4.0F, 5.5F)}) {
    const auto reading = read(file, "bust.pcd");
    EXPECT_EQ(reading.code(), ErrorCode::kTruncated);
    EXPECT_THAT(reading.message(), HasSubstr("bust.pcd: "));
    EXPECT_THAT(reading.message(), HasSubstr("with 1 of the 2 points"));
  }
  const auto whole = kHead + "DATA binary_compressed\n" + compressed(little(1.0F, -4.0F, 2.0F, 5.5F, 3.0F, 60.0F));
  const auto cut = read(whole.substr(0, whole.size() - 3));
  EXPECT_EQ(cut.code(), ErrorCode::kTruncated);
  EXPECT_THAT(cut.message(), HasSubstr("of the 2 points"));
}

TEST(PcdReader, RefusesInvalidHeaders) {
  const auto file = kHead + "DATA ascii\n1 2 3\n-4 5.5 60\n";
  const std::pair<std::string, ErrorCode> cases[] = {
      {replaced(file, "POINTS 2", "POINTS 3"), ErrorCode::kMalformed},
      {replaced(file, "WIDTH 2", "WIDTH 9223372036854775808"), ErrorCode::kMalformed},
      {replaced(file, "WIDTH 2", "WIDTH -2"), ErrorCode::kMalformed},
      {replaced(replaced(file, "WIDTH 2", "WIDTH 0"), "POINTS 2", "POINTS 0"), ErrorCode::kNoPoints},
      {replaced(replaced(file, "WIDTH 2\n", ""), "POINTS 2\n", ""), ErrorCode::kMalformed},
      {replaced(file, "FIELDS x y z\n", ""), ErrorCode::kMalformed},
      {replaced(file, "FIELDS x y z", "FIELDS"), ErrorCode::kMalformed},
      {replaced(file, "FIELDS x y z", "FIELDS x y rgb"), ErrorCode::kNoPoints},
      {replaced(file, "FIELDS x y z", "FIELDS x y z\nFIELDS x y z"), ErrorCode::kMalformed},
      {replaced(file, "SIZE 4 4 4", "SIZE 4 4"), ErrorCode::kMalformed},
      {replaced(file, "SIZE 4 4 4", "SIZE 4 4 4 4"), ErrorCode::kMalformed},
      {replaced(file, "SIZE 4 4 4", "SIZE 4 4 3"), ErrorCode::kMalformed},
      {replaced(file, "SIZE 4 4 4", "SIZE 4 4 0"), ErrorCode::kMalformed},
      {replaced(file, "SIZE 4 4 4", "SIZE 4 4 4294967296"), ErrorCode::kMalformed},
      {replaced(file, "TYPE F F F", "TYPE F F Q"), ErrorCode::kMalformed},
      {replaced(file, "COUNT 1 1 1", "COUNT 1 1 2"), ErrorCode::kMalformed},
      {replaced(file, "DATA ascii", "DATA zstd"), ErrorCode::kMalformed},
      {replaced(file, "HEIGHT", "DEPTH"), ErrorCode::kMalformed},
      {kHead, ErrorCode::kTruncated},
      {"# .PCD", ErrorCode::kTruncated},
  };
  for (const auto& [bytes, code] : cases) EXPECT_EQ(read(bytes).code(), code) << bytes;
}

/// A compressed file of `points` points on a curve, and the points themselves.
std::string curve(std::size_t points, std::vector<ScanPoint>& truth) {
  std::string x, y, z;
  std::mt19937 random(7);
  for (std::size_t i = 0; i < points; ++i) {
    const std::size_t row = i / 50;
    const auto px = static_cast<float>(i % 50), py = static_cast<float>(row), pz = static_cast<float>(random() % 10);
    x += little(px);
    y += little(py);
    z += little(pz);
    truth.push_back({px, py, pz, 0, 0, 0});
  }
  const auto count = std::to_string(points);
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + count + "\nHEIGHT 1\nPOINTS " +
         count + "\nDATA binary_compressed\n" + compressed(x + y + z);
}

TEST(PcdReader, ReadsCompressedColumnsLongerThanTheWindow) {
  std::vector<ScanPoint> truth;
  const auto file = curve(20000, truth);
  expect_points(read(file), truth);
  expect_points(read(file, "scan", {1, 7, 4096}), truth);
}

TEST(PcdReader, RefusesCompressedColumnsThatDoNotFitTheWorkspace) {
  // 60,000 points of zeros: back references of the greatest length and the least distance.
  std::string block(1, '\0');
  block += '\0';
  std::uint32_t made = 1;
  const std::uint32_t bytes = 60000 * 12;
  while (made + 264 <= bytes) {
    block += "\xe0\xff";
    block += '\0';
    made += 264;
  }
  while (made < bytes) {
    block += '\0';
    block += '\0';
    ++made;
  }
  const auto file = replaced(replaced(kHead, "WIDTH 2", "WIDTH 60000"), "POINTS 2", "POINTS 60000") +
                    "DATA binary_compressed\n" + little(static_cast<std::uint32_t>(block.size()), bytes) + block;
  const auto refused = read(file, "bust.pcd");
  EXPECT_EQ(refused.code(), ErrorCode::kUnsupported);
  EXPECT_THAT(refused.message(), HasSubstr("bust.pcd: "));
  EXPECT_THAT(refused.message(), HasSubstr("60000 points"));
  EXPECT_THAT(refused.message(), HasSubstr("Save the file as binary"));
  EXPECT_TRUE(refused.sink.points.empty());
  const auto read_whole = read(file, "bust.pcd", {}, 2 * kReaderWorkspace);
  ASSERT_TRUE(read_whole.summary.has_value()) << read_whole.message();
  EXPECT_EQ(read_whole.summary->points, 60000U);
}

TEST(PcdReader, RefusesInvalidCompressedBlocks) {
  const auto columns = little(1.0F, -4.0F, 2.0F, 5.5F, 3.0F, 60.0F);
  const auto block = lzf_compress(columns);
  const auto head = kHead + "DATA binary_compressed\n";
  const auto size = static_cast<std::uint32_t>(block.size());
  EXPECT_EQ(read(head + little(size, 25U) + block).code(), ErrorCode::kMalformed) << "size of the columns";
  EXPECT_EQ(read(head + little(size, UINT32_MAX) + block).code(), ErrorCode::kMalformed);
  EXPECT_EQ(read(head + little(size - 1, 24U) + block).code(), ErrorCode::kMalformed) << "step cut by the block's end";
  EXPECT_EQ(read(head + little(0U, 24U)).code(), ErrorCode::kMalformed) << "no block";
  EXPECT_EQ(read(head + little(4U, 24U) + std::string("\0a\x20\x01", 4)).code(), ErrorCode::kMalformed)
      << "reference to before the start";
  EXPECT_EQ(read(head + little(UINT32_MAX, 24U) + std::string("\x05xxxxxx", 7)).code(), ErrorCode::kTruncated);
  EXPECT_EQ(read(head + "abc").code(), ErrorCode::kTruncated);
}

}  // namespace pcd_reader_test
}  // namespace plumbline::testing
