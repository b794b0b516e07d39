#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;

/// A quarter turn about z, then a shift by 10 20 30, for row vectors.
const std::string kPtxTurned = "10 20 30\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n";
const std::string kPtxPlain = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

TEST(PtxReader, MovesEachScanToTheCommonFrame) {
  const std::string file = "2\n1\n" + kPtxPlain + "1 2 3 0.5\n4 5 6 0.5 255 0 0\n" +  //
                           "1\n2\n" + kPtxTurned + "1 2 3 0.5\n4 5 6 0.25\n";
  const std::vector<ScanPoint> wanted = {
      {1, 2, 3, 0, 0, 0}, {4, 5, 6, 0, 0, 0}, {10 - 2, 20 + 1, 33, 0, 0, 0}, {10 - 5, 20 + 4, 36, 0, 0, 0}};
  for (const char* name : {"scan.ptx", "scan", "scan.txt"}) {
    for (const auto& text :
         {file, replaced(file, "\n", "\r\n"), replaced(file, "\n", "\n\n"), replaced(file, " ", "\t ")}) {
      auto reading = read(text, name, {11});
      ASSERT_TRUE(reading.summary.has_value()) << reading.message();
      EXPECT_EQ(reading.summary->header.format, ScanFormat::kPtx);
      EXPECT_TRUE(same_points(reading.points(), wanted));
    }
  }
}

TEST(PtxReader, LeavesOutRaysThatReturnedNothing) {
  const auto reading = read("3\n1\n" + kPtxTurned + "0 0 0 0.5\n1 2 3 0.1\n0.000000 -0.0 0 0 0 0 0\n", "scan.ptx");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->points, 1U);
  EXPECT_EQ(reading.summary->left_out, 2U);
}

TEST(PtxReader, ReadsAFileWhoseFirstScanIsEmpty) {
  const auto reading = read("0\n0\n" + kPtxPlain + "1\n1\n" + kPtxTurned + "1 2 3 .5\n", "scan.ptx");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->header.format, ScanFormat::kPtx);
  EXPECT_EQ(reading.summary->points, 1U);
}

TEST(PtxReader, BeginsAViewWithEachScan) {
  const std::string placed = replaced(kPtxPlain, "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1", "7 8 9\n1 0 0\n0 1 0\n0 0 1\n1");
  const auto reading = read("2\n1\n" + kPtxPlain + "1 2 3 .5\n4 5 6 .5\n" +  // a list: nobody knows from where
                                "1\n1\n" + kPtxTurned + "1 2 3 .5\n" +       // by the transform
                                "2\n2\n" + kPtxPlain + "1 2 3 .5\n0 0 0 .5\n0 0 0 .5\n1 2 4 .5\n" +  // a grid
                                "1\n1\n" + placed + "1 2 3 .5\n",  // by the header alone
                            "scan.ptx");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.sink.complaint, "");
  const std::vector<BegunView> wanted = {
      {0, std::nullopt}, {2, Vec3d(10, 20, 30)}, {3, Vec3d(0, 0, 0)}, {5, Vec3d(7, 8, 9)}};
  EXPECT_EQ(reading.sink.views, wanted);
}

TEST(PtxReader, NamesTheLineWithTheError) {
  EXPECT_THAT(read("2\n1\n" + kPtxPlain + "1 2 3 .5\n", "a.ptx").message(),
              HasSubstr("a.ptx: the file ends after line 11, with 1 of the 2 points of a scan"));
  EXPECT_THAT(read("1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 x\n", "a.ptx").message(),
              HasSubstr("line 6: expected 3 numbers for the scanner's axes, found '0 0 x'"));
  EXPECT_THAT(read("1\n1\n0 0 0\n", "a.ptx").message(),
              HasSubstr("the file ends after line 3, before the scanner's axes"));
  EXPECT_THAT(read("1\n1\n" + replaced(kPtxPlain, "0 0 0 1", "0 0 0") + "1 2 3 .5\n", "a.ptx").message(),
              HasSubstr("line 10: expected 4 numbers for the scan's transform"));
  EXPECT_THAT(read("1\n1\n" + replaced(kPtxPlain, "1 0 0 0", "1 0 0 5") + "1 2 3 .5\n", "a.ptx").message(),
              HasSubstr("line 7: the last column of a scan's transform must be 0 0 0 1"));
  EXPECT_THAT(read("1\n1\n" + replaced(kPtxPlain, "0 0 1 0", "0 0 0 0") + "1 2 3 .5\n", "a.ptx").message(),
              HasSubstr("line 10: the scan's transform makes it flat"));
  EXPECT_THAT(read("1\n1\n" + kPtxPlain + "1 2 3 .5\n1 2 3 .5\n", "a.ptx").message(),
              HasSubstr("line 12: expected the number of columns of a scan, found '1 2 3 .5'"));
  EXPECT_THAT(read("1\n1\n" + kPtxPlain + "1 2 3 .5\n1\n", "a.ptx").message(), HasSubstr("before the rows of a scan"));
  EXPECT_THAT(read("1\n1\n" + kPtxPlain + "1 two 3\n", "a.ptx").message(),
              HasSubstr("line 11: expected a number for y, found 'two'"));
  EXPECT_EQ(read("99999999999\n99999999999\n" + kPtxPlain + "1 2 3\n", "a.ptx").code(), ErrorCode::kTruncated);
}

}  // namespace
}  // namespace plumbline::testing
