#include "firmware/settings/settings_folders.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "firmware/settings/setting_words.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

/// Puts a printer and a profile into a folder that is the working directory until the end of the test.
class SettingsFolders : public testing::Test {
 protected:
  SettingsFolders() {
    for (const char* file :
         {"board/mine.toml", "board/profiles/thick.toml", "far/other.toml", "far/profiles/thin.toml"}) {
      const std::string path = folder_ / file;
      std::filesystem::create_directories(std::filesystem::path(path).parent_path());
      write_text(path, "");
    }
    std::filesystem::current_path(folder_ / "");
  }
  ~SettingsFolders() override { std::filesystem::current_path(before_); }

  std::filesystem::path before_ = std::filesystem::current_path();
  TemporaryFolder folder_;
};

TEST_F(SettingsFolders, FindAPrinterByNameInTheWorkingDirectory) {
  EXPECT_EQ(find_board_file("mine").value(), "board/mine.toml");
}

TEST_F(SettingsFolders, TakeAPathAsItIs) {
  EXPECT_EQ(find_board_file("far/other.toml").value(), "far/other.toml");
  EXPECT_EQ(find_profile("./any", "board/mine.toml").value(), "./any");
  EXPECT_EQ(find_profile("any.toml", "board/mine.toml").value(), "any.toml");
}

TEST_F(SettingsFolders, SayWhichPrintersThereAreAndWhereTheyLooked) {
  const auto none = find_board_file("mne");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code(), ErrorCode::kCannotOpen);
  EXPECT_THAT(none.error().message(),
              AllOf(HasSubstr("no printer is called mne. Did you mean mine?"), HasSubstr(" in board")));
  EXPECT_THAT(find_board_file("far/none.toml").error().message(), HasSubstr("far/none.toml: no such board file"));
}

TEST_F(SettingsFolders, FindAProfileBesideTheBoardFileFirst) {
  EXPECT_EQ(find_profile("thick", "board/mine.toml").value(), "board/profiles/thick.toml");
  EXPECT_EQ(find_profile("thin", "far/other.toml").value(), "far/profiles/thin.toml");
}

TEST_F(SettingsFolders, FindAProfileOfTheBoardFolderForABoardFileElsewhere) {
  EXPECT_THAT(find_profile("thick", "far/other.toml").value(), EndsWith("board/profiles/thick.toml"));
}

TEST_F(SettingsFolders, SayWhichProfilesThereAre) {
  const auto none = find_profile("thicc", "far/other.toml");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message(), AllOf(HasSubstr("no profile is called thicc. Did you mean thick?"),
                                            HasSubstr("far/profiles, board/profiles")));
}

TEST(CheckFileName, NamesBothWhereTheyDiffer) {
  EXPECT_TRUE(check_file_name("board/mono2k.toml", "[printer] name", "mono2k"));
  EXPECT_TRUE(check_file_name("/dev/fd/63", "[printer] name", "mono2k"));
  EXPECT_STREQ(check_file_name("board/copy.toml", "[printer] name", "mono2k").error().message(),
               "board/copy.toml: [printer] name is \"mono2k\", but the file is called copy.toml. Change one of them");
}

TEST(SettingWords, ShortenToWholeWords) {
  EXPECT_EQ(shortened("one two three", 20), "one two three");
  EXPECT_EQ(shortened("one two three", 9), "one two...");
  EXPECT_EQ(shortened("incomprehensibilities", 6), "incomp...");
}

TEST(SettingWords, SuggestOnlyWhatIsNear) {
  EXPECT_EQ(nearest_within("suports", {"supports", "support-head-width"}), "supports");
  EXPECT_EQ(nearest_within("foo", {"slice", "print"}), std::nullopt);
  EXPECT_EQ(nearest_within("foo", {}), std::nullopt);
}

}  // namespace
}  // namespace plumbline::firmware
