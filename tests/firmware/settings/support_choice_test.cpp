#include "firmware/settings/support_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
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

std::string many(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i > 0 ? ";1,2," : "1,2,") + std::to_string(i);
  return text;
}

TEST(SupportPlaces, AreReadAsPeopleTypeThem) {
  const auto& [at, not_at] = kPlaceFields;
  SupportPlaces places;
  EXPECT_EQ(add_places("12.5,-3,20.1; 40 , 22 ,8;", at, places), "");
  EXPECT_THAT(places.all(), ElementsAre(SupportPlace{12.5, -3, 20.1}, SupportPlace{40, 22, 8}));
  EXPECT_EQ(add_places("1,2,3", at, places), "");
  EXPECT_EQ(places.count, 3U) << "added to what was there";
  SupportPlaces balls;
  EXPECT_EQ(add_places("40,22,8;1,2,3,0.1", not_at, balls), "");
  EXPECT_THAT(balls.all(), ElementsAre(SupportPlace{40, 22, 8, 2}, SupportPlace{1, 2, 3, 0.1}));
  SupportPlaces all;
  EXPECT_EQ(add_places(many(32), at, all), "");
  EXPECT_EQ(add_places("9,9,9", at, all), "9,9,9") << "there is no room";
}

TEST(SupportPlaces, AreRefusedByTheFirstThatIsNone) {
  const auto& [at, not_at] = kPlaceFields;
  for (const auto& [text, wrong] :
       std::initializer_list<std::pair<const char*, const char*>>{{"1,2", "1,2"},
                                                                  {"1,2,3;4,5,6,7", "4,5,6,7"},
                                                                  {"1,2,nan", "1,2,nan"},
                                                                  {"1,2,inf", "1,2,inf"},
                                                                  {"1,2,1e300", "1,2,1e300"},
                                                                  {"1001,2,3", "1001,2,3"},
                                                                  {"1,2,3 mm", "1,2,3 mm"},
                                                                  {"1;2;3", "1"},
                                                                  {"1,,3", "1,,3"},
                                                                  {";1,2,3", " "},
                                                                  {"x", "x"}}) {
    SupportPlaces places;
    EXPECT_EQ(add_places(text, at, places), wrong);
  }
  for (const char* const text : {"1,2,3,0", "1,2,3,-1", "1,2,3,101", "1,2,3,nan", "1,2,3,4,5", "1,2,3,4,5,6,7"}) {
    SupportPlaces places;
    EXPECT_EQ(add_places(text, not_at, places), text);
  }
  SupportPlaces places;
  EXPECT_EQ(add_places(many(33), at, places), "1,2,32");
}

TEST(SupportPlaces, BelongToTheJobAndNeedSupports) {
  SupportChoice choice;
  ASSERT_EQ(add_places("1,2,3", kPlaceFields[1], choice.places[1]), "");
  EXPECT_TRUE(choice.has_places());
  EXPECT_EQ(chosen(choice).blocked.count, 1U);
  EXPECT_EQ(chosen(choice).added.count, 0U);
  const auto off = choice.over(false, {});
  ASSERT_FALSE(off);
  EXPECT_THAT(off.error().message(), HasSubstr("no_support_at is given, but supports are off"));
}

TEST(SupportPlaces, OfAProcessThatIsNotTrustedAreChecked) {
  SupportChoice choice;
  ASSERT_EQ(add_places("1,2,3;4,5,6", kPlaceFields[0], choice.places[0]), "");
  ASSERT_EQ(add_places("1,2,3,7", kPlaceFields[1], choice.places[1]), "");
  SupportChoice received;
  ASSERT_TRUE(receive(pass(choice), received));
  EXPECT_EQ(received, choice);
  for (const auto& spoil : std::initializer_list<void (*)(PassedSupports&)>{
           [](PassedSupports& p) { p.places[0].count = 33; }, [](PassedSupports& p) { p.places[0].count = ~0U; },
           [](PassedSupports& p) { p.places[0].list[1].z = std::numeric_limits<double>::quiet_NaN(); },
           [](PassedSupports& p) { p.places[1].list[0].radius = 0; },
           [](PassedSupports& p) { p.places[1].list[0].x = -1e9; }}) {
    PassedSupports passed = pass(choice);
    spoil(passed);
    SupportChoice refused;
    EXPECT_FALSE(receive(passed, refused));
  }
}

}  // namespace
}  // namespace plumbline::firmware
