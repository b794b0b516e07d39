/// Scans whose format fixes their unit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "slicer/inspect.hpp"
#include "tests/slicer/reader/formats/e57_file.hpp"
#include "tests/slicer/support/meshes.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;

/// A ball of 20 mm, in metres as the standard has it.
std::string e57_ball(double radius_mm = 10) {
  std::array<std::vector<float>, 6> values;
  for (const SurfacePoint& p : sphere(8000, radius_mm, {0, 0, 0})) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      values[axis].push_back(static_cast<float>(p.position[static_cast<int>(axis)] / 1000));
      values[3 + axis].push_back(static_cast<float>(p.normal[static_cast<int>(axis)]));
    }
  }
  constexpr std::array kNames = {"cartesianX", "cartesianY", "cartesianZ", "nor:normalX", "nor:normalY", "nor:normalZ"};
  std::vector<E57Column> columns;
  for (std::size_t i = 0; i < kNames.size(); ++i) columns.push_back(float_column(kNames[i], values[i]));
  return E57File().bytes({{.columns = columns, .packet = 20'000}});
}

SliceSettings settings_with_units(Units units) {
  SliceSettings settings = settings_with_pitch(0.2F);
  settings.placement.units = units;
  return settings;
}

class MeteredSource final : public ByteSource {
 public:
  MeteredSource(std::string_view content, std::string name) : source_(content, std::move(name)) {}
  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    auto got = source_.read(buffer);
    bytes += got.value_or(0);
    return got;
  }
  Status rewind() override { return source_.rewind(); }
  std::string_view name() const override { return source_.name(); }
  std::optional<std::uint64_t> size() const override { return source_.size(); }
  std::size_t bytes = 0;

 private:
  MemorySource source_;
};

constexpr std::array kAllUnits = {Units::kMillimetres, Units::kCentimetres, Units::kMetres, Units::kInches,
                                  Units::kAuto};

TEST(FixedUnits, AnE57IsPrintedAtItsSizeWhateverUnitIsAskedFor) {
  const std::string scan = e57_ball();
  for (const Units units : kAllUnits) {
    SliceSettings settings = settings_with_units(units);
    settings.placement.printer = PrinterVolume{300, 300, 0.2F, 0.2F, 100};
    const Slicing sliced(MemorySource(scan, "ball.e57"), settings, 64 * kMiB);
    const SliceReport& report = sliced.report();
    EXPECT_NEAR(report.placement.size_mm.maxCoeff(), 20, 0.1) << to_string(units);
    EXPECT_NEAR(sliced.volume(), 4189, 84) << to_string(units);
    EXPECT_EQ(report.units, Units::kMillimetres);
    EXPECT_FALSE(report.units_guessed);
    const bool differs = units == Units::kCentimetres || units == Units::kInches;
    EXPECT_EQ(report.ignored_units, differs ? std::optional(units) : std::nullopt);
  }
}

TEST(FixedUnits, InspectAgrees) {
  const std::string scan = e57_ball();
  for (const Units units : kAllUnits) {
    MemorySource source(scan, "ball.e57");
    ByteSource* const sources[] = {&source};
    ArenaBlock arena(64 * kMiB);
    InspectReport report;
    ASSERT_TRUE(inspect(sources, settings_with_units(units), *arena, nullptr, report, kNoLook));
    EXPECT_EQ(report.units, Units::kMillimetres);
    ASSERT_TRUE(report.placement.has_value());
    EXPECT_NEAR(report.placement->size_mm.maxCoeff(), 20, 0.1) << to_string(units);
  }
}

TEST(FixedUnits, NoSizeIsGuessedAndNoUnitAdvisedForASpeck) {
  const std::string scan = e57_ball(0.2);  // 0.4 long, which a guess would take for metres
  MemorySource source(scan, "speck.e57");
  ArenaBlock arena(64 * kMiB);
  SliceReport report;
  const auto sliced = slice(source, settings_with_units(Units::kAuto), *arena, nullptr, report);
  ASSERT_FALSE(sliced);
  EXPECT_THAT(sliced.error().message(), HasSubstr("0.38 mm long"));
  EXPECT_THAT(sliced.error().advice(), HasSubstr("a scale"));
}

TEST(FixedUnits, OthersInOneFrameMustBeInMillimetresToo) {
  const std::string e57 = e57_ball(), ply = binary_ply(sphere(8000, 10, {0, 0, 0}));
  for (const Units units : {Units::kMetres, Units::kMillimetres}) {
    MemorySource first(ply, "a.ply"), second(e57, "b.e57");
    ByteSource* const sources[] = {&first, &second};
    ArenaBlock arena(64 * kMiB);
    SliceReport report;
    const auto sliced = slice(sources, settings_with_units(units), *arena, nullptr, report);
    ASSERT_EQ(sliced.has_value(), units == Units::kMillimetres);
    if (sliced) continue;
    EXPECT_EQ(sliced.error().code(), ErrorCode::kBadSetting);
    EXPECT_THAT(sliced.error().message(), HasSubstr("a.ply and 1 more: the E57 and 3MF files are in mm"));
  }
}

TEST(FixedUnits, AMixOfUnitsIsRefusedBeforeAnyPointIsRead) {
  const std::string e57 = e57_ball(), ply = binary_ply(sphere(400'000, 10, {0, 0, 0}));
  for (const bool e57_first : {false, true}) {
    MeteredSource scan(ply, "a.ply"), fixed(e57, "b.e57");
    ByteSource* const sources[] = {e57_first ? &fixed : &scan, e57_first ? &scan : &fixed};
    ArenaBlock arena(64 * kMiB);
    SliceReport report;
    const auto sliced = slice(sources, settings_with_units(Units::kInches), *arena, nullptr, report);
    ASSERT_FALSE(sliced);
    EXPECT_THAT(sliced.error().message(), HasSubstr("the E57 and 3MF files are in mm"));
    EXPECT_LT(scan.bytes, ply.size() / 10);
  }
}

TEST(FixedUnits, AMixOfUnitsOfMeshesIsRefusedBeforeAnyTriangleIsRead) {
  const TestMesh ball = ball_mesh({0, 0, 5}, 5, 5);
  const std::string stl = binary_stl(ball), threemf = threemf_of(ball);
  for (const bool threemf_first : {false, true}) {
    MeteredSource any(stl, "a.stl"), fixed(threemf, "b.3mf");
    ByteSource* const sources[] = {threemf_first ? &fixed : &any, threemf_first ? &any : &fixed};
    ArenaBlock arena(64 * kMiB);
    SliceReport report;
    const auto sliced = slice(sources, settings_with_units(Units::kInches), *arena, nullptr, report);
    ASSERT_FALSE(sliced);
    EXPECT_THAT(sliced.error().message(), HasSubstr("the E57 and 3MF files are in mm"));
    EXPECT_LT(any.bytes, stl.size() / 4);
  }
}

}  // namespace
}  // namespace plumbline
