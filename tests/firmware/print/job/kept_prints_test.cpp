#include "firmware/print/job/kept_prints.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class KeptPrintsTest : public ::testing::Test {
 protected:
  KeptPrints open() {
    told_.clear();
    auto prints = KeptPrints::open(folder_ / ".", [this](std::string_view text) { told_.emplace_back(text); });
    EXPECT_TRUE(prints) << prints.error().message();
    return std::move(*prints);
  }
  static Status keep(KeptPrints& prints, const std::string& scan, const std::string& report,
                     std::string_view png = "") {
    KeptPrint facts;
    facts.scan = short_name(scan);
    facts.layers = 7;
    return prints.keep(
        facts, [&](TextSink& out) { return out.write(report); }, std::as_bytes(std::span(png)));
  }
  static std::string read(const KeptPrints& prints, std::uint32_t number, KeptPrints::Part part,
                          std::uint64_t from = 0) {
    std::array<std::byte, 64> room{};
    const auto got = prints.read(number, part, from, room);
    if (!got) return std::string(got.error().finding());
    return {reinterpret_cast<const char*>(room.data()), got->bytes};
  }
  static std::vector<std::uint32_t> numbers(const KeptPrints& prints) {
    std::vector<std::uint32_t> all;
    for (const KeptPrint& print : prints.list()) all.push_back(print.number);
    return all;
  }
  std::string file(const std::string& name) const { return folder_ / ("prints/" + name); }

  TemporaryFolder folder_;
  std::vector<std::string> told_;
};

TEST_F(KeptPrintsTest, OutliveTheProgramNewestFirst) {
  {
    KeptPrints prints = open();
    EXPECT_THAT(prints.list(), IsEmpty());
    ASSERT_TRUE(keep(prints, "bust.ply", "{\"a\": 1}\n", "PNG1"));
    ASSERT_TRUE(keep(prints, "gear.stl", "{\"b\": 2}\n"));
  }
  const KeptPrints prints = open();
  EXPECT_THAT(told_, IsEmpty());
  EXPECT_THAT(numbers(prints), ElementsAre(2, 1));
  EXPECT_EQ(view(prints.list()[1].scan), "bust.ply");
  EXPECT_EQ(prints.list()[0].layers, 7U);
  EXPECT_EQ(read(prints, 1, KeptPrints::Part::kReport), "{\"a\": 1}\n");
  EXPECT_EQ(read(prints, 1, KeptPrints::Part::kReport, 5), " 1}\n") << "the preview is no part of it";
  EXPECT_EQ(read(prints, 1, KeptPrints::Part::kReport, 9), "");
  EXPECT_EQ(read(prints, 1, KeptPrints::Part::kPreview), "PNG1");
  EXPECT_EQ(read(prints, 2, KeptPrints::Part::kPreview), "print 2 has no preview");
  EXPECT_EQ(read(prints, 3, KeptPrints::Part::kReport), "print 3 is not kept");
}

TEST_F(KeptPrintsTest, AreBoundedInNumberAndBytes) {
  KeptPrints prints = open();
  for (std::size_t i = 0; i < KeptPrints::kMost + 3; ++i) ASSERT_TRUE(keep(prints, "a.ply", "{}\n"));
  EXPECT_EQ(prints.list().size(), KeptPrints::kMost);
  EXPECT_EQ(numbers(prints).back(), 4U);
  EXPECT_FALSE(std::filesystem::exists(file("00000003")));
  // Five of 7 MiB are more than 32 MiB.
  const std::string large(std::size_t{7} << 20U, ' ');
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(keep(prints, "b.ply", large));
  EXPECT_THAT(numbers(prints), ElementsAre(20, 19, 18, 17));
  const auto too_long = keep(prints, "c.ply", large + large);
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().code(), ErrorCode::kCannotWrite);
  EXPECT_FALSE(std::filesystem::exists(file("new")));
  EXPECT_THAT(numbers(open()), ElementsAre(20, 19, 18, 17));
}

TEST_F(KeptPrintsTest, ATornOneIsRemovedWithAWord) {
  {
    KeptPrints prints = open();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(keep(prints, "a.ply", "{\"layers\": 1200}\n", "PNG"));
  }
  std::filesystem::resize_file(file("00000001"), std::filesystem::file_size(file("00000001")) - 1);
  std::filesystem::resize_file(file("00000002"), 0);
  std::fstream flip(file("00000003"), std::ios::in | std::ios::out | std::ios::binary);
  flip.seekp(-12, std::ios::end);
  flip.put('x');
  flip.close();
  std::filesystem::remove(file("00000004"));
  std::filesystem::create_symlink("00000005", file("00000004"));
  std::ofstream(file("new")) << "half";
  std::ofstream(file("notes.txt")) << "somebody's";
  const KeptPrints prints = open();
  EXPECT_THAT(numbers(prints), ElementsAre(5));
  EXPECT_THAT(told_,
              ElementsAre(HasSubstr("the power went"), HasSubstr("print 1 is damaged"), HasSubstr("print 2 is damaged"),
                          HasSubstr("print 3 is damaged"), HasSubstr("print 4 is damaged")));
  EXPECT_FALSE(std::filesystem::exists(file("new")));
  EXPECT_TRUE(std::filesystem::exists(file("notes.txt")));
  EXPECT_TRUE(std::filesystem::exists(file("00000005")));
}

TEST_F(KeptPrintsTest, OneThatCantBeWrittenLeavesTheOthers) {
  KeptPrints prints = open();
  ASSERT_TRUE(keep(prints, "a.ply", "{}\n"));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 4096;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto kept = keep(prints, "b.ply", std::string(8000, ' '));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(kept);
  EXPECT_THAT(std::string(kept.error().finding()), HasSubstr("the print's report can't be kept: File too large"));
  EXPECT_FALSE(std::filesystem::exists(file("new")));
  EXPECT_THAT(numbers(prints), ElementsAre(1));
  ASSERT_TRUE(keep(prints, "b.ply", "{}\n"));
  EXPECT_THAT(numbers(prints), ElementsAre(2, 1));
}

}  // namespace
}  // namespace plumbline::firmware
