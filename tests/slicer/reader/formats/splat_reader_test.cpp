#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/support/splat_files.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;

/// Eight on a plane that faces n, and what is to be left out.
std::vector<Splat> some_splats(const Vec3d& n) {
  std::vector<Splat> splats;
  for (int i = 0; i < 8; ++i) splats.push_back({.position = {i * 0.5, i * 0.25, -1.0}, .turn = turn_from_z(n)});
  splats.push_back({.position = {9, 9, 9}, .opacity = 0.2});               // transparent
  splats.push_back({.position = {8, 8, 8}, .radius = {0.1, 5, 0.1}});      // 50 times as large as the others
  splats.push_back({.position = {7, 7, 7}, .radius = {0.1, 0.09, 0.08}});  // round: no normal
  splats.push_back({.position = {6, 6, 6}, .radius = {0.001, 0.1, 0.1}, .turn = {1, 0, 0, 0}});  // flat along x
  return splats;
}

struct SplatCase {
  const char* name;
  std::string bytes;
  double place;   ///< error of a coordinate
  double normal;  ///< error of a component
};
std::vector<SplatCase> splat_cases(const std::vector<Splat>& splats) {
  return {{"binary.ply", splat_ply(splats), 1e-6, 1e-6},
          {"ascii.ply", splat_ply(splats, true), 1e-5, 1e-5},
          {"one.spz", gzip(plain_spz(splats, 1)), 1e-6, 0.03},
          {"two.spz", gzip(plain_spz(splats, 2)), 2e-4, 0.03},
          {"three.spz", gzip(plain_spz(splats, 3)), 2e-4, 0.006}};
}

TEST(SplatReader, KeepsOpaqueSplatsOfUsualSizeWithTheirShortestAxis) {
  for (const Vec3d& n : {Vec3d(0, 0, 1), Vec3d(0.6, 0, 0.8), Vec3d(0, -0.8, -0.6), Vec3d(2.0 / 3, 1.0 / 3, -2.0 / 3)}) {
    const auto splats = some_splats(n);
    for (const SplatCase& file : splat_cases(splats)) {
      for (const auto& pieces : std::vector<std::vector<std::size_t>>{{}, {7}}) {
        const auto reading = read(file.bytes, file.name, pieces);
        ASSERT_TRUE(reading.summary.has_value()) << reading.message();
        EXPECT_EQ(reading.sink.complaint, "");
        EXPECT_TRUE(reading.summary->header.has_normals && reading.summary->header.has_unsigned_normals);
        EXPECT_EQ(reading.summary->left_out, 2U) << file.name;
        EXPECT_EQ(reading.summary->without_normal, 1U) << file.name;
        ASSERT_EQ(reading.summary->points, 10U) << file.name;
        for (std::size_t i = 0; i < 8; ++i) {
          const ScanPoint& p = reading.sink.points[i];
          EXPECT_NEAR(p.x, splats[i].position[0], file.place) << file.name;
          EXPECT_NEAR(p.y, splats[i].position[1], file.place);
          EXPECT_NEAR(p.z, splats[i].position[2], file.place);
          const Vec3d found(p.nx, p.ny, p.nz);
          EXPECT_LT(std::min((found - n).norm(), (found + n).norm()), 2 * file.normal)
              << file.name << found.transpose();
        }
        EXPECT_NEAR(std::abs(reading.sink.points[9].nx), 1, file.normal) << file.name;
      }
    }
  }
}

TEST(SplatReader, ReadsProgressOnceAndAllBytes) {
  std::vector<Splat> splats(5000);
  const auto bytes = splat_ply(splats);
  const auto reading = read(bytes, "splats.ply");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->points, 5000U);
  EXPECT_EQ(reading.summary->bytes, bytes.size());
  EXPECT_TRUE(std::is_sorted(reading.sink.fractions.begin(), reading.sink.fractions.end()));
  MemorySource pipe(bytes, "splats.ply");
  pipe.be_a_pipe();
  EXPECT_THAT(read(pipe).message(), HasSubstr("splats are read twice, and these come through a pipe"));
}

TEST(SplatReader, SplatsOfTwoDimensionsFaceAlongTheirThirdAxis) {
  const Vec3d n(0.6, 0, 0.8);
  auto splats = some_splats(n);
  splats.erase(splats.begin() + 10, splats.end());  // of the others the third radius matters
  for (const bool ascii : {false, true}) {
    const auto reading = read(replaced(splat_ply(splats, ascii), "scale_2", "other"), "discs.ply");
    ASSERT_TRUE(reading.summary.has_value()) << reading.message();
    EXPECT_TRUE(reading.summary->header.has_unsigned_normals);
    EXPECT_EQ(reading.summary->left_out, 2U) << "a transparent and a large one";
    ASSERT_EQ(reading.summary->points, 8U);
    for (const ScanPoint& p : reading.sink.points) {
      const Vec3d found(p.nx, p.ny, p.nz);
      EXPECT_LT(std::min((found - n).norm(), (found + n).norm()), 1e-5);
    }
  }
}

