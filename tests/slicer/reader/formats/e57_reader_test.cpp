#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/slicer/reader/formats/e57_file.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;

const std::vector<float> kMetresX = {0.001F, -0.5F, 2.25F, 0};
const std::vector<float> kMetresY = {0.25F, 1.5F, -8, 0.125F};
const std::vector<float> kMetresZ = {-1, 0, 0.75F, 64};

std::vector<E57Column> float_columns() {
  return {float_column("cartesianX", kMetresX), float_column("cartesianY", kMetresY),
          float_column("cartesianZ", kMetresZ)};
}

std::vector<ScanPoint> e57_points() {
  std::vector<ScanPoint> points;
  for (std::size_t i = 0; i < kMetresX.size(); ++i) {
    points.push_back({static_cast<double>(kMetresX[i]) * 1000, static_cast<double>(kMetresY[i]) * 1000,
                      static_cast<double>(kMetresZ[i]) * 1000, 0, 0, 0});
  }
  return points;
}

Reading read_e57_of(const std::vector<E57TestScan>& scans) { return read(E57File().bytes(scans), "scan.e57", {1000}); }

void expect_near_points(const Reading& reading, const std::vector<ScanPoint>& wanted) {
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  ASSERT_EQ(reading.sink.points.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const ScanPoint& p = reading.sink.points[i];
    EXPECT_NEAR(p.x, wanted[i].x, 1e-9) << i;
    EXPECT_NEAR(p.y, wanted[i].y, 1e-9) << i;
    EXPECT_NEAR(p.z, wanted[i].z, 1e-9) << i;
    EXPECT_NEAR(p.nx, wanted[i].nx, 1e-6) << i;
    EXPECT_NEAR(p.ny, wanted[i].ny, 1e-6) << i;
    EXPECT_NEAR(p.nz, wanted[i].nz, 1e-6) << i;
  }
}

TEST(E57Reader, ReadsFloatsInMillimetres) {
  auto reading = read_e57_of({{.columns = float_columns()}});
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->header.format, ScanFormat::kE57);
  EXPECT_EQ(reading.summary->header.declared_points, 4U);
  EXPECT_FALSE(reading.summary->header.has_normals);
  EXPECT_TRUE(same_points(reading.points(), e57_points()));
}

