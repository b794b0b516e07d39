#include "firmware/page/pairing.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline {
namespace {

using namespace std::chrono_literals;

std::string other_than(const PageCode& code) { return code.view() == "000000" ? "000001" : "000000"; }

class PairingTest : public testing::Test {
 protected:
  Pairing pairing_ = Pairing::open("").value();
  Pairing::HostClock::time_point now_{std::chrono::hours(5)};
};

TEST_F(PairingTest, GivesATokenForTheCodeOnce) {
  const auto code = pairing_.new_code(now_);
  ASSERT_TRUE(code);
  EXPECT_EQ(code->view().size(), 6U);
  EXPECT_EQ(code->view().find_first_not_of("0123456789"), std::string_view::npos);
  const auto token = pairing_.pair(code->view(), now_ + 100s);
  ASSERT_TRUE(token) << token.error().message();
  EXPECT_EQ(token->view().size(), 32U);
  EXPECT_TRUE(pairing_.knows(token->view()));
  EXPECT_FALSE(pairing_.pair(code->view(), now_ + 100s)) << "a code is for one browser";
  EXPECT_FALSE(pairing_.knows(""));
  EXPECT_FALSE(pairing_.knows(std::string(32, '0'))) << "the token of an empty place";
  EXPECT_FALSE(pairing_.knows(token->view().substr(1)));
}

TEST_F(PairingTest, GivesNothingForAWrongOrOldCode) {
  EXPECT_FALSE(pairing_.pair("", now_));
  EXPECT_FALSE(pairing_.pair("000000", now_)) << "nobody asked for a code";
  auto code = pairing_.new_code(now_).value();
  EXPECT_FALSE(pairing_.pair(other_than(code), now_));
  EXPECT_FALSE(pairing_.pair("", now_));
  EXPECT_FALSE(pairing_.pair(code.view(), now_ + Pairing::kCodeTime + 1s)) << "it is too old";
}

TEST_F(PairingTest, TakesThreeGuessesAMinute) {
  const auto code = pairing_.new_code(now_).value();
  EXPECT_EQ(pairing_.new_code(now_ + 10s)->view(), code.view()) << "somebody may be typing it";
  for (unsigned i = 0; i < Pairing::kMostTries; ++i) EXPECT_FALSE(pairing_.pair(other_than(code), now_));
  EXPECT_FALSE(pairing_.pair(code.view(), now_)) << "it is void";
  const auto soon = pairing_.new_code(now_ + 59s);
  ASSERT_FALSE(soon);
  EXPECT_EQ(soon.error().code(), ErrorCode::kBusy);
  EXPECT_TRUE(pairing_.new_code(now_ + 60s));
}

TEST_F(PairingTest, MakesCodesAndTokensThatDiffer) {
  std::set<std::string, std::less<>> codes, tokens;
  for (int i = 0; i < 100; ++i) {
    now_ += 10min;
    codes.emplace(pairing_.new_code(now_)->view());
    tokens.emplace(pairing_.add().view());
  }
  EXPECT_GT(codes.size(), 95U);
  EXPECT_EQ(tokens.size(), 100U);
}

TEST_F(PairingTest, RemembersTheNewestBrowsersInAFileForItself) {
  const TemporaryFolder folder;
  std::vector<std::string> tokens;
  {
    auto pairing = Pairing::open(folder / "");
    ASSERT_TRUE(pairing) << pairing.error().message();
    for (std::size_t i = 0; i < Pairing::kMostBrowsers + 1; ++i) tokens.emplace_back(pairing->add().view());
  }
  const auto file = folder / "browsers";
  struct stat facts {};
  ASSERT_EQ(::stat(file.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0600U);
  EXPECT_EQ(facts.st_size, 256);
  const auto again = Pairing::open(folder / "").value();
  EXPECT_FALSE(again.knows(tokens.front())) << "the first made room for the last";
  for (std::size_t i = 1; i < tokens.size(); ++i) EXPECT_TRUE(again.knows(tokens[i])) << i;
  std::filesystem::resize_file(file, 100);
  EXPECT_FALSE(Pairing::open(folder / "")->knows(tokens.back())) << "a file that was cut is not believed";
  EXPECT_FALSE(Pairing::open(folder / "none"));
}

}  // namespace
}  // namespace plumbline
