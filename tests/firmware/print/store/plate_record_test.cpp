#include "firmware/print/store/plate_record.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline {
namespace {

using ::testing::HasSubstr;

TEST(PlateRecord, OutlivesTheProgramThatWroteIt) {
  const TemporaryFolder folder;
  const auto reopened = [&] { return PlateRecord::open(folder / ".").value(); };
  EXPECT_FALSE(reopened().is_empty()) << "nobody has looked at a new printer's plate";
  ASSERT_TRUE(reopened().confirm_empty());
  EXPECT_TRUE(reopened().is_empty());
  ASSERT_TRUE(reopened().take());
  EXPECT_FALSE(reopened().is_empty());
  ASSERT_TRUE(reopened().take()) << "a resumed print takes it again";
}

TEST(PlateRecord, CountsAsInUseIfItCantBeKept) {
  const TemporaryFolder folder;
  // Not a file, and it can't be removed or written.
  std::filesystem::create_directories(folder / "plate-is-empty/x");
  auto record = PlateRecord::open(folder / ".");
  ASSERT_TRUE(record);
  EXPECT_FALSE(record->is_empty());
  const auto confirmed = record->confirm_empty();
  ASSERT_FALSE(confirmed);
  EXPECT_EQ(confirmed.error().code(), ErrorCode::kCannotWrite);
  EXPECT_THAT(confirmed.error().message(), HasSubstr("plate-is-empty"));
  EXPECT_FALSE(record->is_empty());
  EXPECT_FALSE(record->take());
}

}  // namespace
}  // namespace plumbline
