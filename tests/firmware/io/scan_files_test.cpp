#include "firmware/io/scan_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> names(const std::vector<std::string>& paths) {
  const auto files = ScanFiles::open(paths);
  return files ? files->names() : std::vector<std::string>{files.error().message()};
}

TEST(ScanFiles, ComeWithTheConfThatSaysWhereTheyLie) {
  const TemporaryFolder folder;
  for (const char* name : {"bun000.ply", "ear.ply", "other.ply"}) write_text(folder / name, "ply\n");
  write_text(folder / "bun.conf", "camera 0 0 0\nbmesh bun000.ply 0 0 0 0 0 0 1\nbmesh ear.ply 0 0 0 0 0 0 1\n");
  write_text(folder / "network.conf", "bmesh bun\nuser ear.ply\n");
  EXPECT_THAT(names({folder / "ear.ply", folder / "bun000.ply"}), ElementsAre("ear.ply", "bun000.ply", "bun.conf"));
  EXPECT_THAT(names({folder / "bun.conf", folder / "ear.ply"}), ElementsAre("ear.ply", "bun.conf"));
  EXPECT_THAT(names({folder / "bun000.ply"}), ElementsAre("bun000.ply"));
  std::filesystem::remove(folder / "network.conf");
  std::filesystem::remove(folder / "other.ply");
  EXPECT_THAT(names({folder / ""}), ElementsAre("bun000.ply", "ear.ply", "bun.conf"));
}

}  // namespace
}  // namespace plumbline::firmware
