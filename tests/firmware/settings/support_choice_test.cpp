#include "firmware/settings/support_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

std::optional<double>& value(SupportChoice& choice, std::string_view key) {
  std::size_t i = 0;
  while (kSupportFields.at(i).key != key) ++i;
  return choice.values[i];
}

SupportSettings chosen(const SupportChoice& choice, const SupportSettings& profile = {}) {
  const auto settings = choice.over(true, profile);
  EXPECT_TRUE(settings);
  return settings ? settings->value() : SupportSettings();
}

std::string refusal(const SupportChoice& choice) {
  const auto settings = choice.over(true, {});
  return settings ? "" : settings.error().message();
}

TEST(SupportChoice, RaisesTheObjectByAnElevationThatIsStated) {
  EXPECT_EQ(chosen({}).stand, SupportStand::kAuto);
  SupportChoice choice;
  value(choice, "support_object_elevation") = 5;  // the default, but somebody says it
  EXPECT_EQ(chosen(choice).stand, SupportStand::kRaised);
  SupportSettings profile;
  profile.stand = SupportStand::kPlate;
  EXPECT_EQ(chosen(choice, profile).stand, SupportStand::kRaised);
  value(choice, "support_object_elevation") = 0;
  EXPECT_EQ(chosen(choice).stand, SupportStand::kPlate);
}

TEST(SupportChoice, TakesTheWordForHowTheObjectStands) {
  SupportChoice choice;
  value(choice, "support_object_elevation") = 3;
  choice.stand = SupportStand::kAuto;
  EXPECT_EQ(chosen(choice).stand, SupportStand::kAuto);
  EXPECT_EQ(chosen(choice).object_elevation, 3);
  choice.stand = SupportStand::kPlate;
  EXPECT_THAT(refusal(choice), HasSubstr("support_object_elevation is 3 mm, but support_stand is plate"));
  choice.stand = SupportStand::kRaised;
  value(choice, "support_object_elevation") = 0;
  EXPECT_THAT(refusal(choice), HasSubstr("support_stand is raised, but support_object_elevation is 0 mm"));
}

TEST(SupportChoice, OverridesAPresetByWhatIsStated) {
  SupportSettings profile;
  profile.pillar_diameter = 2;
  SupportChoice choice;
  choice.preset = 2;
  EXPECT_EQ(chosen(choice, profile).pillar_diameter, 1.3) << "the preset of the job is nearer than the profile";
  value(choice, "support_head_front_diameter") = 0.5;
  EXPECT_EQ(chosen(choice, profile).head_front_diameter, 0.5);
  EXPECT_EQ(chosen(choice, profile).head_penetration, 0.6);
  choice.buildplate_only = true;
  EXPECT_TRUE(chosen(choice, profile).buildplate_only);
}

TEST(SupportChoice, IsRefusedIfSupportsAreOff) {
  SupportChoice choice;
  EXPECT_EQ(*choice.over(false, {}), std::nullopt);
  choice.stand = SupportStand::kRaised;
  const auto off = choice.over(false, {});
  ASSERT_FALSE(off);
  EXPECT_THAT(off.error().message(), HasSubstr("support_stand is given, but supports are off"));
  choice.enable = true;
  EXPECT_TRUE(choice.over(false, {}));
}

}  // namespace
}  // namespace plumbline::firmware
