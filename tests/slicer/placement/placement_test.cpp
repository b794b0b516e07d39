#include "slicer/placement/placement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <string>

#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline {
namespace {

using namespace testing;

Box3d box_of(const Vec3d& low, const Vec3d& high) {
  Box3d box;
  box.extend(low);
  box.extend(high);
  return box;
}

PlacementSettings on_a_printer() {
  PlacementSettings settings;
  settings.printer = PrinterVolume{1440, 2560, 0.05F, 0.05F, 150};
  return settings;
}

TEST(Placement, KnowsTheLengthOfEachUnit) {
  EXPECT_EQ(millimetres_per(Units::kMillimetres), 1);
  EXPECT_EQ(millimetres_per(Units::kCentimetres), 10);
  EXPECT_EQ(millimetres_per(Units::kMetres), 1000);
  EXPECT_EQ(millimetres_per(Units::kInches), 25.4);
}

TEST(Placement, GuessesTheUnitThatGivesAPrintableSize) {
  EXPECT_EQ(guess_units(80), Units::kMillimetres);
  EXPECT_EQ(guess_units(0.15), Units::kMetres);
  EXPECT_EQ(guess_units(7), Units::kCentimetres);
  EXPECT_EQ(guess_units(20), Units::kMillimetres) << "a ball of 20 mm is not one of 20 cm";
  EXPECT_EQ(guess_units(19.9997), Units::kMillimetres);
  EXPECT_EQ(guess_units(1.9997), Units::kCentimetres) << "the same ball in cm, not 51 mm in inches";
  EXPECT_EQ(guess_units(0.019998), Units::kMetres);
  EXPECT_EQ(guess_units(10), Units::kMillimetres);
  EXPECT_EQ(guess_units(1.5), Units::kInches) << "15 mm in cm, 1500 mm in m";
  EXPECT_EQ(guess_units(1e6), Units::kMillimetres);
  EXPECT_EQ(guess_units(0), Units::kMillimetres);
}

TEST(Placement, StandsInTheFirstLayerInsideAMarginWithoutAPrinter) {
  PlacementSettings settings;
  settings.pixel_pitch_mm = 0.1F;
  settings.layer_height_mm = 0.025F;
  settings.scale = 2;
  const Placement p = value_of(place(box_of({1, 2, 3}, {2, 4, 6}), 10, settings));
  EXPECT_EQ(p.scale, 20);
  EXPECT_TRUE(p.size_mm.isApprox(Vec3d(20, 40, 60)));
  const double margin_x = 0.5 * (p.grid.columns * 0.1 - 20);
  EXPECT_GT(margin_x, 0.1);
  EXPECT_LT(margin_x, 1);
  EXPECT_NEAR(p.grid.layers, 2400, 1);
  const Vec3d low = p.scale * Vec3d(1, 2, 3) + p.shift;
  const Vec3d high = p.scale * Vec3d(2, 4, 6) + p.shift;
  EXPECT_NEAR(low[2], 0, 0.025);
  EXPECT_GE(low[2], 0);
  EXPECT_NEAR(high[2], p.grid.layers * 0.025, 0.025);
  for (int a = 0; a < 2; ++a) {
    EXPECT_GT(low[a], 0.1);
    EXPECT_LT(high[a], (a == 0 ? p.grid.columns : p.grid.rows) * 0.1 - 0.1);
  }
}

TEST(Placement, MakesMasksLargerByWhatThePrintShrinks) {
  PlacementSettings settings = on_a_printer();
  settings.correct({1.02, 1.01, 1.05});
  const Placement p = value_of(place(box_of({0, 0, 0}, {30, 20, 40}), 1, settings));
  EXPECT_EQ(p.grid.columns, 1440U);
  EXPECT_TRUE(p.size_mm.isApprox(Vec3d(30, 20, 40)));
  EXPECT_NEAR(static_cast<double>(p.grid.pitch_x_mm), 0.05 / 1.02, 1e-8);
  EXPECT_NEAR(static_cast<double>(p.grid.pitch_y_mm), 0.05 / 1.01, 1e-8);
  EXPECT_EQ(p.grid.layers, 840U) << "40 mm that shrink from 42, in layers of 0.05";
  const PrintGrid machine = machine_grid(p.grid, settings.correction);
  EXPECT_NEAR(static_cast<double>(machine.pitch_x_mm), 0.05, 1e-8);
  EXPECT_NEAR(static_cast<double>(machine.layer_height_mm), 0.05, 1e-8);
  settings.fit = true;
  const Placement largest = value_of(place(box_of({0, 0, 0}, {1, 1, 30}), 1, settings));
  EXPECT_NEAR(largest.size_mm[2], 150 / 1.05, 0.1) << "the travel holds less than before";
}

TEST(Placement, IsNotChangedByACorrectionOfOne) {
  PlacementSettings settings = on_a_printer();
  settings.printer->pitch_x_mm = 0.04725F;
  const PlacementSettings before = settings;
  settings.correct(Vec3d::Ones());
  EXPECT_EQ(settings.printer->pitch_x_mm, before.printer->pitch_x_mm);
  EXPECT_EQ(settings.printer->travel_mm, before.printer->travel_mm);
  EXPECT_EQ(settings.layer_height_mm, before.layer_height_mm);
}

TEST(Placement, StandsInTheMiddleOfThePanelOnAPrinter) {
  const Placement p = value_of(place(box_of({-5, 10, 7}, {25, 30, 47}), 1, on_a_printer()));
  EXPECT_EQ(p.grid.columns, 1440U);
  EXPECT_EQ(p.grid.rows, 2560U);
  EXPECT_EQ(p.grid.layers, 800U);
  const Vec3d middle = p.scale * Vec3d(10, 20, 7) + p.shift;
  EXPECT_NEAR(middle[0], 36, 1e-5);
  EXPECT_NEAR(middle[1], 64, 1e-5);
  EXPECT_NEAR(middle[2], 0, 1e-9);
}

TEST(Placement, GivesTheSizeAskedForWhateverTheUnit) {
  for (const double unit_mm : {1.0, 10.0, 1000.0, 25.4}) {
    PlacementSettings settings;
    const Box3d box = box_of({-5, 10, 7}, {25, 30, 17});  // 30 x 20 x 10
    settings.size = PrintSize{Side::kWidth, 60};
    EXPECT_TRUE(value_of(place(box, unit_mm, settings)).size_mm.isApprox(Vec3d(60, 40, 20)));
    settings.size = PrintSize{Side::kDepth, 60};
    EXPECT_TRUE(value_of(place(box, unit_mm, settings)).size_mm.isApprox(Vec3d(90, 60, 30)));
    settings.size = PrintSize{Side::kHeight, 60};
    EXPECT_TRUE(value_of(place(box, unit_mm, settings)).size_mm.isApprox(Vec3d(180, 120, 60)));
    settings.size = PrintSize{Side::kLength, 15};
    EXPECT_TRUE(value_of(place(box, unit_mm, settings)).size_mm.isApprox(Vec3d(15, 10, 5)));
  }
}

TEST(Placement, SaysWhichSizeFits) {
  PlacementSettings settings = on_a_printer();
  settings.size = PrintSize{Side::kHeight, 100};
  const Box3d box = box_of({0, 0, 0}, {3, 2, 1});
  const auto refused = place(box, 1, settings);
  ASSERT_FALSE(refused.has_value());
  const std::string message = refused.error().message();
  const auto at = message.find("a height of ");
  ASSERT_NE(at, std::string::npos) << message;
  settings.size->mm = std::strtod(message.c_str() + at + 12, nullptr);
  EXPECT_TRUE(place(box, 1, settings).has_value()) << message;
  settings.size->mm *= 1.01;
  EXPECT_FALSE(place(box, 1, settings).has_value()) << message;
}

TEST(Placement, RefusesASizeAlongASideThatIsFlat) {
  PlacementSettings settings;
  settings.size = PrintSize{Side::kHeight, 10};
  EXPECT_FALSE(place(box_of({0, 0, 1}, {3, 2, 1}), 1, settings).has_value());
}

TEST(Placement, FitUsesTheLargestScaleThatFitsThePrinter) {
  for (const Vec3d& size :
       {Vec3d(1, 1, 1), Vec3d(0.01, 0.02, 0.03), Vec3d(300, 1, 1), Vec3d(1, 3000, 1), Vec3d(1, 1, 1e6)}) {
    PlacementSettings settings = on_a_printer();
    settings.fit = true;
    const Placement p = value_of(place(box_of({0, 0, 0}, size), 1, settings));
    // Five pixels of 0.05 mm on each side stay free, or the check for the panel's edge would object.
    const double fullest = std::max({p.size_mm[0] / 71.5, p.size_mm[1] / 127.5, p.size_mm[2] / 150});
    EXPECT_LE(fullest, 1);
    EXPECT_GT(fullest, 0.995);
    settings.fit = false;
    settings.scale = p.scale;
    EXPECT_TRUE(place(box_of({0, 0, 0}, size), 1, settings).has_value());
    settings.scale = p.scale * 1.01;
    EXPECT_FALSE(place(box_of({0, 0, 0}, size), 1, settings).has_value());
  }
}

TEST(Placement, FitKeepsRoomForSupports) {
  PlacementSettings settings = on_a_printer();
  settings.fit = true;
  settings.room = {.beside_mm = 5, .below_mm = 6};
  for (const Vec3d& size : {Vec3d(1, 1, 1), Vec3d(1, 3, 1), Vec3d(1, 1, 9)}) {
    const Placement p = value_of(place(box_of({0, 0, 0}, size), 1, settings));
    const double fullest = std::max({p.size_mm[0] / 61.5, p.size_mm[1] / 117.5, p.size_mm[2] / 144});
    EXPECT_LE(fullest, 1);
    EXPECT_GT(fullest, 0.995);
  }
  // Only `fit` keeps it on a printer.
  settings.fit = false;
  settings.scale = 71;
  EXPECT_TRUE(place(box_of({0, 0, 0}, {1, 1, 1}), 1, settings).has_value());
}

TEST(Placement, AGridOfItsOwnHasRoomForSupportsOnAllSides) {
  PlacementSettings settings;
  settings.pixel_pitch_mm = 0.1F;
  const Box3d box = box_of({0, 0, 0}, {8, 6, 4});
  const Placement tight = value_of(place(box, 1, settings));
  settings.room = {.beside_mm = 4.65, .below_mm = 6};
  const Placement wide = value_of(place(box, 1, settings));
  EXPECT_EQ(wide.grid.rows, tight.grid.rows + 2 * 47);
  EXPECT_GE(wide.grid.columns, tight.grid.columns + 2 * 47 - 7);
  EXPECT_EQ(wide.grid.layers, tight.grid.layers);
  EXPECT_NEAR(wide.shift[0] - tight.shift[0], 4.7, 1e-6);
  EXPECT_NEAR(wide.shift[1] - tight.shift[1], 4.7, 1e-6);
}

/// The number after `words` in a message.
double number_after(const std::string& words, const std::string& message) {
  const std::size_t at = message.find(words);
  EXPECT_NE(at, std::string::npos) << message;
  return at == std::string::npos ? 0 : std::strtod(message.c_str() + at + words.size(), nullptr);
}

void expect_the_scale_of_the_message_to_fit(const Box3d& bounds, double unit_mm, PlacementSettings settings) {
  const auto refused = place(bounds, unit_mm, settings);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kDoesNotFit);
  const double scale = number_after("a scale of ", refused.error().message());
  ASSERT_GT(scale, 0) << refused.error().message();
  settings.scale = scale;
  ASSERT_TRUE(place(bounds, unit_mm, settings).has_value()) << refused.error().message();
  settings.scale = 1.02 * scale;
  EXPECT_FALSE(place(bounds, unit_mm, settings).has_value())
      << "much more would have fitted: " << refused.error().message();
}