TEST(SplatReader, ReadsTheMembersOfAGzipOneAfterAnother) {
  const auto splats = some_splats({0, 0, 1});
  const auto plain = plain_spz(splats, 3);
  const auto whole = read(gzip(plain), "a.spz");
  const auto parts = read(gzip(plain.substr(0, 90)) + gzip(plain.substr(90)), "a.spz");
  ASSERT_TRUE(parts.summary.has_value()) << parts.message();
  EXPECT_EQ(parts.summary->points, whole.summary->points);
  EXPECT_EQ(parts.sink.points.back().x, whole.sink.points.back().x);
  EXPECT_TRUE(read(gzip(plain) + "padding", "a.spz").summary.has_value());
}

TEST(SplatReader, OnlySomePropertiesOfASplatMakeAPlainScan) {
  const auto bytes = replaced(splat_ply({{}, {}}), "scale_1", "other");
  const auto reading = read(bytes, "scan.ply");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_FALSE(reading.summary->header.has_unsigned_normals);
  EXPECT_EQ(reading.summary->left_out, 0U);
}

TEST(SplatReader, NamesTheCompressedPlyOfSuperSplat) {
  const auto reading = read(
      "ply\nformat binary_little_endian 1.0\nelement chunk 1\nproperty float min_x\nelement vertex 1\nproperty uint "
      "packed_position\nproperty uint packed_rotation\nend_header\n12345678abcd",
      "splats.ply");
  EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
  EXPECT_THAT(reading.message(), HasSubstr("Gaussian splats in a compressed PLY"));
}

TEST(SplatReader, SaysWhatIsWrongWithAnSpz) {
  const auto plain = plain_spz(some_splats({0, 0, 1}), 3);
  const auto with = [&](std::size_t at, const std::string& by) {
    auto changed = plain;
    return read(gzip(changed.replace(at, by.size(), by)), "a.spz");
  };
  EXPECT_THAT(with(0, "N").message(), ::testing::Not(HasSubstr("gzip")));
  EXPECT_THAT(with(0, "X").message(), HasSubstr("a.spz: this is a gzip archive; unpack it"));
  EXPECT_EQ(with(0, "X").code(), ErrorCode::kUnknownFormat);
  EXPECT_THAT(with(4, little(0U)).message(), HasSubstr("SPZ of version 0 is not supported"));
  EXPECT_THAT(with(8, little(0U)).message(), HasSubstr("no splats"));
  EXPECT_THAT(with(8, little(~0U)).message(), HasSubstr("can't hold the 4294967295 splats"));
  EXPECT_THAT(with(8, little(200U)).message(), HasSubstr("too short for the 200 splats"));
  EXPECT_THAT(with(8, little(6U)).message(), HasSubstr("declares 6 splats, but the data has more"));
  EXPECT_THAT(with(12, little(std::uint8_t{5})).message(), HasSubstr("colours of degree 5"));
  EXPECT_EQ(with(12, little(std::uint8_t{3})).code(), ErrorCode::kTruncated);
  EXPECT_THAT(with(13, little(std::uint8_t{25})).message(), HasSubstr("25 after the point"));
  EXPECT_THAT(read("NGSP\4\0\0\0 and more", "a.spz").message(), HasSubstr("SPZ of version 4 or later"));
  auto damaged = gzip(plain);
  EXPECT_EQ(read(std::string_view(damaged).substr(0, damaged.size() / 2), "a.spz").code(), ErrorCode::kTruncated);
  damaged[damaged.size() / 3] = static_cast<char>(damaged[damaged.size() / 3] ^ 0x55);
  EXPECT_FALSE(read(damaged, "a.spz").summary.has_value());
}

TEST(SplatReader, ABombEndsAtThePlanForItsColumns) {
  // 2 million splats of zeros are 62 MB, and 60 KB of gzip.
  const std::string plain = "NGSP" + little(3U, 2'000'000U, std::uint8_t{0}, std::uint8_t{12}, std::uint16_t{0}) +
                            std::string(40'000'000, '\0');
  const auto bytes = gzip(plain);
  EXPECT_LT(bytes.size(), 100'000U);
  const auto reading = read(bytes, "bomb.spz");
  EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
  EXPECT_THAT(reading.message(), HasSubstr("keeping those of 2000000 splats takes 26000192 bytes"));
  EXPECT_EQ(reading.sink.header.reader_bytes, 26'000'192U) << "the plan is told before";
}

}  // namespace
}  // namespace plumbline::testing
