#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;

const std::string kAsciiCube =
    "ply\nformat ascii 1.0\ncomment made by hand\nobj_info nothing\nelement vertex 3\nproperty float x\nproperty float "
    "y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 1\nproperty list uchar "
    "int vertex_indices\nend_header\n0 0.5 1e1 0 0 1\n-1 +2 .5 1 0 0\n7 8 9 0 0 0\n3 0 1 2\n";

void expect_ascii_cube(Reading& reading) {
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.sink.complaint, "");
  ASSERT_EQ(reading.points().size(), 3U);
  EXPECT_TRUE(same_points(reading.points(), {{0, 0.5, 10, 0, 0, 1}, {-1, 2, 0.5, 1, 0, 0}, {7, 8, 9, 0, 0, 0}}));
  EXPECT_EQ(reading.summary->points, 3U);
  EXPECT_EQ(reading.summary->without_normal, 1U);
  EXPECT_EQ(reading.summary->header.declared_points, 3U);
  EXPECT_TRUE(reading.summary->header.has_normals);
  EXPECT_STREQ(reading.summary->header.encoding, "ascii");
}

TEST(PlyReader, ReadsAsciiWithNormalsAndIgnoresFaces) {
  auto reading = read(kAsciiCube);
  expect_ascii_cube(reading);
}

TEST(PlyReader, AcceptsEveryLineEnd) {
  for (const char* end : {"\r\n", "\r", "\r\r\n"}) {
    auto reading = read(replaced(kAsciiCube, "\n", end));
    expect_ascii_cube(reading);
  }
}

TEST(PlyReader, AcceptsAByteOrderMarkAndExtraWhiteSpace) {
  auto marked = read("\xef\xbb\xbf" + kAsciiCube);
  expect_ascii_cube(marked);
  auto spaced = read(replaced(replaced(kAsciiCube, " ", " \t "), "\n", "  \n\n \n"));
  expect_ascii_cube(spaced);
}

template <std::endian Order>
std::string binary_with_everything() {
  std::string file =
      std::string("ply\nformat ") + (Order == std::endian::little ? "binary_little_endian" : "binary_big_endian") +
      " 1.0\nelement camera 2\nproperty double focus\nproperty list ushort short marks\nelement empty "
      "9223372036854775808\nelement matrix 3\nproperty int8 a\nproperty int16 b\nelement vertex 2\nproperty uchar "
      "red\nproperty double z\nproperty list uchar double weights\nproperty int16 x\nproperty float32 normal_z\n"
      "property float normal_x\nproperty uint32 y\nproperty double normal_y\nproperty list int32 uint8 tail\n"
      "element face 7\nproperty list uchar int vertex_indices\nend_header\n";
  file += bytes_of<Order>(1.5, std::uint16_t{3}, std::int16_t{1}, std::int16_t{2}, std::int16_t{3});
  file += bytes_of<Order>(2.5, std::uint16_t{0});
  for (int i = 0; i < 3; ++i) file += bytes_of<Order>(std::int8_t{1}, std::int16_t{2});
  file += bytes_of<Order>(std::uint8_t{255}, 3.25, std::uint8_t{2}, 0.5, 0.5, std::int16_t{-7}, 0.0F, 1.0F,
                          std::uint32_t{4000000000U}, 0.0, std::int32_t{1}, std::uint8_t{9});
  file += bytes_of<Order>(std::uint8_t{0}, -1e-3, std::uint8_t{0}, std::int16_t{12}, -1.0F, 0.0F, std::uint32_t{1}, 0.0,
                          std::int32_t{0});
  return file;  // without its seven faces, which are not needed
}

TEST(PlyReader, ReadsBothByteOrdersAnyTypesAnyOrderListsAndElementsBeforeTheVertices) {
  for (auto reading :
       {read(binary_with_everything<std::endian::little>()), read(binary_with_everything<std::endian::big>())}) {
    ASSERT_TRUE(reading.summary.has_value()) << reading.message();
    EXPECT_TRUE(same_points(reading.points(), {{-7, 4e9, 3.25, 1, 0, 0}, {12, 1, -1e-3, 0, 0, -1}}));
  }
}

TEST(PlyReader, ReadsALineFeedAsDataAfterAHeaderWithCrLineEnds) {
  std::string head =
      "ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty uchar x\rproperty uchar "
      "y\rproperty uchar z\rend_header\r";
  auto reading = read(head + "\n\r\n");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_TRUE(same_points(reading.points(), {{10, 13, 10, 0, 0, 0}}));
}

TEST(PlyReader, SkipsAsciiElementsAndListsAnywhere) {
  auto reading = read(
      "ply\nformat ascii 1.0\nelement strip 2\nproperty list int int i\nelement vertex 2\nproperty list uchar int "
      "neighbours\nproperty int y\nproperty float s\nproperty int x\nproperty int z\nproperty list uchar int "
      "more\nend_header\n3 1 2 3\n0\n2 7 7 1 0.5 2 3 0\n0 4 0.5 5 6 2 1 1\n");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_TRUE(same_points(reading.points(), {{2, 1, 3, 0, 0, 0}, {5, 4, 6, 0, 0, 0}}));
  EXPECT_FALSE(reading.summary->header.has_normals);
}

