#include "firmware/slice/job_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Everything below a folder, sorted: "layers", "layers/00000.png", ...
std::vector<std::string> tree(const std::string& path) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
    names.push_back(std::filesystem::relative(entry.path(), path).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

/// Writes a complete job with `layers` layers.
void write_job(const std::string& path, std::uint32_t layers) {
  auto directory = JobDirectory::open(path);
  ASSERT_TRUE(directory.has_value()) << directory.error().message();
  ASSERT_TRUE(directory->begin().has_value());
  for (std::uint32_t i = 0; i < layers; ++i) ASSERT_TRUE(directory->write_layer(i, bytes("layer")).has_value());
  ASSERT_TRUE(directory->write_picture(JobPicture::kPreview, bytes("picture")).has_value());
  auto manifest = directory->create_manifest();
  ASSERT_TRUE(manifest.has_value());
  ASSERT_TRUE(manifest->write(std::string_view("{\n  \"plumbline\": {}\n}\n")).has_value());
  EXPECT_FALSE(std::filesystem::exists(path + "/manifest.json")) << "before the job is whole";
  ASSERT_TRUE(directory->finish(*manifest).has_value());
}

/// Expects `path` to be refused for a job, and nothing in it to change.
void expect_refused(const std::string& path, const std::string& reason) {
  const auto before = tree(path);
  const auto directory = JobDirectory::open(path);
  ASSERT_FALSE(directory.has_value());
  EXPECT_EQ(directory.error().code(), ErrorCode::kCannotWrite);
  EXPECT_THAT(directory.error().message(), HasSubstr(reason));
  EXPECT_EQ(tree(path), before);
}

TEST(JobDirectory, CreatesItsParents) {
  const TemporaryFolder folder;
  write_job(folder / "a/b/out", 2);
  EXPECT_THAT(tree(folder / "a/b/out"),
              ElementsAre("layers", "layers/00000.png", "layers/00001.png", "manifest.json", "preview.png"));
}

TEST(JobDirectory, LeavesNothingIfNoJobBegan) {
  const TemporaryFolder folder;
  { const auto directory = JobDirectory::open(folder / "out"); }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(JobDirectory, RemovesLayersOfALongerOlderJob) {
  const TemporaryFolder folder;
  write_job(folder / "out", 5);
  write_job(folder / "out", 2);
  EXPECT_THAT(tree(folder / "out"),
              ElementsAre("layers", "layers/00000.png", "layers/00001.png", "manifest.json", "preview.png"));
}

TEST(JobDirectory, KeepsTheOlderJobUntilTheNewOneBegins) {
  const TemporaryFolder folder;
  write_job(folder / "out", 3);
  const auto before = tree(folder / "out");
  {
    auto directory = JobDirectory::open(folder / "out");
    ASSERT_TRUE(directory.has_value());
    directory->discard();
  }
  EXPECT_EQ(tree(folder / "out"), before);
}

TEST(JobDirectory, HasNoManifestWhileAJobIsBeingWritten) {
  const TemporaryFolder folder;
  write_job(folder / "out", 3);
  auto directory = JobDirectory::open(folder / "out");
  ASSERT_TRUE(directory.has_value());
  ASSERT_TRUE(directory->begin().has_value());
  EXPECT_FALSE(std::filesystem::exists(folder / "out/manifest.json"));
}

TEST(JobDirectory, ReplacesWhatAKilledJobLeft) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "out/layers");
  write_text(folder / "out/layers/00007.png", "cut");
  write_text(folder / "out/manifest.json.part", "cut");
  write_job(folder / "out", 1);
  EXPECT_THAT(tree(folder / "out"), ElementsAre("layers", "layers/00000.png", "manifest.json", "preview.png"));
}

TEST(JobDirectory, IsRemovedWithADiscardedJob) {
  const TemporaryFolder folder;
  auto directory = JobDirectory::open(folder / "out");
  ASSERT_TRUE(directory.has_value());
  ASSERT_TRUE(directory->begin().has_value());
  ASSERT_TRUE(directory->write_layer(0, bytes("layer")).has_value());
  ASSERT_TRUE(directory->create_manifest().has_value());
  directory->discard();
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(JobDirectory, StaysIfItExistedBeforeADiscardedJob) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "out");
  auto directory = JobDirectory::open(folder / "out");
  ASSERT_TRUE(directory.has_value());
  ASSERT_TRUE(directory->begin().has_value());
  ASSERT_TRUE(directory->write_layer(0, bytes("layer")).has_value());
  directory->discard();
  EXPECT_THAT(tree(folder / "out"), IsEmpty());
}

TEST(JobDirectory, SaysWhereThereIsNoRoom) {
  const TemporaryFolder folder;
  auto directory = JobDirectory::open(folder / "out");
  ASSERT_TRUE(directory.has_value());
  EXPECT_TRUE(directory->check_room("the part", 1).has_value());
  const auto refused = directory->check_room("the part", std::uint64_t{1} << 60);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kCannotWrite);
  EXPECT_THAT(refused.error().message(), HasSubstr("out: the part needs some 1152921504606.8 MB, "));
}

TEST(JobDirectory, RefusesAFolderThatHoldsOtherFiles) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "out/layers");
  write_text(folder / "out/thesis.doc", "years of work");
  expect_refused(folder / "out", "holds 'thesis.doc', which plumbline did not write");
}

TEST(JobDirectory, RefusesLayersThatAreNotItsOwn) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "out/layers");
  write_text(folder / "out/layers/00000.png", "layer");
  write_text(folder / "out/layers/holiday.png", "picture");
  expect_refused(folder / "out", "holds 'holiday.png', which is not a layer");
}

TEST(JobDirectory, RefusesAManifestOfAnotherProgram) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "out");
  write_text(folder / "out/manifest.json", "{\"short_name\": \"a web page\"}");
  expect_refused(folder / "out", "holds 'manifest.json', which plumbline did not write");
}

TEST(JobDirectory, RefusesLayersThatAreALink) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "elsewhere");
  std::filesystem::create_directories(folder / "out");
  std::filesystem::create_directory_symlink(folder / "elsewhere", folder / "out/layers");
  expect_refused(folder / "out", "is not a folder");
}

TEST(JobDirectory, ServesOneJobAtATime) {
  const TemporaryFolder folder;
  const auto first = JobDirectory::open(folder / "out");
  ASSERT_TRUE(first.has_value());
  const auto second = JobDirectory::open(folder / "out");
  ASSERT_FALSE(second.has_value());
  EXPECT_THAT(second.error().message(), HasSubstr("another plumbline is writing there"));
}

TEST(JobDirectory, SaysWhyItCannotBeMade) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  const auto on_file = JobDirectory::open(folder / "file");
  ASSERT_FALSE(on_file.has_value());
  EXPECT_THAT(on_file.error().message(), HasSubstr("is a file, not a folder"));
  const auto in_proc = JobDirectory::open("/proc/plumbline");
  ASSERT_FALSE(in_proc.has_value());
  EXPECT_EQ(in_proc.error().code(), ErrorCode::kCannotOpen);
  EXPECT_THAT(in_proc.error().message(), HasSubstr("/proc/plumbline: the folder cannot be created"));
  EXPECT_FALSE(JobDirectory::open("").has_value());
  EXPECT_FALSE(JobDirectory::open(std::string(5000, 'x')).has_value());
}

}  // namespace
}  // namespace plumbline::firmware
