#include "firmware/daemon/button_socket.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline {
namespace {

using ::testing::HasSubstr;

TEST(ButtonSocket, DeliversPressesInOrderAndDropsWhatIsNoButton) {
  const TemporaryFolder folder;
  // A socket's address has room for 107 characters.
  const std::string state = folder / std::string(120, 'd');
  std::filesystem::create_directory(state);
  auto buttons = ButtonSocket::open(state);
  ASSERT_TRUE(buttons) << buttons.error().message();
  EXPECT_EQ(buttons->next(), std::nullopt);
  for (const char* word :
       {"start", "", "START", "start\n", "a word that is longer than any button's", "pause", "cancel"}) {
    ASSERT_TRUE(press_button(state, word));
  }
  EXPECT_EQ(buttons->next(), EventKind::kStartPressed);
  EXPECT_EQ(buttons->next(), EventKind::kPausePressed);
  EXPECT_EQ(buttons->next(), EventKind::kCancelPressed);
  EXPECT_EQ(buttons->next(), std::nullopt);
}

TEST(ButtonSocket, IsOpenedAgainAfterADaemonWasKilled) {
  const TemporaryFolder folder;
  { ASSERT_TRUE(ButtonSocket::open(folder / ".")); }
  const auto nobody = press_button(folder / ".", "start");
  ASSERT_FALSE(nobody);
  EXPECT_THAT(nobody.error().message(), HasSubstr("no plumblined runs with the state folder"));
  auto buttons = ButtonSocket::open(folder / ".");
  ASSERT_TRUE(buttons) << buttons.error().message();
  ASSERT_TRUE(press_button(folder / ".", "cancel"));
  EXPECT_EQ(buttons->next(), EventKind::kCancelPressed);
}

TEST(ButtonSocket, SaysThatNoDaemonRuns) {
  const TemporaryFolder folder;
  EXPECT_THAT(press_button(folder / ".", "start").error().message(), HasSubstr("no plumblined runs"));
  EXPECT_THAT(press_button(folder / "none", "start").error().message(), HasSubstr("No such file"));
}

}  // namespace
}  // namespace plumbline