TEST(PlyReader, NeedsAllThreePropertiesOfANormal) {
  auto reading = read(replaced(kAsciiCube, "property float nz", "property float curvature"));
  ASSERT_TRUE(reading.summary.has_value());
  EXPECT_FALSE(reading.summary->header.has_normals);
  EXPECT_EQ(reading.points()[0].ny, 0);
  EXPECT_EQ(reading.points()[1].nx, 0);
}

TEST(PlyReader, DropsAndCountsPointsThatAreNotFinite) {
  auto reading = read(
      "ply\nformat ascii 1.0\nelement vertex 9\nproperty double x\nproperty double y\nproperty double "
      "z\nend_header\n1 2 3\nnan 0 0\n0 -inf 0\n0 0 1e400\n0 0 -1e400\n0 0 1e-400\n1.#QNAN 0 0\n0 1.#INF00 0\n0 "
      "-nan(ind) "
      "0\n");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->not_finite, 7U);
  EXPECT_TRUE(same_points(reading.points(), {{1, 2, 3, 0, 0, 0}, {0, 0, 0, 0, 0, 0}}));
}

TEST(PlyReader, DropsNormalsThatAreNanOrTooLargeForAFloat) {
  auto reading = read(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty double "
      "nx\nproperty double ny\nproperty double nz\nend_header\n1 2 3 nan 0 1\n1 2 3 0 1e300 1\n1 2 3 0 0 30\n");
  ASSERT_TRUE(reading.summary.has_value());
  EXPECT_TRUE(same_points(reading.points(), {{1, 2, 3, 0, 0, 0}, {1, 2, 3, 0, 0, 0}, {1, 2, 3, 0, 0, 30}}));
  EXPECT_EQ(reading.summary->without_normal, 2U);
}

TEST(PlyReader, IgnoresElementsAfterTheVerticesButNoOtherData) {
  auto reading = read(replaced(kAsciiCube, "vertex 3", "vertex 2"));
  ASSERT_TRUE(reading.summary.has_value());
  EXPECT_EQ(reading.summary->points, 2U);
  const std::string two =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nelement face "
      "0\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n4 5 6\n";
  EXPECT_TRUE(read(two + "\n  \nthe end\n").summary);
  auto more = read(two + "7 8 9\n", "bust.ply");
  EXPECT_EQ(more.code(), ErrorCode::kMalformed);
  EXPECT_THAT(
      more.message(),
      HasSubstr("bust.ply: line 12: its header declares 2 vertices, but '7 8 9' follows them; export it again"));
  const std::string head = replaced(two.substr(0, two.find("1 2 3")), "ascii", "binary_little_endian");
  const std::string points = little(1.F, 2.F, 3.F, 4.F, 5.F, 6.F);
  EXPECT_TRUE(read(head + points + std::string(11, 'x')).summary);
  EXPECT_TRUE(read(head + points + std::string(512, '\0')).summary);
  more = read(head + points + points, "bust.ply");
  EXPECT_THAT(more.message(), HasSubstr("declares 2 vertices, but 24 bytes follow them, enough for 2 more"));
}

TEST(PlyReader, SaysHowManyOfTheDeclaredPointsItRead) {
  auto ascii = read(replaced(kAsciiCube, "vertex 3", "vertex 9"), "bust.ply");
  EXPECT_EQ(ascii.code(), ErrorCode::kTruncated) << "the row of a face is not a point";
  auto shorter = read(kAsciiCube.substr(0, kAsciiCube.find("7 8 9")), "bust.ply");
  EXPECT_EQ(shorter.code(), ErrorCode::kTruncated);
  EXPECT_THAT(shorter.message(), HasSubstr("bust.ply: "));
  EXPECT_THAT(shorter.message(), HasSubstr("with 2 of the 3 points"));
  const auto whole = binary_with_everything<std::endian::little>();
  auto binary = read(whole.substr(0, whole.size() - 1), "bust.ply");
  EXPECT_EQ(binary.code(), ErrorCode::kTruncated);
  EXPECT_THAT(binary.message(), HasSubstr("with 1 of the 2 points"));
}

TEST(PlyReader, DistinguishesATruncatedRowFromAnIncompleteOne) {
  const auto start = kAsciiCube.substr(0, kAsciiCube.find("7 8 9"));
  EXPECT_EQ(read(start + "7 8").code(), ErrorCode::kTruncated);
  EXPECT_EQ(read(start + "7 8 -").code(), ErrorCode::kTruncated);
  EXPECT_EQ(read(start + "7 8\n").code(), ErrorCode::kTruncated);
}