TEST(E57Reader, ReadsDoublesAndIntegersOfAnyBitsWhateverTheirPackets) {
  for (const int bits : {1, 2, 3, 7, 8, 9, 13, 16, 17, 31, 32, 33, 48, 57, 63}) {
    const std::int64_t span = static_cast<std::int64_t>((std::uint64_t{1} << bits) - 1);
    std::vector<double> x;
    std::vector<std::int64_t> y, z;
    std::vector<ScanPoint> wanted;
    for (std::int64_t i = 0; i < 500; ++i) {
      x.push_back(static_cast<double>(i) / 4);
      y.push_back(-3 + static_cast<std::int64_t>(static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15U >> (64 - bits)));
      z.push_back(i % 2 == 0 ? 5 : 5 + span / 3);
      wanted.push_back({x.back() * 1000, static_cast<double>(y.back()) * 1000,
                        (static_cast<double>(z.back()) * 0.25 + 100) * 1000, 0, 0, 0});
    }
    const std::vector<E57Column> columns = {
        double_column("cartesianX", x),
        integer_column("intensity", "Integer", 0, 255, std::vector<std::int64_t>(500, 77)),
        integer_column("cartesianY", "Integer", -3, span - 3, y),
        integer_column("cartesianZ", "ScaledInteger", 5, span > 16 ? span : 5 + span, z,
                       R"(scale="0.25" offset="1e2")")};
    for (const std::size_t packet : {64U, 200U, 4000U, 100'000U}) {
      for (const std::size_t uneven : {0U, 400U}) {
        if (packet * 4 / 8 > 60'000) continue;
        auto reading = read_e57_of({{.columns = columns, .packet = packet, .uneven = uneven}});
        ASSERT_TRUE(reading.summary.has_value()) << bits << ' ' << packet << ": " << reading.message();
        EXPECT_TRUE(same_points(reading.points(), wanted)) << bits << ' ' << packet << ' ' << uneven;
      }
    }
  }
}

TEST(E57Reader, AFieldOfOneValueTakesNoBits) {
  auto columns = float_columns();
  columns[1] = integer_column("cartesianY", "ScaledInteger", 7, 7, {7, 7, 7, 7}, R"(scale="0.5")");
  ASSERT_EQ(columns[1].bits, 0);
  auto wanted = e57_points();
  for (auto& p : wanted) p.y = 3500;
  auto reading = read_e57_of({{.columns = columns}});
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_TRUE(same_points(reading.points(), wanted));
  for (std::size_t c : {0U, 2U}) columns[c] = integer_column(columns[c].name, "Integer", 1, 1, {1, 1, 1, 1});
  EXPECT_THAT(read_e57_of({{.columns = columns}}).message(), HasSubstr("all points of a scan are at one place"));
}

TEST(E57Reader, RefusesPointsThatAreNotBitPacked) {
  const auto read_with = [](const std::string& codec) {
    E57File file;
    file.change_xml = [&](const std::string& xml) {
      return replaced(xml, "Children=\"1\"></codecs>", "Children=\"1\">" + codec + "</codecs>");
    };
    return read(file.bytes({{.columns = float_columns()}}), "scan.e57", {1000});
  };
  const std::string inputs = "<inputs type=\"Vector\"><vectorChild type=\"String\">cartesianX</vectorChild></inputs>";
  auto packed =
      read_with("<vectorChild type=\"Structure\">" + inputs + "<bitPackCodec type=\"Structure\"/></vectorChild>");
  ASSERT_TRUE(packed.summary.has_value()) << packed.message();
  EXPECT_TRUE(same_points(packed.points(), e57_points()));
  EXPECT_THAT(
      read_with("<vectorChild type=\"Structure\">" + inputs + "<x:zstd type=\"Structure\"/></vectorChild>").message(),
      HasSubstr("of its XML: points packed by 'x:zstd'; only 'bitPackCodec' is read"));
}

TEST(E57Reader, MovesEachScanByItsPose) {
  // A quarter turn about z; the length of the quaternion does not matter, and zeros may be left out.
  const std::string turned =
      "<rotation type=\"Structure\"><w type=\"Float\"> 2.0\n</w><x type=\"Float\"/><z>2</z></rotation>"
      "<translation type=\"Structure\"><x type=\"Float\">1e0</x><y>-2</y></translation>";
  auto columns = float_columns();
  columns.push_back(float_column("nor:normalX", {1, 0, 0, 0}));
  columns.push_back(float_column("nor:normalY", {0, 1, 0, 0}));
  columns.push_back(float_column("nor:normalZ", {0, 0, 1, 0}));
  const auto reading = read_e57_of({{.columns = float_columns()}, {.columns = columns, .pose = turned}});
  std::vector<ScanPoint> wanted = e57_points();
  for (std::size_t i = 0; i < 4; ++i) {
    const ScanPoint p = wanted[i];
    wanted.push_back({1000 - p.y, -2000 + p.x, p.z, i == 1 ? -1.0F : 0.0F, i == 0 ? 1.0F : 0.0F, i == 2 ? 1.0F : 0.0F});
  }
  expect_near_points(reading, wanted);
  EXPECT_TRUE(reading.summary->header.has_normals);
  EXPECT_EQ(reading.summary->without_normal, 5U);
  EXPECT_EQ(reading.summary->header.declared_points, 8U);
}

TEST(E57Reader, BeginsAViewWithEachScan) {
  const std::string moved = "<translation><x>1</x><z>-2.5</z></translation>";
  const std::string idle = "<rotation><w>1</w></rotation><translation><x>0</x></translation>";
  const auto views_of = [](const std::vector<E57TestScan>& scans) {
    const auto reading = read_e57_of(scans);
    EXPECT_TRUE(reading.summary.has_value()) << reading.message();
    EXPECT_EQ(reading.sink.complaint, "");
    return reading.sink.views;
  };
  auto structured = float_columns();
  structured.push_back(integer_column("rowIndex", "Integer", 0, 3, {0, 1, 2, 3}));
  using Views = std::vector<BegunView>;
  EXPECT_EQ(views_of({{.columns = float_columns()}}), Views{});
  EXPECT_EQ(views_of({{.columns = float_columns(), .pose = idle}}), Views{}) << "of a merged cloud";
  EXPECT_EQ(views_of({{.columns = float_columns()}, {.columns = float_columns(), .pose = idle}}),
            (Views{{0, std::nullopt}, {4, std::nullopt}}));
  EXPECT_EQ(views_of({{.columns = float_columns()}, {.columns = float_columns(), .pose = moved}}),
            (Views{{0, Vec3d(0, 0, 0)}, {4, Vec3d(1000, 0, -2500)}}));
  EXPECT_EQ(views_of({{.columns = structured}}), (Views{{0, Vec3d(0, 0, 0)}}));
}

TEST(E57Reader, ReadsSphericalCoordinatesAndLeavesOutInvalidPoints) {
  const std::vector<double> range = {2, 3, 0.5, 9, 1};
  const std::vector<double> azimuth = {0, 3.14159265358979323846 / 2, -2.5, 1, 1e9};
  const std::vector<double> elevation = {0, 3.14159265358979323846 / 6, -1.25, 1, 0};
  std::vector<E57Column> columns = {double_column("sphericalAzimuth", azimuth),
                                    double_column("sphericalElevation", elevation),
                                    double_column("sphericalRange", range),
                                    integer_column("sphericalInvalidState", "Integer", 0, 2, {0, 0, 0, 2, 0})};
  const auto reading = read_e57_of({{.columns = columns}});
  std::vector<ScanPoint> wanted;
  for (std::size_t i = 0; i < 3; ++i) {
    wanted.push_back({1000 * range[i] * std::cos(elevation[i]) * std::cos(azimuth[i]),
                      1000 * range[i] * std::cos(elevation[i]) * std::sin(azimuth[i]),
                      1000 * range[i] * std::sin(elevation[i]), 0, 0, 0});
  }
  expect_near_points(reading, wanted);
  EXPECT_EQ(reading.summary->left_out, 1U);
  EXPECT_EQ(reading.summary->not_finite, 1U) << "an angle of 1e9";
  auto cartesian = float_columns();
  cartesian.push_back(integer_column("cartesianInvalidState", "Integer", 0, 2, {0, 1, 2, 0}));
  EXPECT_EQ(read_e57_of({{.columns = cartesian}}).summary->left_out, 2U);
}

TEST(E57Reader, ManyPointsFillManyPagesAndPackets) {
  constexpr std::size_t kCount = 60'000;
  std::vector<float> x(kCount), y(kCount), z(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    x[i] = static_cast<float>(i);
    y[i] = static_cast<float>(i % 7);
    z[i] = -1;
  }
  const std::vector<E57Column> columns = {
      float_column("cartesianX", x), float_column("cartesianY", y), float_column("cartesianZ", z),
      integer_column("colorRed", "Integer", 0, 255, std::vector<std::int64_t>(kCount, 3))};
  const auto reading = read_e57_of({{.columns = columns, .packet = 21'000 * 8 / 2, .uneven = 4000}});
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  ASSERT_EQ(reading.summary->points, kCount);
  for (std::size_t i = 0; i < kCount; ++i) ASSERT_EQ(reading.sink.points[i].x, static_cast<double>(i) * 1000);
  EXPECT_TRUE(std::is_sorted(reading.sink.fractions.begin(), reading.sink.fractions.end()));
  EXPECT_EQ(reading.sink.fractions.back(), 1.0);
}

TEST(E57Reader, FindsAWrongChecksum) {
  auto bytes = E57File().bytes({{.columns = float_columns()}});
  for (const std::size_t at : {std::size_t{100}, std::size_t{1022}, bytes.size() - 1}) {
    auto wrong = bytes;
    wrong[at] = static_cast<char>(wrong[at] ^ 4);
    const auto reading = read(wrong, "scan.e57");
    EXPECT_EQ(reading.code(), ErrorCode::kMalformed) << at;
    EXPECT_THAT(reading.message(),
                HasSubstr("byte " + std::to_string(at / 1024 * 1024) + ": the checksum of this page"));
  }
}

TEST(E57Reader, ChecksTheHeader) {
  const auto payload = E57File::unpaged(E57File().bytes({{.columns = float_columns()}}));
  const auto with = [&](std::size_t at, const std::string& by) {
    auto changed = payload;
    return read(E57File::paged(changed.replace(at, by.size(), by)), "scan.e57");
  };
  EXPECT_THAT(with(8, little(2U)).message(), HasSubstr("version 2 of E57"));
  EXPECT_THAT(with(40, little(std::uint64_t{512})).message(), HasSubstr("pages of 512 bytes instead of 1024"));
  EXPECT_THAT(with(24, little(std::uint64_t{1021})).message(), HasSubstr("XML section of"));
  EXPECT_THAT(with(24, little(std::uint64_t{1} << 40)).message(), HasSubstr("refers to byte 1099511627776"));
  EXPECT_THAT(with(32, little(std::uint64_t{1} << 40)).message(),
              HasSubstr("an XML section of 1099511627776 bytes; at most"));
  EXPECT_EQ(with(32, little(std::uint64_t{100'000})).code(), ErrorCode::kMalformed) << "zeros after the XML";
  EXPECT_EQ(read(std::string_view(E57File::paged(payload)).substr(0, 1000), "scan.e57").code(), ErrorCode::kTruncated);
}

TEST(E57Reader, NamesWhatIsWrongWithTheXml) {
  const auto with = [&](const char* what, const char* by,
                        std::vector<E57TestScan> scans = {{.columns = float_columns()}}) {
    E57File file;
    file.change_xml = [&](const std::string& xml) {
      EXPECT_NE(xml.find(what), std::string::npos) << what;
      return replaced(xml, what, by);
    };
    return read(file.bytes(scans), "scan.e57").message();
  };
  EXPECT_THAT(with("</data3D>", "</data4D>"), HasSubstr("mismatched tag"));
  EXPECT_THAT(with("<e57Root", "<!DOCTYPE a [<!ENTITY b \"c\">]><e57Root"), HasSubstr("a document type"));
  EXPECT_THAT(with("recordCount=\"4\"", "recordCount=\"-4\""),
              HasSubstr("without a usable fileOffset and recordCount"));
  EXPECT_THAT(with("cartesianZ", "cartesianW"), HasSubstr("no points with coordinates"));
  EXPECT_THAT(with("Float", "String"), HasSubstr("'cartesianX' is of type 'String'"));
  EXPECT_THAT(with("<points", std::string("<a " + std::string(400'000, 'b') + "='c'/><points").c_str()),
              HasSubstr("tags too long"));
  const E57TestScan posed{.columns = float_columns(), .pose = "<rotation><w>1</w></rotation>"};
  EXPECT_THAT(with("<w>1</w>", "<w>0</w>", {posed}), HasSubstr("a rotation of length 0"));
  EXPECT_THAT(with("<w>1</w>", "<w>one</w>", {posed}), HasSubstr("'one' is not a number of a pose"));
  const E57TestScan ranged{.columns = {integer_column("cartesianX", "Integer", 0, 9, {1}),
                                       integer_column("cartesianY", "Integer", 0, 9, {1}),
                                       integer_column("cartesianZ", "Integer", 0, 9, {1})}};
  EXPECT_THAT(with("maximum=\"9\"", "maximum=\"-1\"", {ranged}),
              HasSubstr("'cartesianX' has no usable range or scale"));
  const E57TestScan scaled{.columns = {integer_column("cartesianX", "ScaledInteger", 0, 9, {1}, "scale=\"0.001\""),
                                       integer_column("cartesianY", "ScaledInteger", 0, 9, {1}),
                                       integer_column("cartesianZ", "ScaledInteger", 0, 9, {1})}};
  EXPECT_THAT(with("scale=\"0.001\"", "scale=\"0\"", {scaled}), HasSubstr("'cartesianX' has no usable range or scale"));
}

TEST(E57Reader, FewerPointsThanDeclaredAreTruncated) {
  const auto reading = read_e57_of({{.columns = float_columns(), .more = 3}});
  EXPECT_EQ(reading.code(), ErrorCode::kTruncated);
  EXPECT_THAT(reading.message(), HasSubstr("ends with 4 of the 7 points"));
  const auto twice = [] {
    E57File file;
    file.change_xml = [](const std::string& xml) {
      const auto at = xml.find("<vectorChild");
      const auto end = xml.find("</vectorChild>") + 14;
      return xml.substr(0, end) + xml.substr(at);
    };
    return read(file.bytes({{.columns = float_columns()}}), "scan.e57");
  }();
  EXPECT_EQ(twice.code(), ErrorCode::kMalformed);
  EXPECT_THAT(twice.message(), HasSubstr("within others"));
}

TEST(E57Reader, RefusesAStreamThatCanNotBeRewound) {
  const auto bytes = E57File().bytes({{.columns = float_columns()}});
  MemorySource source(bytes, "scan.e57");
  source.be_a_pipe();
  const auto reading = read(source);
  EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
  EXPECT_THAT(reading.message(), HasSubstr("scan.e57: an E57 is read twice, and this one comes through a pipe"));
}

}  // namespace
}  // namespace plumbline::testing
