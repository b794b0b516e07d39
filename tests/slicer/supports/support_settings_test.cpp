#include "slicer/supports/support_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace plumbline {
namespace {

using ::testing::HasSubstr;

std::string refusal(const SupportSettings& settings) {
  const auto status = check_support_settings(settings);
  if (status) return "";
  EXPECT_EQ(status.error().code(), ErrorCode::kBadSetting);
  return status.error().message();
}

TEST(SupportSettings, AreValidByDefault) { EXPECT_EQ(refusal({}), ""); }

TEST(SupportSettings, AreRefusedOutsideOfTheirRange) {
  for (const SupportField& field : kSupportFields) {
    for (const double value : {field.low - 0.01, field.high + 0.01, std::numeric_limits<double>::quiet_NaN()}) {
      SupportSettings settings;
      settings.*field.member = value;
      EXPECT_THAT(refusal(settings), HasSubstr(std::string(field.key) + " is ")) << value;
    }
  }
  SupportSettings settings;
  settings.critical_angle = 85;
  EXPECT_EQ(refusal(settings), "support_critical_angle is 85, allowed are 30 to 80 deg");
}

TEST(SupportSettings, AreRefusedUnlessTheyNarrowTowardsTheObject) {
  SupportSettings wide_head;
  wide_head.head_front_diameter = 1.5;
  EXPECT_THAT(refusal(wide_head),
              HasSubstr("support_head_front_diameter is 1.5 mm, more than support_pillar_diameter"));
  SupportSettings wide_pillar;
  wide_pillar.pillar_diameter = 5;
  EXPECT_THAT(refusal(wide_pillar), HasSubstr("support_pillar_diameter is 5 mm, more than support_base_diameter"));
}

TEST(SupportSettings, AreValidWithEachPresetAndThickerFromOneToTheNext) {
  SupportSettings thinner;
  thinner.head_front_diameter = thinner.head_penetration = thinner.pillar_diameter = 0;
  for (const SupportPreset& preset : kSupportPresets) {
    SupportSettings settings;
    apply(preset, settings);
    EXPECT_EQ(refusal(settings), "") << preset.name;
    EXPECT_GT(settings.head_front_diameter, thinner.head_front_diameter);
    EXPECT_GT(settings.head_penetration, thinner.head_penetration);
    EXPECT_GT(settings.pillar_diameter, thinner.pillar_diameter);
    thinner = settings;
  }
  SupportSettings medium;
  apply(kSupportPresets[1], medium);
  EXPECT_EQ(medium.head_front_diameter, SupportSettings().head_front_diameter);
  EXPECT_EQ(medium.head_penetration, SupportSettings().head_penetration);
  EXPECT_EQ(medium.pillar_diameter, SupportSettings().pillar_diameter);
}

TEST(SupportSettings, AreRefusedIfTheyRaiseTheObjectByNothing) {
  SupportSettings settings;
  settings.stand = SupportStand::kRaised;
  EXPECT_EQ(refusal(settings), "");
  settings.object_elevation = 0;
  EXPECT_EQ(refusal(settings), "support_stand is raised, but support_object_elevation is 0 mm");
  settings.stand = SupportStand::kPlate;
  EXPECT_EQ(refusal(settings), "");
}

}  // namespace
}  // namespace plumbline
