#include "firmware/io/file_source.hpp"

#include <gtest/gtest.h>

#include <array>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

TEST(FileSource, ReadsBytesNameAndSizeOfAFile) {
  const TemporaryFolder folder;
  const std::string content(100'000, 'q');
  write_text(folder / "a.ply", content);
  auto source = FileSource::open(folder / "a.ply");
  ASSERT_TRUE(source.has_value()) << source.error().message();
  EXPECT_EQ(source->name(), "a.ply");
  EXPECT_EQ(source->size(), content.size());
  std::string all;
  std::array<std::byte, 777> buffer = {};
  for (;;) {
    const auto got = source->read(buffer);
    ASSERT_TRUE(got.has_value());
    if (*got == 0) break;
    all.append(reinterpret_cast<const char*>(buffer.data()), *got);
  }
  EXPECT_EQ(all, content);
}

TEST(FileSource, NamesAMissingFile) {
  const auto source = FileSource::open("/nowhere/a.ply");
  ASSERT_FALSE(source.has_value());
  EXPECT_EQ(source.error().code(), ErrorCode::kCannotOpen);
  EXPECT_NE(std::string(source.error().message()).find("/nowhere/a.ply: the scan cannot be opened: No such file"),
            std::string::npos)
      << source.error().message();
}

TEST(FileSource, RefusesADirectory) {
  const auto source = FileSource::open("/tmp");
  ASSERT_FALSE(source.has_value());
  EXPECT_EQ(source.error().code(), ErrorCode::kCannotOpen);
  EXPECT_NE(std::string(source.error().message()).find("is a folder"), std::string::npos);
}

TEST(FileSource, NamesTheByteAtWhichReadingFailed) {
  // A process's first page is never mapped, so reading its memory there fails like a bad sector.
  auto source = FileSource::open("/proc/self/mem");
  ASSERT_TRUE(source.has_value()) << source.error().message();
  std::array<std::byte, 16> buffer = {};
  const auto got = source->read(buffer);
  ASSERT_FALSE(got.has_value());
  EXPECT_EQ(got.error().code(), ErrorCode::kCannotRead);
  EXPECT_NE(std::string(got.error().message()).find("mem: reading failed at byte 0: Input/output error"),
            std::string::npos)
      << got.error().message();
}

}  // namespace
}  // namespace plumbline::firmware
