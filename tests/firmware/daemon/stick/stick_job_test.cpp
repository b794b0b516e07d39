/// job.toml, the file on a stick that names what to print.

#include "firmware/daemon/stick/stick_job.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(StickJob, HasEveryKeyThatItsFileHas) {
  const auto job = parse_stick_job(
      "[job]\nscan = 'a b.ply'\nprofile = 'draft'\nsupports = 'auto'\nbase = 'flat'\nkeep_all = true\n"
      "[placement]\nunits = 'in'\nscale = 2.5\nfit = true\nrotate_x_deg = 1\nrotate_y_deg = -2\nrotate_z_deg = 3\n"
      "layer_height = 0.1\n",
      "job.toml");
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_THAT(job->scans, ElementsAre("a b.ply"));
  EXPECT_EQ(job->profile, "draft");
  EXPECT_EQ(job->supports.enable, true);
  EXPECT_EQ(job->base, BaseChoice::kFlat);
  EXPECT_TRUE(job->keep_all);
  EXPECT_EQ(job->units, Units::kInches);
  EXPECT_DOUBLE_EQ(job->scale, 2.5);
  EXPECT_TRUE(job->fit);
  EXPECT_DOUBLE_EQ(job->rotate_x_deg, 1);
  EXPECT_DOUBLE_EQ(job->rotate_y_deg, -2);
  EXPECT_DOUBLE_EQ(job->rotate_z_deg, 3);
  EXPECT_DOUBLE_EQ(job->layer_height, 0.1);
}

TEST(StickJob, TakesSupportsAsAProfileDoes) {
  const auto job = parse_stick_job(
      "[job]\nscan = 'a.ply'\n[supports]\nsupport_preset = 'heavy'\nsupport_buildplate_only = true\n"
      "support_head_penetration = 0.2\nsupport_object_elevation = 3\n",
      "job.toml");
  ASSERT_TRUE(job) << job.error().message();
  const auto settings = job->supports.over(true, {});
  ASSERT_TRUE(settings) << settings.error().message();
  EXPECT_EQ((*settings)->head_front_diameter, 0.6);
  EXPECT_EQ((*settings)->head_penetration, 0.2) << "overrides the preset";
  EXPECT_TRUE((*settings)->buildplate_only);
  EXPECT_EQ((*settings)->stand, SupportStand::kRaised) << "since the file states an elevation";
  const auto wrong = parse_stick_job("[job]\nscan = 'a.ply'\n[supports]\nsupport_stand = 'up'\n", "job.toml");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message(), HasSubstr("allowed is one of the strings auto, plate or raised"));
}

TEST(StickJob, TakesPlacesOfSupports) {
  const auto parsed = [](const std::string& line) {
    return parse_stick_job("[job]\nscan = 'a.ply'\n[supports]\n" + line + "\n", "job.toml");
  };
  const auto job =
      parsed("support_at = [[12.5, -3, 20.1], [1, 2, 3]]\nno_support_at = [[40.0, 22.0, 8.0], [1, 2, 3, 0.5]]");
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_THAT(job->supports.places[0].all(), ElementsAre(SupportPlace{12.5, -3, 20.1}, SupportPlace{1, 2, 3}));
  EXPECT_THAT(job->supports.places[1].all(), ElementsAre(SupportPlace{40, 22, 8, 2}, SupportPlace{1, 2, 3, 0.5}));
  EXPECT_FALSE(parsed("support_at = []")->supports.has_places());
  std::string many;
  for (int i = 0; i < 33; ++i) many += "[1, 2, " + std::to_string(i) + "],";
  // The element that is wrong is shown, in its own line.
  for (const auto& [wrong, words] : std::vector<std::pair<std::string, std::string>>{
           {"support_at = [[1, 2, 3],\n[4, nan, 6]]",
            "job.toml:5: [supports] support_at: found an array [4, nan, 6], allowed is an array of up to 32 places"},
           {"support_at = [[1, 2, inf]]", "job.toml:4: "},
           {"support_at = [[1, 2, 1e9]]", "from -1000 to 1000 mm"},
           {"support_at = [[1, 2]]", "found an array [1, 2]"},
           {"support_at = [[1, 2, 3, 4]]", "found an array [1, 2, 3, 4]"},
           {"support_at = [1, 2, 3]", "found an integer 1"},
           {"support_at = [['1', '2', '3']]", "support_at: found an array"},
           {"support_at = '1,2,3'", "found a string '1,2,3'"},
           {"support_at = [" + many + "]", "found an array [1, 2, 32], allowed is an array of up to 32 places"},
           {"no_support_at = [[1, 2, 3, 0]]", "radii from 0.1 to 100 mm"},
           {"no_support_at = [[1, 2, 3, nan]]", "no_support_at: found an array"}}) {
    const auto refused = parsed(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code(), ErrorCode::kBadSetting);
    EXPECT_THAT(refused.error().message(), HasSubstr(words)) << wrong;
  }
}