TEST(Placement, SuggestsAScaleThatFitsThePrinter) {
  Random random(81);
  for (int i = 0; i < 200; ++i) {
    const Vec3d size(random.uniform(1, 100), random.uniform(1, 100), random.uniform(160, 400));
    expect_the_scale_of_the_message_to_fit(box_of({0, 0, 0}, size), 1, on_a_printer());
    expect_the_scale_of_the_message_to_fit(box_of({0, 0, 0}, Vec3d(size[2], size[0], size[1])), 1, on_a_printer());
  }
}

// The scale was once printed with four decimals: 0 for a scan in micrometres.
TEST(Placement, SuggestsAScaleForAnObjectThatIsFarTooLarge) {
  for (const double size : {1e4, 3e5, 2e6, 7e7}) {
    expect_the_scale_of_the_message_to_fit(box_of({0, 0, 0}, {size, size, size}), 1, on_a_printer());
  }
}

// The scale was once rounded to the nearest four digits, so half of the suggestions did not fit.
TEST(Placement, SuggestsAScaleForAGridOfTooManyPixels) {
  Random random(82);
  for (int i = 0; i < 200; ++i) {
    const Vec3d size(random.uniform(1000, 9000), random.uniform(1, 9000), random.uniform(1, 9000));
    expect_the_scale_of_the_message_to_fit(box_of({0, 0, 0}, size), 1, {});
  }
}

