#include "slicer/reader/scan_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;

struct Sample {
  const char* name;
  std::string bytes;
};

/// A small file of each format and encoding. 3000 points make several batches.
std::vector<Sample> samples(int points) {
  const auto count = std::to_string(points);
  const std::string properties =
      "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n";
  std::string rows, little_rows, big_rows, before, columns[6];
  for (int i = 0; i < points; ++i) {
    const float values[6] = {static_cast<float>(i) * 0.25F, static_cast<float>(i % 7), -1.5F, 0.6F, 0.8F, 0};
    char row[128];
    std::snprintf(row, sizeof row, "%g %g %g %g %g %g\n", static_cast<double>(values[0]),
                  static_cast<double>(values[1]), static_cast<double>(values[2]), 0.6, 0.8, 0.0);
    rows += row;
    std::string line = row;
    const auto third = line.find(' ', line.find(' ', line.find(' ') + 1) + 1);
    before += "vn" + line.substr(third, line.size() - third) + "v " + line.substr(0, third) + "\n";
    for (int c = 0; c < 6; ++c) {
      little_rows += little(values[c]);
      big_rows += big(values[c]);
      columns[c] += little(values[c]);
    }
  }
  const std::string all = columns[0] + columns[1] + columns[2] + columns[3] + columns[4] + columns[5];
  const auto block = lzf_compress(all);
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F "
      "F F F F\nCOUNT 1 1 1 1 1 1\nWIDTH " +
      count + "\nHEIGHT 1\nPOINTS " + count + "\n";
  return {
      {"ascii.ply", "ply\nformat ascii 1.0\nelement vertex " + count + "\n" + properties + "end_header\n" + rows},
      {"little.ply", "ply\r\nformat binary_little_endian 1.0\r\nelement vertex " + count + "\r\n" +
                         replaced(properties, "\n", "\r\n") + "end_header\r\n" + little_rows},
      {"big.ply", "ply\rformat binary_big_endian 1.0\relement vertex " + count + "\r" +
                      replaced(properties, "\n", "\r") + "end_header\r" + big_rows},
      {"lists.ply", "ply\nformat binary_little_endian 1.0\nelement vertex " + count + "\n" + properties +
                        "property list uchar int l\nend_header\n" +
                        [&] {
                          std::string out;
                          for (std::size_t at = 0; at < little_rows.size(); at += 24) {
                            out += little_rows.substr(at, 24) + "\x01" + "abcd";
                          }
                          return out;
                        }()},
      {"rows.xyz", "# x y z and n\n" + rows},
      {"rows.pts", count + "\r\n" + replaced(rows, "\n", "\r\n")},
      {"ascii.pcd", pcd + "DATA ascii\n" + rows},
      {"binary.pcd", pcd + "DATA binary\n" + little_rows},
      {"compressed.pcd", pcd + "DATA binary_compressed\n" +
                             little(static_cast<std::uint32_t>(block.size()), static_cast<std::uint32_t>(all.size())) +
                             block},
      {"rows.asc", "x;y;z;nx;ny;nz\n" + replaced(replaced(rows, ".", ","), " ", ";")},
      {"points.obj", "o points\n" + before + "f 1 2 3\n"},
  };
}

TEST(ScanReader, ReadsTheSamePointsFromEveryFormat) {
  for (const auto& sample : samples(3000)) {
    const auto reading = read(sample.bytes, sample.name);
    ASSERT_TRUE(reading.summary.has_value()) << reading.message();
    ASSERT_EQ(reading.summary->points, 3000U) << sample.name;
    EXPECT_EQ(reading.sink.complaint, "") << sample.name;
    EXPECT_LE(reading.sink.largest_batch, 1024U);
    EXPECT_TRUE(reading.summary->header.has_normals);
    EXPECT_EQ(reading.summary->bytes, sample.bytes.size());
    for (std::size_t i = 0; i < 3000; ++i) {
      const ScanPoint& p = reading.sink.points[i];
      const bool same = p.x == static_cast<double>(i) * 0.25 && p.y == static_cast<double>(i % 7) && p.z == -1.5 &&
                        p.nx == 0.6F && p.ny == 0.8F && p.nz == 0;
      ASSERT_TRUE(same) << sample.name << " point " << i << ": " << p.x << ' ' << p.y << ' ' << p.z << ' ' << p.nx
                        << ' ' << p.ny;
    }
  }
}

