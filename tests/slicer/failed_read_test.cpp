/// Slices scans whose medium fails: at every read, once with an error and once as if the file ended there.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/slicer/support/slicing.hpp"
#include "tests/slicer/support/surface_files.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::size_t kBlock = 4096;  ///< bytes a read

/// One read fails, and all after it.
class FailingSource final : public ByteSource {
 public:
  FailingSource(const SurfaceFile& file, std::uint32_t failing, bool with_error)
      : file_(file), source_(file.bytes, file.name, {kBlock}), failing_(failing), with_error_(with_error) {}
  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    if (reads_++ < failing_) return source_.read(buffer);
    if (with_error_) return fail(ErrorCode::kCannotRead, "%s: Input/output error", file_.name);
    return std::size_t{0};
  }
  std::string_view name() const override { return source_.name(); }
  std::optional<std::uint64_t> size() const override { return source_.size(); }

 private:
  const SurfaceFile& file_;
  MemorySource source_;
  std::uint32_t failing_;
  bool with_error_;
  std::uint32_t reads_ = 0;
};

/// Slices files of which the last fails.
void expect_failure(std::vector<ByteSource*> sources, bool with_error, const SurfaceFile& failing) {
  ArenaBlock arena(16 * kMiB);
  SliceReport report;
  const auto rrep = slice(sources, settings_with_pitch(0.4F), *arena, nullptr, report);
  ASSERT_FALSE(rrep.has_value());
  EXPECT_THAT(rrep.error().message(), StartsWith(failing.name));
  if (with_error) {
    EXPECT_EQ(rrep.error().code(), ErrorCode::kCannotRead);
    EXPECT_THAT(rrep.error().message(), HasSubstr("Input/output error"));
  } else {
    EXPECT_NE(rrep.error().code(), ErrorCode::kNoSurface) << "half a scan must not be sliced";
    EXPECT_THAT(rrep.error().message(), HasSubstr("again"));
  }
  EXPECT_EQ(arena->used(), 0U);
}

Surface small_ball() { return sphere(2000, 5, Vec3d::Zero()); }

TEST(FailedRead, IsAnErrorAtAnyReadOfAScan) {
  for (const SurfaceFile& file : files_of(small_ball())) {
    ASSERT_GT(file.bytes.size(), 5 * kBlock);
    for (std::uint32_t read = 0; read * kBlock < file.bytes.size(); ++read) {
      for (const bool with_error : {true, false}) {
        SCOPED_TRACE(file.name + std::string(with_error ? " fails" : " ends") + " at read " + std::to_string(read));
        FailingSource source(file, read, with_error);
        expect_failure({&source}, with_error, file);
      }
    }
  }
}

TEST(FailedRead, IsAnErrorInALaterFileToo) {
  const auto files = files_of(small_ball());
  for (const SurfaceFile& file : files) {
    const SurfaceFile failing{"second.part", file.bytes};
    for (std::uint32_t read = 0; read * kBlock < file.bytes.size(); ++read) {
      for (const bool with_error : {true, false}) {
        SCOPED_TRACE(file.name + std::string(with_error ? " fails" : " ends") + " at read " + std::to_string(read));
        MemorySource first(files[0].bytes, files[0].name);
        FailingSource source(failing, read, with_error);
        expect_failure({&first, &source}, with_error, failing);
      }
    }
  }
}

}  // namespace
}  // namespace plumbline
