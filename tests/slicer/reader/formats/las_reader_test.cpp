#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kLasPointBytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

struct LasPoint {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint8_t point_class = 1;
  bool withheld = false;
};

struct LasFile {
  std::uint8_t minor = 2;
  std::uint8_t format = 0;
  std::size_t extra = 0;    ///< bytes of a point beyond those of its format
  std::size_t records = 0;  ///< bytes between header and points
  double scale[3] = {0.001, 0.002, 0.5};
  double offset[3] = {100, -200, 0};
  std::vector<LasPoint> points;

  std::string bytes() const {
    const std::size_t head = minor >= 4 ? 375 : minor == 3 ? 235 : 227;
    const auto count = static_cast<std::uint32_t>(points.size());
    std::string out = "LASF" + std::string(20, '\0');
    out += little(std::uint8_t{1}, minor) + std::string(68, '\0');
    out += little(static_cast<std::uint16_t>(head), static_cast<std::uint32_t>(head + records), 0U, format,
                  static_cast<std::uint16_t>(kLasPointBytes[format & 15U] + extra), minor >= 4 ? 0U : count);
    out += std::string(20, '\0');
    for (const double s : scale) out += little(s);
    for (const double o : offset) out += little(o);
    out.resize(head, '\0');
    if (minor >= 4) out.replace(247, 8, little(std::uint64_t{count}));
    out += std::string(records, 'r');
    for (const LasPoint& p : points) {
      std::string record = little(p.x, p.y, p.z) + std::string(kLasPointBytes[format] + extra - 12, '\x7e');
      if (format >= 6) {
        record[15] = static_cast<char>(p.withheld ? 4 : 0);
        record[16] = static_cast<char>(p.point_class);
      } else {
        record[15] = static_cast<char>(p.point_class | (p.withheld ? 128U : 0U));
      }
      out += record;
    }
    return out;
  }
};

LasFile las_of_two_points() {
  LasFile file;
  file.points = {{1000, 2000, -3}, {-5, 0, 2147483647}};
  return file;
}

TEST(LasReader, ReadsEveryVersionAndPointFormat) {
  for (const auto minor : std::initializer_list<std::uint8_t>{0, 1, 2, 3, 4}) {
    for (std::uint8_t format = 0; format <= 10; ++format) {
      for (const std::size_t extra : {0U, 7U}) {
        LasFile file = las_of_two_points();
        file.minor = minor;
        file.format = format;
        file.extra = extra;
        file.records = extra * 100;
        auto reading = read(file.bytes(), "scan.las", {97});
        ASSERT_TRUE(reading.summary.has_value()) << reading.message();
        EXPECT_EQ(reading.summary->header.format, ScanFormat::kLas);
        EXPECT_EQ(reading.summary->header.declared_points, 2U);
        EXPECT_TRUE(same_points(reading.points(), {{1000 * 0.001 + 100, 2000 * 0.002 - 200, -1.5, 0, 0, 0},
                                                   {-5 * 0.001 + 100, -200, 2147483647 * 0.5, 0, 0, 0}}))
            << int{minor} << ' ' << int{format};
      }
    }
  }
}

TEST(LasReader, LeavesOutWithheldPointsAndNoise) {
  for (const auto format : std::initializer_list<std::uint8_t>{0, 3, 6, 8}) {
    LasFile file = las_of_two_points();
    file.format = format;
    file.points[1].withheld = true;
    file.points.push_back({7, 7, 7, 7, false});
    if (format >= 6) file.points.push_back({8, 8, 8, 18, false});
    const auto reading = read(file.bytes(), "scan.las");
    ASSERT_TRUE(reading.summary.has_value()) << reading.message();
    EXPECT_EQ(reading.summary->points, 1U);
    EXPECT_EQ(reading.summary->left_out, format >= 6 ? 3U : 2U);
  }
  LasFile nothing = las_of_two_points();
  for (auto& p : nothing.points) p.withheld = true;
  const auto reading = read(nothing.bytes(), "scan.las");
  EXPECT_EQ(reading.code(), ErrorCode::kNoPoints);
  EXPECT_THAT(reading.message(), HasSubstr("marked as invalid: 2"));
}