TEST(Placement, SaysByHowMuchTheObjectIsTooLarge) {
  const auto refused = place(box_of({0, 0, 0}, {10, 10, 170}), 1, on_a_printer());
  ASSERT_FALSE(refused.has_value());
  const std::string message = refused.error().message();
  EXPECT_EQ(number_after("the object is ", message), 170);
  EXPECT_NE(message.find("mm high"), std::string::npos) << message;
  const double room = number_after("room for ", message);
  EXPECT_NEAR(room, 150, 0.1);
  EXPECT_NEAR(number_after("mm: ", message), 170 - room, 0.005);
}

// 150 mm divided by the float 0.05 is slightly less than 3000. The last layer must not be lost to rounding.
TEST(Placement, UsesTheWholeTravel) {
  EXPECT_TRUE(place(box_of({0, 0, 0}, {10, 10, 150}), 1, on_a_printer()).has_value());
}

TEST(RotationMatrix, IsExactAtMultiplesOfNinetyDegrees) {
  for (int x = -4; x <= 8; ++x) {
    for (int y = -4; y <= 8; ++y) {
      for (int z = -4; z <= 8; ++z) {
        const Mat3d m = rotation_matrix({90.0 * x, 90.0 * y, 90.0 * z});
        for (int i = 0; i < 9; ++i) ASSERT_TRUE(m(i) == 0 || m(i) == 1 || m(i) == -1) << m;
        ASSERT_EQ(m * m.transpose(), Mat3d(Mat3d::Identity()));
        ASSERT_EQ(m.determinant(), 1);
      }
    }
  }
}