TEST(StickJob, TakesSeveralFilesAsOneScan) {
  const auto job = parse_stick_job("[job]\nscan = ['front.ply', 'more/back.ply']\n", "job.toml");
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_THAT(job->scans, ElementsAre("front.ply", "more/back.ply"));
  EXPECT_EQ(job->title(), "front.ply and 1 more");
  std::string many;
  for (int i = 0; i < 33; ++i) many += "'a.ply',";
  for (const std::string& wrong : {std::string("[]"), "[" + many + "]", std::string("['a.ply', 2]"),
                                   std::string("['a.ply', '']"), std::string("[['a.ply']]")}) {
    const auto refused = parse_stick_job("[job]\nscan = " + wrong + "\n", "job.toml");
    ASSERT_FALSE(refused) << wrong;
    EXPECT_THAT(refused.error().message(), HasSubstr("job.toml:2: [job] scan: found an array, allowed is a string of 1 "
                                                     "to 255 characters, or an array of 1 to 32 of them"));
  }
}

TEST(StickJob, TakesASizeInItsUnit) {
  const auto size_in = [](const std::string& line) {
    return parse_stick_job("[job]\nscan = 'a.ply'\n[placement]\n" + line, "job.toml");
  };
  EXPECT_EQ(size_in("height = '80mm'\n")->size, (PrintSize{Side::kHeight, 80}));
  EXPECT_EQ(size_in("width = '8 cm'\n")->size, (PrintSize{Side::kWidth, 80}));
  EXPECT_EQ(size_in("depth = '2in'\n")->size, (PrintSize{Side::kDepth, 50.8}));
  EXPECT_EQ(size_in("length = '80'\n")->size, (PrintSize{Side::kLength, 80}));
  for (const char* wrong : {"height = '80 feet'\n", "height = '80mm'\nwidth = '2cm'\n", "height = '80mm'\nfit = true\n",
                            "height = '80mm'\nscale = 2\n"}) {
    const auto job = size_in(wrong);
    ASSERT_FALSE(job) << wrong;
    EXPECT_THAT(job.error().message(), HasSubstr("job.toml:")) << wrong;
  }
}

TEST(StickJob, TakesAFloorAndAnOrientation) {
  const auto job = parse_stick_job(
      "[job]\nscan = 'a.ply'\nfloor = '-3.5'\n[placement]\norient = 'auto'\nkeep_clean = '-y'\n", "job.toml");
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_EQ(job->floor, (FloorChoice{FloorChoice::Kind::kHeight, -3.5}));
  EXPECT_TRUE(job->orient);
  EXPECT_EQ(job->keep_clean, CleanSide::kMinusY);
  const auto no_side = parse_stick_job("[job]\nscan = 'a.ply'\n[placement]\nkeep_clean = 'face'\n", "job.toml");
  ASSERT_FALSE(no_side);
  EXPECT_THAT(no_side.error().message(), HasSubstr("keep_clean"));
  const auto wrong = parse_stick_job("[job]\nscan = 'a.ply'\nfloor = 'wood'\n", "job.toml");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message(), HasSubstr("auto, keep, or a height"));
  const auto both =
      parse_stick_job("[job]\nscan = 'a.ply'\n[placement]\norient = 'auto'\nrotate_x_deg = 90\n", "job.toml");
  ASSERT_FALSE(both);
  EXPECT_THAT(both.error().message(), HasSubstr("leave out rotate_x_deg"));
}

