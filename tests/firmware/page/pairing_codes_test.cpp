#include "firmware/page/clients/pairing_codes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

std::string other_than(std::string_view code) { return code == "000000" ? "000001" : "000000"; }

ClientAddress address(unsigned last) {
  ClientAddress made;
  made.bytes[15] = static_cast<std::uint8_t>(last);
  return made;
}

class PairingCodesTest : public testing::Test {
 protected:
  /// @returns the code, or "" if it has to wait
  std::string ask(const Asker& asker) {
    const auto code = codes_.ask(asker, now_);
    return code ? std::string(code->view()) : "";
  }
  double wait_of(const Asker& asker) {
    const auto code = codes_.ask(asker, now_);
    return code ? 0 : code.error().told().values[0];
  }
  bool use(std::string_view code, const Asker& asker) { return codes_.use(code, asker, now_).has_value(); }

  PairingCodes codes_;
  PairingCodes::HostClock::time_point now_{std::chrono::hours(5)};
  const Asker phone_{"phone", address(1)}, laptop_{"laptop", address(2)}, script_{"", address(3)};
};

TEST_F(PairingCodesTest, AreForTheBrowserThatAskedAndGoodOnce) {
  const auto code = ask(phone_);
  ASSERT_EQ(code.size(), 6U);
  EXPECT_EQ(code.find_first_not_of("0123456789"), std::string::npos);
  EXPECT_EQ(codes_.shown(now_), code);
  now_ += 100s;
  EXPECT_FALSE(use(code, laptop_)) << "it is the phone's";
  EXPECT_FALSE(use(code, {"laptop", address(1)})) << "of the same address";
  EXPECT_FALSE(use(code, {"", address(1)}));
  EXPECT_TRUE(use(code, {"phone", address(9)})) << "a phone's address may change";
  EXPECT_FALSE(use(code, phone_));
  EXPECT_EQ(codes_.shown(now_), "");
  // A script that gives itself no name is known by its address.
  const auto of_script = ask(script_);
  EXPECT_FALSE(use(of_script, {"", address(4)}));
  EXPECT_TRUE(use(of_script, script_));
}

// Regression: three wrong codes of anybody made the right one void.
TEST_F(PairingCodesTest, AreNotVoidByWrongCodesOfOthers) {
  const auto code = ask(phone_);
  for (unsigned i = 0; i < 1000; ++i) {
    EXPECT_FALSE(use(other_than(code), laptop_));
    EXPECT_FALSE(use(other_than(code), {"", address(1)}));
    EXPECT_EQ(ask(laptop_), "");
  }
  EXPECT_TRUE(use(code, phone_));
}

TEST_F(PairingCodesTest, GiveNothingForAWrongOrOldOne) {
  EXPECT_FALSE(use("", phone_));
  EXPECT_FALSE(use("000000", phone_)) << "nobody asked for a code";
  const auto code = ask(phone_);
  EXPECT_FALSE(use(other_than(code), phone_));
  EXPECT_FALSE(use("", phone_));
  now_ += PairingCodes::kCodeTime + 1s;
  EXPECT_EQ(codes_.shown(now_), "");
  EXPECT_FALSE(use(code, phone_)) << "it is too old";
}

TEST_F(PairingCodesTest, DoubleTheWaitOfWhoeverGuessesAndOfNobodyElse) {
  double before = 0;
  for (const double wait : {60, 120, 240, 480, 960, 1920, 3600, 3600}) {
    const auto code = ask(phone_);
    ASSERT_NE(code, "") << wait;
    EXPECT_EQ(ask(phone_), code) << "somebody may be typing it";
    for (unsigned i = 0; i < PairingCodes::kMostTries; ++i) EXPECT_FALSE(use(other_than(code), phone_));
    EXPECT_FALSE(use(code, phone_)) << "it is void";
    EXPECT_EQ(wait_of(phone_), wait);
    EXPECT_EQ(wait_of({"another name", address(1)}), wait) << "a new name does not help";
    const auto others = ask(laptop_);
    EXPECT_TRUE(use(others, laptop_)) << "after " << before;
    before = wait;
    now_ += std::chrono::seconds(static_cast<int>(wait)) - 1ms;
    EXPECT_EQ(wait_of(phone_), 1);
    now_ += 1ms;
  }
  EXPECT_EQ(codes_.void_codes(), 8U);
  // Who has found the right one begins anew.
  EXPECT_TRUE(use(ask(phone_), phone_));
  const auto code = ask(phone_);
  for (unsigned i = 0; i < PairingCodes::kMostTries; ++i) EXPECT_FALSE(use(other_than(code), phone_));
  EXPECT_EQ(wait_of(phone_), 60);
}

TEST_F(PairingCodesTest, GiveAllAddressesTogetherFewGuesses) {
  unsigned guesses = 0;
  const auto until = now_ + 2h;
  for (unsigned i = 0; now_ < until; ++i, now_ += 1s) {
    const Asker asker{"", address(i % 250)};
    const auto code = ask(asker);
    for (unsigned k = 0; !code.empty() && k < PairingCodes::kMostTries; ++k, ++guesses) use(other_than(code), asker);
  }
  EXPECT_LE(guesses, 3U * (120 + 6));
  EXPECT_GE(guesses, 300U) << "the control: they do guess";
}

TEST_F(PairingCodesTest, GoToThoseThatWaitInTheirOrder) {
  const auto code = ask(phone_);
  now_ += 10s;
  EXPECT_EQ(wait_of(laptop_), 110);
  now_ += 4s;
  EXPECT_EQ(wait_of(script_), 106 + 120);
  // The phone is not prolonged while others wait, and comes after them.
  for (now_ += 4s; !codes_.shown(now_).empty(); now_ += 4s) {
    EXPECT_EQ(ask(phone_), code);
    EXPECT_EQ(ask(laptop_), "");
    EXPECT_EQ(ask(script_), "");
  }
  EXPECT_EQ(ask(phone_), "");
  EXPECT_EQ(ask(script_), "");
  const auto next = ask(laptop_);
  ASSERT_NE(next, "");
  EXPECT_NE(next, code);
  codes_.give_up(laptop_);
  EXPECT_EQ(codes_.shown(now_), "") << "the person has closed the dialog";
  EXPECT_EQ(ask(phone_), "");
  now_ += 11s;
  EXPECT_NE(ask(phone_), "") << "the script has gone";
}

TEST_F(PairingCodesTest, LeaveOneAddressOnePlaceAmongThoseThatWait) {
  ask(phone_);
  const std::string names = "abcdefghijklmnopqrstuvwxyz";
  for (std::size_t i = 0; i < names.size(); ++i) ask({std::string_view(names).substr(i, 1), address(7)});
  now_ += 1s;
  EXPECT_EQ(wait_of(laptop_), 119 + 120);
}

TEST_F(PairingCodesTest, Differ) {
  std::set<std::string, std::less<>> codes;
  for (int i = 0; i < 100; ++i) {
    now_ += 10min;
    codes.emplace(ask(phone_));
  }
  EXPECT_GT(codes.size(), 95U);
}

}  // namespace
}  // namespace plumbline::firmware
