#include "firmware/daemon/stick/stick_words.hpp"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(StickWords, TurnOptionsIntoKeysOfTheJobFile) {
  EXPECT_EQ(in_stick_words("Use --scale 0.5 or less, --fit, or turn it.").view(),
            "Use scale = 0.5 or less, fit = true, or turn it. (in job.toml on the stick)");
  EXPECT_EQ(in_stick_words("--keep-all keeps them").view(), "keep_all = true keeps them (in job.toml on the stick)");
  EXPECT_EQ(in_stick_words("ask for them with --supports auto.").view(),
            "ask for them with supports = \"auto\". (in job.toml on the stick)");
  EXPECT_EQ(in_stick_words("check --units").view(), "check units (in job.toml on the stick)");
}

TEST(StickWords, NameTheSettingsFirstIfTheyHelp) {
  EXPECT_EQ(in_stick_words("Use --scale 0.5 or less, or --fit", ToldCode::kTooHigh).view(),
            "Under Settings, tilt it or print it smaller. Or use scale = 0.5 or less, or fit = true (in job.toml on "
            "the stick)");
  EXPECT_EQ(in_stick_words("", ToldCode::kTooSmall).view(), "Under Settings, choose a height.");
  EXPECT_EQ(in_stick_words("check --units", ToldCode::kNone).view(), in_stick_words("check --units").view());
}

TEST(StickWords, LeaveOtherTextAlone) {
  for (const char* text : {"", "no scan on the stick", "--arena-mib", "a--b", "say --scaled"}) {
    EXPECT_EQ(in_stick_words(text).view(), text);
  }
  EXPECT_EQ(in_stick_words("--rotate-x 180, or rotate_x_deg = 180 in job.toml").view(),
            "rotate_x_deg = 180, or rotate_x_deg = 180 in job.toml");
}

}  // namespace
}  // namespace plumbline