TEST(ScanReader, DoesNotDependOnTheSizeOfTheReads) {
  for (const auto& sample : samples(1500)) {
    const auto whole = read(sample.bytes, sample.name);
    for (const auto& pieces : std::vector<std::vector<std::size_t>>{{1}, {3}, {1, 2, 5000, 7}, {65535}, {4096}}) {
      const auto parts = read(sample.bytes, sample.name, pieces);
      ASSERT_TRUE(parts.summary.has_value()) << parts.message();
      EXPECT_TRUE(same_points(whole.sink.points, parts.sink.points)) << sample.name;
      EXPECT_EQ(whole.summary->bytes, parts.summary->bytes) << sample.name;
    }
  }
}

TEST(ScanReader, ReadsATruncatedFileAsAnErrorOrAsItsFirstPoints) {
  for (const auto& sample : samples(5)) {
    const auto whole = read(sample.bytes, sample.name);
    ASSERT_TRUE(whole.summary.has_value()) << whole.message();
    for (std::size_t length = 0; length < sample.bytes.size(); ++length) {
      const auto cut = read(std::string_view(sample.bytes).substr(0, length), sample.name, {7});
      ASSERT_LE(cut.sink.points.size(), 5U);
      if (cut.summary) {
        EXPECT_EQ(cut.summary->points, cut.sink.points.size());
        // The last number of a text may have lost digits, which no reader can notice. All other rows are whole.
        for (std::size_t i = 0; i + 1 < cut.sink.points.size(); ++i) {
          EXPECT_EQ(cut.sink.points[i].x, whole.sink.points[i].x) << sample.name << " cut at " << length;
          EXPECT_EQ(cut.sink.points[i].z, whole.sink.points[i].z) << sample.name << " cut at " << length;
        }
      } else {
        EXPECT_THAT(cut.message(), HasSubstr(sample.name));
      }
    }
  }
}

TEST(ScanReader, SurvivesAnySingleWrongByte) {
  for (const auto& sample : samples(3)) {
    for (std::size_t at = 0; at < sample.bytes.size(); ++at) {
      for (const int flip : {0x01, 0x20, 0x80, 0xff}) {
        auto bytes = sample.bytes;
        bytes[at] = static_cast<char>(bytes[at] ^ flip);
        const auto reading = read(bytes, sample.name);
        EXPECT_EQ(reading.sink.complaint, "");
        for (const auto& p : reading.sink.points) {
          EXPECT_TRUE(std::isfinite(p.x + p.y + p.z)) << sample.name << " byte " << at;
        }
      }
    }
  }
}

TEST(ScanReader, ReportsProgressByBytesAndEndsAtOne) {
  const auto all = samples(10000);
  const auto reading = read(all[0].bytes, all[0].name);
  ASSERT_TRUE(reading.summary.has_value());
  EXPECT_GE(reading.sink.fractions.size(), all[0].bytes.size() / 100000);
  EXPECT_TRUE(std::is_sorted(reading.sink.fractions.begin(), reading.sink.fractions.end()));
  EXPECT_EQ(reading.sink.fractions.back(), 1.0);
  MemorySource endless(all[0].bytes, all[0].name);
  endless.forget_size();
  EXPECT_TRUE(read(endless).summary.has_value());
}

TEST(ScanReader, StopsWhenTheSinkCancels) {
  for (const auto& sample : samples(8000)) {
    MemorySource source(sample.bytes, sample.name);
    std::vector<std::byte> memory(kReaderWorkspace);
    CollectingSink sink;
    sink.cancel_at = 1;
    const auto summary = read_scan(source, sink, memory);
    ASSERT_FALSE(summary.has_value()) << sample.name;
    EXPECT_EQ(summary.error().code(), ErrorCode::kCancelled);
    EXPECT_EQ(sink.fractions.size(), 1U);
  }
}

