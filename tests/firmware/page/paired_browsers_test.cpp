#include "firmware/page/clients/paired_browsers.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::time_t kNow = 1'800'000'000;

std::size_t count(const PairedBrowsers& paired) {
  return static_cast<std::size_t>(
      std::ranges::count_if(paired.list(), [](const PairedBrowsers::Browser& one) { return one.number > 0; }));
}

TEST(PairedBrowsers, AreKnownByTheirTokenAlone) {
  auto paired = PairedBrowsers::open("").value();
  EXPECT_FALSE(paired.find(""));
  EXPECT_FALSE(paired.find(std::string(32, '0'))) << "the token of an empty place";
  std::set<std::string, std::less<>> tokens;
  for (int i = 0; i < 100; ++i) tokens.emplace(paired.add("", kNow).view());
  EXPECT_EQ(tokens.size(), 100U);
  const auto token = paired.add("phone", kNow);
  ASSERT_EQ(token.view().size(), 32U);
  EXPECT_EQ(paired.find(token.view()), 101U);
  EXPECT_FALSE(paired.find(token.view().substr(1)));
}

TEST(PairedBrowsers, AreRememberedInAFileForItself) {
  const TemporaryFolder folder;
  std::vector<std::string> tokens;
  {
    auto paired = PairedBrowsers::open(folder / "");
    ASSERT_TRUE(paired) << paired.error().message();
    for (std::size_t i = 0; i < PairedBrowsers::kMost; ++i) tokens.emplace_back(paired->add("phone", kNow).view());
    paired->seen(1, kNow + 10);
    tokens.emplace_back(paired->add(std::string(100, 'x') + "\n\x1b", kNow + 20).view());
  }
  const auto file = folder / "browsers";
  struct stat facts {};
  ASSERT_EQ(::stat(file.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0600U);
  auto again = PairedBrowsers::open(folder / "").value();
  EXPECT_TRUE(again.find(tokens[0])) << "it was used last but one";
  EXPECT_FALSE(again.find(tokens[1])) << "the one that was not used for longest made room";
  for (std::size_t i = 2; i < tokens.size(); ++i) EXPECT_TRUE(again.find(tokens[i])) << i;
  EXPECT_EQ(count(again), PairedBrowsers::kMost);
  const auto first = std::ranges::find(again.list(), 1U, &PairedBrowsers::Browser::number);
  EXPECT_STREQ(first->name, "phone");
  EXPECT_EQ(first->paired_at, kNow);
  const auto last = std::ranges::find(again.list(), 17U, &PairedBrowsers::Browser::number);
  EXPECT_EQ(std::string(last->name), std::string(47, 'x'));

  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (std::string damaged : {bytes.substr(0, 100), bytes.substr(0, bytes.size() - 1), bytes}) {
    if (damaged.size() == bytes.size()) damaged[damaged.size() / 2] ^= 1;
    std::filesystem::resize_file(file, 0);
    std::ofstream(file, std::ios::binary) << damaged;
    EXPECT_EQ(count(PairedBrowsers::open(folder / "").value()), 0U) << "what is not whole is not believed";
  }
  EXPECT_FALSE(PairedBrowsers::open(folder / "none"));
}

TEST(PairedBrowsers, CanBeForgottenForGood) {
  const TemporaryFolder folder;
  auto paired = PairedBrowsers::open(folder / "").value();
  const auto phone = paired.add("phone", kNow), laptop = paired.add("laptop", kNow);
  EXPECT_FALSE(paired.forget(0));
  EXPECT_FALSE(paired.forget(3));
  EXPECT_TRUE(paired.forget(1));
  EXPECT_FALSE(paired.forget(1));
  const auto again = PairedBrowsers::open(folder / "").value();
  for (const PairedBrowsers* one : {static_cast<const PairedBrowsers*>(&paired), &again}) {
    EXPECT_FALSE(one->find(phone.view()));
    EXPECT_EQ(one->find(laptop.view()), 2U);
  }
  paired.add("tablet", kNow);
  EXPECT_FALSE(std::ranges::any_of(paired.list(), [](const auto& one) { return one.number == 1; }))
      << "no number twice";
}

TEST(PairedBrowsers, OfAnOlderPlumblineStayPaired) {
  const TemporaryFolder folder;
  std::string tokens(256, '\0');
  for (int i = 0; i < 16; ++i) tokens[static_cast<std::size_t>(i)] = static_cast<char>(i + 1);
  std::ofstream(folder / "browsers", std::ios::binary) << tokens;
  auto paired = PairedBrowsers::open(folder / "").value();
  EXPECT_EQ(paired.find("0102030405060708090a0b0c0d0e0f10"), 1U);
  EXPECT_EQ(count(paired), 1U);
  paired.add("phone", kNow);
  EXPECT_EQ(PairedBrowsers::open(folder / "")->find("0102030405060708090a0b0c0d0e0f10"), 1U);
}

}  // namespace
}  // namespace plumbline::firmware