TEST(StickJob, MayHaveLayersAsHighAsTheSurfaceAllows) {
  const auto job = parse_stick_job("[job]\nscan = 'a.ply'\n[placement]\nlayer_height = 'adaptive'\n", "job.toml");
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_TRUE(job->is_adaptive());
  EXPECT_FALSE(job->print_values()[index_of(PrintKey::kLayerHeight)]);
  const auto other = parse_stick_job("[job]\nscan = 'a.ply'\n[placement]\nlayer_height = 'fine'\n", "job.toml");
  EXPECT_THAT(other.error().message(),
              HasSubstr("found a string 'fine', allowed is a number from 0.005 to 1 mm, or the string \"adaptive\""));
}

TEST(StickJob, LeavesOpenWhatItsFileDoesNotSay) {
  const auto job = parse_stick_job("[job]\nscan = 'a.ply'\n", "job.toml");
  ASSERT_TRUE(job) << job.error().message();
  EXPECT_EQ(job->supports, SupportChoice());
  EXPECT_EQ(job->base, BaseChoice::kAuto);
  EXPECT_FALSE(job->keep_all);
  EXPECT_EQ(job->layer_height, 0);
}

TEST(StickJob, CallsTheUndersideAsTheCommandLineDoes) {
  for (const BaseChoice base : {BaseChoice::kAuto, BaseChoice::kNone, BaseChoice::kFlat}) {
    const auto text = std::string("[job]\nscan = 'a.ply'\nbase = '") + to_string(base) + "'\n";
    const auto job = parse_stick_job(text, "job.toml");
    ASSERT_TRUE(job) << job.error().message();
    EXPECT_EQ(job->base, base);
  }
  const auto wrong = parse_stick_job("[job]\nscan = 'a.ply'\nbase = 'round'\n", "job.toml");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message(),
              HasSubstr("job.toml:3: [job] base: found a string 'round', allowed is one of the strings"));
}

// toml++ reached code that it marks as unreachable. What happened then was up to the compiler.
TEST(StickJob, TakesAnyLetterInAStringAndRefusesItInAKey) {
  const auto job = parse_stick_job("[job]\nscan = 'b\u00FCste \u0391\u0416.ply'  # B\u00FCste\n", "job.toml");
  ASSERT_TRUE(job.has_value()) << job.error().message();
  EXPECT_EQ(job->scans[0], "b\u00FCste \u0391\u0416.ply");
  for (const char* const letter : {"\u00A1", "\u00DF", "\u00FC", "\u020F", "\u0391", "\u0416", "\u0499"}) {
    for (const std::string& text : {std::string(letter) + " = 2\n", std::string("ma") + letter + " = 2\n"}) {
      const auto wrong = parse_stick_job("[job]\nscan = 'a.ply'\n" + text, "job.toml");
      ASSERT_FALSE(wrong.has_value()) << text;
      EXPECT_THAT(wrong.error().message(), StartsWith("job.toml:3: "));
    }
  }
}

TEST(StickJob, IsExplainedKeyByKeyInTheReadme) {
  std::ifstream page(PLUMBLINE_SOURCE_DIR "/board/README.md");
  const std::regex row(R"(^\| (job|placement): (`[^|]*`) \+?.*)");
  const std::regex key("`(\\w+)`");
  int explained = 0;
  for (std::string line; std::getline(page, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    const std::string table = match[1];
    const std::string keys = line.substr(0, line.find('|', 1));
    for (std::sregex_iterator name(keys.begin(), keys.end(), key), end; name != end; ++name) {
      // No key takes an array of numbers, so the message shows whether the key exists.
      const std::string word = (*name)[1];
      std::string text = word == "scan" ? "[job]\n" : "[job]\nscan = 'a.ply'\n";
      if (table == "placement") text += "[placement]\n";
      const auto parsed = parse_stick_job(text + word + " = [1]\n", "job.toml");
      ASSERT_FALSE(parsed);
      EXPECT_THAT(parsed.error().message(), HasSubstr("] " + word + ": found an array"));
      ++explained;
    }
  }
  EXPECT_EQ(explained, 20);
}

}  // namespace
}  // namespace plumbline::firmware