TEST(ScanReader, ReturnsErrorsOfSourceAndSinkUnchanged) {
  for (const auto& sample : samples(5000)) {
    for (const std::size_t position : {std::size_t{0}, std::size_t{65536}}) {
      if (position >= sample.bytes.size()) continue;
      MemorySource source(sample.bytes, sample.name);
      source.fail_at(position);
      const auto reading = read(source);
      EXPECT_EQ(reading.code(), ErrorCode::kCannotRead) << sample.name;
      EXPECT_EQ(reading.message(), "the stick was pulled");
    }
    for (const bool at_begin : {true, false}) {
      MemorySource source(sample.bytes, sample.name);
      std::vector<std::byte> memory(kReaderWorkspace);
      CollectingSink sink;
      sink.refuse_begin = at_begin;
      sink.refuse_points = !at_begin;
      const auto summary = read_scan(source, sink, memory);
      ASSERT_FALSE(summary.has_value());
      EXPECT_EQ(summary.error().code(), ErrorCode::kOutOfMemory);
      EXPECT_LE(sink.points.size(), 1024U);
    }
  }
}

TEST(ScanReader, AcceptsAWorkspaceOfAnyAlignment) {
  const auto all = samples(10);
  for (const auto& sample : all) {
    std::vector<std::byte> memory(kReaderWorkspace + 3);
    MemorySource source(sample.bytes, sample.name);
    CollectingSink sink;
    EXPECT_TRUE(read_scan(source, sink, std::span(memory).subspan(3)).has_value()) << sample.name;
  }
}

TEST(ScanReader, ReturnsOutOfMemoryForATooSmallWorkspace) {
  for (const auto& sample : samples(10)) {
    EXPECT_EQ(read(sample.bytes, sample.name, {}, 1024).code(), ErrorCode::kOutOfMemory);
  }
}

/// Files that declare more than they hold, or repeat one thing a million times. Memory and time must not exceed what their
/// bytes need.
TEST(HostileHeaders, EndQuicklyWhateverTheyDeclare) {
  std::string properties;
  for (int i = 0; i < 10000; ++i) properties += "property double p" + std::to_string(i) + "\n";
  std::string lists = replaced(properties, "property double", "property list uint double");
  std::string elements;
  for (int i = 0; i < 1000; ++i) elements += "element e" + std::to_string(i) + " 1\nproperty int a\n";
  std::string fields, ones;
  for (int i = 0; i < 10000; ++i) {
    fields += " f" + std::to_string(i);
    ones += " 1";
  }
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string little_head = "ply\nformat binary_little_endian 1.0\n";
  const std::string ascii_head = "ply\nformat ascii 1.0\n";
  const std::string pcd = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nHEIGHT 1\n";
  const std::pair<std::string, ErrorCode> cases[] = {
      {little_head + "element vertex 9223372036854775808\n" + xyz + "end_header\nabc", ErrorCode::kTruncated},
      {ascii_head + "element vertex 18446744073709551615\n" + xyz + "end_header\n1 2 3\n", ErrorCode::kTruncated},
      {little_head + "element junk 9223372036854775808\n" + xyz + "element vertex 1\n" + xyz + "end_header\nabc",
       ErrorCode::kTruncated},
      {little_head + "element junk 18446744073709551615\nelement vertex 1\n" + xyz + "end_header\nabc",
       ErrorCode::kTruncated},
      {little_head + "element junk 9223372036854775808\nproperty list uint double l\nelement vertex 1\n" + xyz +
           "end_header\n\xff\xff\xff\xff"
           "abc",
       ErrorCode::kTruncated},
      {little_head + "element vertex 1\n" + xyz + "property list uint double l\nend_header\n" +
           little(1.0F, 2.0F, 3.0F) +
           "\xff\xff\xff\xff"
           "abc",
       ErrorCode::kTruncated},
      {little_head + "element vertex 1\nproperty list uint64 double l\n" + xyz + "end_header\n" +
           std::string(8, '\xff'),
       ErrorCode::kMalformed},
      {ascii_head + "element vertex 1\nproperty list uint double l\n" + xyz + "end_header\n4294967295 1 2 3\n",
       ErrorCode::kTruncated},
      {little_head + "element vertex 1000000000000\n" + properties + xyz + "end_header\nabc", ErrorCode::kTruncated},
      {little_head + "element vertex 1\n" + lists + xyz + "end_header\nabc", ErrorCode::kUnsupported},
      {little_head + elements + "element vertex 1\n" + xyz + "end_header\nabc", ErrorCode::kUnsupported},
      {pcd + "WIDTH 18446744073709551615\nDATA ascii\n1 2 3\n", ErrorCode::kTruncated},
      {pcd + "WIDTH 18446744073709551615\nDATA binary\nabc", ErrorCode::kTruncated},
      {pcd + "WIDTH 18446744073709551615\nDATA binary_compressed\n" + std::string(8, '\xff'), ErrorCode::kMalformed},
      {pcd + "WIDTH 357913941\nDATA binary_compressed\n" + little(UINT32_MAX, 4294967292U), ErrorCode::kUnsupported},
      {"VERSION .7\nFIELDS x y z" + fields + "\nWIDTH 1\nDATA ascii\n", ErrorCode::kUnsupported},
      {"VERSION .7\nFIELDS x y z w\nSIZE 4 4 4 4294967295\nTYPE F F F F\nCOUNT 1 1 1 4294967295\nWIDTH 9\nDATA "
       "binary\nabc",
       ErrorCode::kTruncated},
  };
  for (const auto& [bytes, code] : cases) {
    const auto reading = read(bytes, "bomb");
    EXPECT_EQ(reading.code(), code) << bytes.substr(0, 120) << "\n" << reading.message();
    EXPECT_EQ(reading.sink.complaint, "");
  }
}