TEST(PlyReader, NamesTheLineAndTheWordThatIsNotANumber) {
  const auto reading = read(replaced(kAsciiCube, "+2", "2,5"), "bust.ply");
  EXPECT_EQ(reading.code(), ErrorCode::kMalformed);
  EXPECT_THAT(reading.message(), HasSubstr("bust.ply: line 16: expected a number for y, found '2,5'"));
}

TEST(PlyReader, ReadsTextByWordsWhereverLinesEnd) {
  const std::string head = kAsciiCube.substr(0, kAsciiCube.find("0 0.5"));
  const std::string words = kAsciiCube.substr(head.size());
  for (std::size_t period = 1; period < 30; ++period) {
    std::string text = head;
    std::size_t count = 0;
    for (const char c : words) {
      const bool is_end = c == ' ' || c == '\n';
      text += is_end ? (++count % period == 0 ? '\n' : ' ') : c;
    }
    auto reading = read(text);
    expect_ascii_cube(reading);
  }
}

TEST(PlyReader, ReadsALineOfAnyLengthByWords) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 50000\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (int i = 0; i < 50'000; ++i) text += std::to_string(i) + " 12.5 " + std::to_string(-i) + ' ';
  auto reading = read(text);
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  ASSERT_EQ(reading.points().size(), 50'000U);
  for (int i = 0; i < 50'000; ++i) {
    EXPECT_TRUE(same_point(reading.points()[static_cast<std::size_t>(i)], {1.0 * i, 12.5, -1.0 * i, 0, 0, 0})) << i;
  }
}

TEST(PlyReader, RefusesRowsThatDontFitTheirHeader) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 12\nproperty float x\nproperty float y\nproperty float z\n!element face "
      "12\nproperty list uchar int vertex_indices\nend_header\n";
  std::string more, fewer, faces;
  for (int i = 0; i < 12; ++i) {
    more += std::to_string(i) + ".5 1.5 2.5 7\n";
    fewer += std::to_string(i) + ".5 1.5 2.5\n";
    faces += "3 0 1 2\n";
  }
  EXPECT_TRUE(read(replaced(head, "!", "") + fewer + faces).summary.has_value());
  EXPECT_EQ(read(replaced(head, "!", "") + more + faces).code(), ErrorCode::kMalformed);
  const auto four = read(replaced(head, "!", "property float intensity\n") + fewer + faces);
  EXPECT_TRUE(four.code() == ErrorCode::kTruncated || four.code() == ErrorCode::kMalformed) << four.message();
}

TEST(PlyReader, TakesAMissingListAtTheEndOfARowAsEmpty) {
  auto reading = read(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty list "
      "uchar uint vertex_indices\nend_header\n1 2 3\n4 5 6\n");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->points, 2U);
}

TEST(PlyReader, IgnoresUnknownLinesOnlyBeforeTheFirstElement) {
  EXPECT_TRUE(read(replaced(kAsciiCube, "comment made", "made")).summary.has_value());
  const auto reading = read(replaced(kAsciiCube, "property float y", "propery float y"));
  EXPECT_EQ(reading.code(), ErrorCode::kMalformed);
  EXPECT_THAT(reading.message(), HasSubstr("line 7"));
}

TEST(PlyReader, RefusesInvalidHeaders) {
  const std::pair<std::string, ErrorCode> cases[] = {
      {replaced(kAsciiCube, "ascii 1.0", "ascii 2.0"), ErrorCode::kUnsupported},
      {replaced(kAsciiCube, "ascii 1.0", "utf8 1.0"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "format ascii 1.0\n", ""), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "vertex 3", "vertex -3"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "vertex 3", "vertex"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "vertex 3", "vertex 3.5"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "vertex 3", "vertex 18446744073709551616"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "vertex 3", "vertex 0"), ErrorCode::kNoPoints},
      {replaced(kAsciiCube, "element vertex", "element point"), ErrorCode::kNoPoints},
      {replaced(kAsciiCube, "float y", "float v"), ErrorCode::kNoPoints},
      {replaced(kAsciiCube, "float y", "half y"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "float y", "float"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "float y", "list uchar float y"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "float nx", "list float float q"), ErrorCode::kMalformed},
      {replaced(kAsciiCube, "element vertex 3\n", ""), ErrorCode::kMalformed},
      {kAsciiCube.substr(0, kAsciiCube.find("end_header")), ErrorCode::kTruncated},
      {"ply", ErrorCode::kTruncated},
  };
  for (const auto& [file, code] : cases) EXPECT_EQ(read(file).code(), code) << file;
}

TEST(PlyReader, RefusesANegativeListLength) {
  const auto reading = read(
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list int8 float l\nproperty uchar x\nproperty "
      "uchar y\nproperty uchar z\nend_header\n\xff"
      "abc");
  EXPECT_EQ(reading.code(), ErrorCode::kMalformed);
  EXPECT_THAT(reading.message(), HasSubstr("claims to have -1 items"));
}

}  // namespace
}  // namespace plumbline::testing