TEST(RotationMatrix, TurnsRightHandedAboutXThenYThenZ) {
  EXPECT_EQ(rotation_matrix({90, 0, 0}) * Vec3d(0, 1, 0), Vec3d(0, 0, 1));
  EXPECT_EQ(rotation_matrix({0, 90, 0}) * Vec3d(0, 0, 1), Vec3d(1, 0, 0));
  EXPECT_EQ(rotation_matrix({0, 0, 90}) * Vec3d(1, 0, 0), Vec3d(0, 1, 0));
  EXPECT_EQ(rotation_matrix({90, 0, 90}) * Vec3d(0, 1, 0), Vec3d(0, 0, 1)) << "x first";
}

TEST(RotationMatrix, AgreesWithTheStandardLibraryAndIsOrthonormal) {
  Random random(83);
  for (int i = 0; i < 20000; ++i) {
    const double angle = random.uniform(-400, 400);
    // In radians the angle is rounded by angle * 1e-16, so the oracle gets an angle that was reduced exactly.
    const double reduced = std::remainder(angle, 360.0) * (kPi / 180);
    const Mat3d z = rotation_matrix({0, 0, angle});
    ASSERT_NEAR(z(1, 0), std::sin(reduced), 1e-15) << angle;
    ASSERT_NEAR(z(0, 0), std::cos(reduced), 1e-15) << angle;
    const Mat3d m = rotation_matrix({angle, random.uniform(-400, 400), random.uniform(-400, 400)});
    ASSERT_LT((m * m.transpose() - Mat3d::Identity()).cwiseAbs().maxCoeff(), 1e-15);
    ASSERT_NEAR(m.determinant(), 1, 2e-15);
  }
}

TEST(Placement, TransformAndOriginAgree) {
  Random random(84);
  for (int i = 0; i < 200; ++i) {
    PlacementSettings settings;
    settings.scale = random.uniform(0.1, 3);
    settings.rotation_degrees = 180 * random.vector();
    const Vec3d low = 10 * random.vector();
    const Placement p = value_of(place(box_of(low, low + Vec3d(1, 2, 3)), 10, settings));
    const Mat4d m = p.transform();
    EXPECT_EQ(m.row(3), Eigen::RowVector4d(0, 0, 0, 1));
    // The grid's origin in scan coordinates maps to the origin, any other place as the definition says.
    const Vec3d origin = (m * p.origin_in_scan().homogeneous()).head<3>();
    EXPECT_LT(origin.norm(), 1e-11);
    const Vec3d scan = random.vector();
    const Vec3d print = p.scale * (p.rotation * scan) + p.shift;
    EXPECT_LT(((m * scan.homogeneous()).head<3>() - print).norm(), 1e-11);
    // The lowest corner of the rotated box is in the first layer, and the grid's planes are whole pitches from zero.
    const double height = (low * p.scale + p.shift)[2];
    EXPECT_GE(height, -1e-11);
    EXPECT_LE(height, settings.layer_height_mm);
    const Vec3d pitches =
        p.shift.cwiseQuotient(Vec3d(settings.pixel_pitch_mm, settings.pixel_pitch_mm, settings.layer_height_mm));
    EXPECT_LT((pitches - pitches.array().round().matrix()).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace plumbline