TEST(HostileHeaders, AllowTenThousandPropertiesThatExist) {
  std::string file = "ply\nformat binary_little_endian 1.0\nelement vertex 2\n";
  for (int i = 0; i < 10000; ++i) file += "property double p\n";
  file += "property uchar x\nproperty uchar y\nproperty uchar z\nend_header\n";
  for (int i = 0; i < 2; ++i) file += std::string(80000, 'p') + "abc";
  auto reading = read(file);
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_TRUE(same_points(reading.points(), {{'a', 'b', 'c', 0, 0, 0}, {'a', 'b', 'c', 0, 0, 0}}));
}

TEST(HostileHeaders, ALineOfAHundredMegabytesTakesNoExtraTimeOrMemory) {
  constexpr std::uint64_t kPieces = 10'000'000;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  const std::tuple<std::string, std::string, std::string, std::optional<ErrorCode>> cases[] = {
      {head + "comment ", "0123456789", "\nend_header\n1 2 3\n", std::nullopt},
      {head + "nonsense", "0123456789", "\nend_header\n1 2 3\n", ErrorCode::kMalformed},
      {head + "end_header\n1 2 3 ", "0123456789", "\n", ErrorCode::kMalformed},
      {head + "end_header\n1 ", "          ", "2 3\n", std::nullopt},
      {"v 1 2 3\nf ", "1 2 3 4 5 ", "\nv 1 2 3\n", std::nullopt},
      {"v 1 2 3\nv ", "          ", "1 2 3\n", ErrorCode::kUnsupported},
      {"1 2 3\n# ", "1 2 3 4 5 ", "\n", std::nullopt},
      {"1 2 3\n", "          ", "1 2 3\n", ErrorCode::kUnsupported},
      {"1 2 3 ", "4 5 6 7 8 ", "\n", std::nullopt},
  };
  for (const auto& [start, piece, tail, code] : cases) {
    RepeatingSource source(start, piece, kPieces, tail, "long");
    const auto reading = read(source);
    EXPECT_EQ(reading.code(), code) << start << ": " << reading.message();
  }
}

}  // namespace
}  // namespace plumbline::testing