TEST(LasReader, RefusesLazAndSaysHowToExportIt) {
  LasFile file = las_of_two_points();
  auto bytes = file.bytes();
  bytes[104] = static_cast<char>(0x80);
  const auto reading = read(bytes, "scan.laz");
  EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
  EXPECT_THAT(reading.message(), HasSubstr("this is LAZ"));
  EXPECT_THAT(reading.message(), HasSubstr("laszip -i scan.laz -o scan.las"));
}

TEST(LasReader, NamesWhatIsWrongWithAHeader) {
  const auto whole = las_of_two_points().bytes();
  const auto with = [&](std::size_t at, const std::string& by) {
    auto bytes = whole;
    return read(bytes.replace(at, by.size(), by), "scan.las");
  };
  EXPECT_THAT(with(24, "\2").message(), HasSubstr("LAS 2.2 is not supported"));
  EXPECT_THAT(with(25, "\5").message(), HasSubstr("LAS 1.5 is not supported"));
  EXPECT_THAT(with(104, "\x0b").message(), HasSubstr("point format 11"));
  EXPECT_THAT(with(105, little(std::uint16_t{19})).message(),
              HasSubstr("points of 19 bytes, but format 0 has at least 20"));
  EXPECT_THAT(with(96, little(std::uint32_t{226})).message(), HasSubstr("points at byte 226"));
  EXPECT_THAT(with(94, little(std::uint16_t{100})).message(), HasSubstr("a header of 100 bytes"));
  EXPECT_THAT(with(139, little(0.0)).message(), HasSubstr("the scale 0 or the offset -200 of y is not usable"));
  EXPECT_THAT(with(155, little(std::numeric_limits<double>::infinity())).message(), HasSubstr("the offset inf of x"));
}

TEST(LasReader, FewerPointsThanDeclaredAreTruncated) {
  LasFile file = las_of_two_points();
  for (const auto minor : std::initializer_list<std::uint8_t>{2, 4}) {
    file.minor = minor;
    const auto bytes = file.bytes();
    const auto reading = read(std::string_view(bytes).substr(0, bytes.size() - 1), "scan.las");
    EXPECT_EQ(reading.code(), ErrorCode::kTruncated);
    EXPECT_THAT(reading.message(), HasSubstr("with 1 of the 2 points"));
    auto more = bytes;
    more.replace(minor == 4 ? 247 : 107, 4, little(0xffffffffU));
    EXPECT_THAT(read(more, "scan.las").message(), HasSubstr("with 2 of the 4294967295 points"));
    EXPECT_EQ(read(std::string_view(bytes).substr(0, 226), "scan.las").code(), ErrorCode::kTruncated);
  }
}

TEST(LasReader, MorePointsThanDeclaredAreRefused) {
  LasFile file = las_of_two_points();
  for (const auto minor : std::initializer_list<std::uint8_t>{0, 2, 3, 4}) {
    file.minor = minor;
    const auto bytes = file.bytes();
    EXPECT_TRUE(read(bytes + std::string(19, 'x'), "scan.las").summary);
    EXPECT_TRUE(read(bytes + std::string(512, '\0'), "scan.las").summary);
    const auto reading = read(bytes + std::string(41, 'x'), "scan.las");
    EXPECT_EQ(reading.code(), ErrorCode::kMalformed);
    EXPECT_THAT(reading.message(),
                HasSubstr("scan.las: its header declares 2 points, but 41 bytes follow them, enough for 2 more"));
  }
}

TEST(LasReader, WaveformsAndRecordsBehindThePointsAreNoPoints) {
  LasFile file = las_of_two_points();
  const auto with = [&](std::size_t at, std::size_t gap, unsigned records) {
    auto bytes = file.bytes();
    const auto behind = std::uint64_t{bytes.size() + gap};
    bytes.replace(at, 8, little(behind));
    if (file.minor == 4) bytes.replace(243, 4, little(records));
    return read(bytes + std::string(gap, 'g') + std::string(200, 'x'), "scan.las");
  };
  file.minor = 3;
  EXPECT_TRUE(with(227, 0, 0).summary);
  EXPECT_EQ(with(227, 40, 0).code(), ErrorCode::kMalformed) << "points lie before the waveforms";
  file.minor = 4;
  EXPECT_TRUE(with(227, 0, 0).summary);
  EXPECT_TRUE(with(235, 0, 1).summary);
  EXPECT_EQ(with(235, 0, 0).code(), ErrorCode::kMalformed) << "there are no records";
}

}  // namespace
}  // namespace plumbline::testing
