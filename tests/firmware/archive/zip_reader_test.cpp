#include "firmware/archive/zip_reader.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace plumbline::firmware {
namespace {

std::string little_endian(std::uint64_t number, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text.push_back(static_cast<char>(number >> (8 * i)));
  return text;
}

/// The directory of an archive, whose entries lie at its beginning.
/// @param claimed  how many entries its end says that it has
std::string directory_of(std::uint64_t entries, std::uint64_t claimed) {
  const std::string entry = "PK\x01\x02" + std::string(24, '\0') + little_endian(1, 2) + std::string(16, '\0') + "a";
  std::string bytes;
  for (std::uint64_t i = 0; i < entries; ++i) bytes += entry;
  const std::uint64_t size = bytes.size();
  return bytes + "PK\x05\x06" + std::string(4, '\0') + little_endian(claimed, 2) + little_endian(claimed, 2) +
         little_endian(size, 4) + std::string(6, '\0');
}

struct ZipWalk {
  explicit ZipWalk(const std::string& bytes) {
    auto zip = ZipReader::open(std::as_bytes(std::span(bytes)), "part.sl1");
    if (!zip) {
      result = tl::unexpected<Error>(zip.error());
      return;
    }
    result = zip->for_each([this](std::string_view, const ZipPlace&) -> Status {
      ++entries;
      return {};
    });
  }
  Status result;
  std::uint64_t entries = 0;
};

TEST(ZipReader, VisitsTheEntriesOfItsDirectory) {
  const ZipWalk walk(directory_of(1000, 1000));
  EXPECT_TRUE(walk.result) << walk.result.error().message();
  EXPECT_EQ(walk.entries, 1000U);
}

TEST(ZipReader, RefusesADirectoryThatGoesOnBehindItsEnd) {
  for (const std::uint64_t claimed : {1U, 10U, 141U}) {
    const ZipWalk walk(directory_of(142, claimed));
    ASSERT_FALSE(walk.result) << claimed;
    EXPECT_STREQ(walk.result.error().message(), ("part.sl1: holds more files than the " + std::to_string(claimed) +
                                                 " that its end declares. Copy or export it again")
                                                    .c_str());
  }
  EXPECT_FALSE(ZipWalk(directory_of(10, 142)).result);
}

// A directory with 2^16 - 1 entries or more has this number where it has no longer one elsewhere, and is read to its end.
TEST(ZipReader, RefusesTooManyEntriesWhateverTheirNumberIsSaidToBe) {
  const ZipWalk walk(directory_of(ZipReader::kMostEntries + 1, 0xffff));
  ASSERT_FALSE(walk.result);
  EXPECT_EQ(walk.result.error().code(), ErrorCode::kUnsupported) << walk.result.error().message();
  EXPECT_EQ(walk.entries, ZipReader::kMostEntries);
}

}  // namespace
}  // namespace plumbline::firmware
