#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace xyz_reader_test {

using ::testing::HasSubstr;
using std::string_literals::operator""s;

void expect_points(Reading reading, const std::vector<ScanPoint>& points, bool normals) {
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.sink.complaint, "");
  EXPECT_TRUE(same_points(reading.points(), points));
  EXPECT_EQ(reading.summary->header.has_normals, normals);
  EXPECT_EQ(reading.summary->header.format, ScanFormat::kXyz);
}
const std::vector<ScanPoint> kTwo = {{1, 2, 3, 0, 0, 0}, {-4, 5.5, 60, 0, 0, 0}};
const std::vector<ScanPoint> kTwoNormals = {{1, 2, 3, 0, 0, 1}, {-4, 5.5, 60, 0.6F, -0.8F, 0}};

TEST(XyzReader, AcceptsEverySeparatorAndLineEnd) {
  for (const char* separator : {" ", "\t", ",", ";", "|", ", ", " ; ", "   "}) {
    for (const char* end : {"\n", "\r\n", "\r", " \n", "\n\n"}) {
      const auto file = replaced(replaced("1_2_3\n-4_5.5_6e1\n", "_", separator), "\n", end);
      expect_points(read(file), kTwo, false);
      expect_points(read(file.substr(0, file.size() - 1)), kTwo, false);
    }
  }
}

TEST(XyzReader, SkipsCommentsAHeaderLineAndAByteOrderMark) {
  expect_points(read("\xef\xbb\xbf# one\n// two\n; three\n  # four\n\nX Y Z\n1 2 3\n# five\n-4 5.5 60\n; six", "a.xyz"),
                kTwo, false);
  expect_points(read("Easting;Northing;Height\n1;2;3\n-4;5.5;60\n", "a.csv"), kTwo, false);
}

TEST(XyzReader, ChecksThePointCountOfPts) {
  expect_points(read("2\n1 2 3\n-4 5.5 60\n"), kTwo, false);
  expect_points(read("1\n1 2 3\n1\n-4 5.5 60\n"), kTwo, false);
  EXPECT_EQ(read("2\n1 2 3\n-4 5.5 60\n").summary->header.declared_points, 2U);
  const auto cut = read("3\n1 2 3\n-4 5.5 60\n", "bust.pts");
  EXPECT_EQ(cut.code(), ErrorCode::kTruncated);
  EXPECT_THAT(cut.message(), HasSubstr("bust.pts: the file ends after line 3, with 2 of the 3 points"));
  EXPECT_EQ(read("1\n1 2 3\n9\n-4 5.5 60\n").code(), ErrorCode::kTruncated);
  EXPECT_EQ(read("18446744073709551615\n1 2 3\n-4 5.5 60\n").code(), ErrorCode::kTruncated);
}

TEST(XyzReader, ReadsPtsWhoseFirstBlocksAreEmpty) {
  const std::string row = "1 2 3 -900 9 9 9\n";
  for (const std::string& text : {"0\n1\n" + row, "0\n0\n1\n" + row, "0\n8\n" + replaced(std::string(8, '!'), "!", row),
                                  "0\n7\n" + replaced(std::string(7, '!'), "!", "1 2 3\n")}) {
    const auto reading = read(text, "merged.pts");
    ASSERT_TRUE(reading.summary.has_value()) << text << reading.message();
    EXPECT_EQ(reading.summary->header.format, ScanFormat::kXyz) << text;
    EXPECT_EQ(reading.summary->points, reading.summary->header.declared_points) << text;
  }
}

TEST(XyzReader, FindsACountBetweenPartsAfterTheSampledRows) {
  std::string part = "100\n";
  for (int i = 0; i < 100; ++i) part += "1 2 3\n";
  const auto reading = read(part + part);
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->points, 200U);
}

TEST(XyzReader, TakesThreeColumnsOfLengthOneForNormals) {
  expect_points(read("1 2 3 0 0 1\n-4 5.5 60 .6 -.8 0\n"), kTwoNormals, true);
  expect_points(read("1 2 3 0 0 1 0.5\n-4 5.5 60 .6 -.8 0 0.5\n"), kTwoNormals, true);
}

TEST(XyzReader, FindsNormalsAfterColoursAndIntensity) {
  expect_points(read("1 2 3 255 0 9 0 0 1\n-4 5.5 60 7 7 7 .6 -.8 0\n"), kTwoNormals, true);
  expect_points(read("1 2 3 -500 255 0 9 0 0 1\n-4 5.5 60 20 7 7 7 .6 -.8 0\n"), kTwoNormals, true);
}

TEST(XyzReader, GivesARowWithoutNormalAZeroNormal) {
  const auto reading = read("1 2 3 0 0 0\n-4 5.5 60 .6 -.8 0\n1 1 1 nan nan nan\n");
  ASSERT_TRUE(reading.summary.has_value());
  EXPECT_TRUE(reading.summary->header.has_normals);
  EXPECT_EQ(reading.summary->without_normal, 2U);
}

TEST(XyzReader, DoesNotTakeColoursIntensitiesOrBlackForNormals) {
  expect_points(read("1 2 3 255 128 0\n-4 5.5 60 1 0 0\n"), kTwo, false);
  expect_points(read("1 2 3 0.5 0.5 0.5\n-4 5.5 60 1 0 0\n"), kTwo, false);
  expect_points(read("1 2 3 0 0 0\n-4 5.5 60 0 0 0\n"), kTwo, false);
  expect_points(read("2\n1 2 3 -812 12 13 14\n-4 5.5 60 -700 1 2 3\n"), kTwo, false);
  expect_points(read("1 2 3 17\n-4 5.5 60 17\n"), kTwo, false);
}

TEST(XyzReader, DecidesByTheFirst64RowsWhetherThereAreNormals) {
  std::string rows;
  for (int i = 0; i < 64; ++i) rows += "1 2 3 0 1 0\n";
  const auto late = read(rows + "1 2 3 9 9 9\n");
  ASSERT_TRUE(late.summary.has_value());
  EXPECT_TRUE(late.summary->header.has_normals);
  EXPECT_EQ(late.sink.points.back().nx, 9);
  const auto in_time = read(rows.substr(0, rows.size() - 12) + "1 2 3 9 9 9\n");
  EXPECT_FALSE(in_time.summary->header.has_normals);
}

TEST(XyzReader, TakesNamedColumnsByTheirNames) {
  expect_points(read("//Nx Ny Nz X Y Z\n0 0 1 1 2 3\n.6 -.8 0 -4 5.5 60\n"), kTwoNormals, true);
  expect_points(read("id,x,y,z\n77,1,2,3\n78,-4,5.5,60\n", "a.csv"), kTwo, false);
  expect_points(read("\"x\",\"y\",\"z\"\n1,2,3\n-4,5.5,60\n", "a.csv"), kTwo, false);
  expect_points(read("Point ID, X ,Y,Z\n77,1,2,3\n78,-4,5.5,60\n", "a.csv"), kTwo, false);
  expect_points(read("Punkt Nr.;x;y;z\n77;1;2;3\n78;-4;5,5;60\n", "a.csv"), kTwo, false);
  expect_points(read(",x,y,z\n77,1,2,3\n78,-4,5.5,60\n", "a.csv"), kTwo, false);
  expect_points(read("Index;X [mm];Y [mm];Z (mm)\n77;1;2;3\n78;-4;5,5;60\n", "a.csv"), kTwo, false);
  expect_points(read("sep=;\r\nx;y;z\r\n1;2;3\r\n-4;5,5;60\r\n", "a.csv"), kTwo, false);
  const std::string wide =
      replaced("aaaaaaaaaaaaaaaa", "a", "a,") + "x,y,z\n" + replaced("7777777777777777", "7", "7,");
  expect_points(read(wide + "1,2,3\n", "a.csv"), {{1, 2, 3, 0, 0, 0}}, false);
  // Names that do not fit the rows are only a comment.
  expect_points(read("# the z of x and y\n1 2 3\n-4 5.5 60\n"), kTwo, false);
}

TEST(XyzReader, RefusesAnEmptyCellBeforeTheLastCoordinate) {
  std::string many;
  for (int i = 0; i < 100; ++i) many += "1,2,3,4\n";
  for (const auto& [file, place] :
       {std::pair("1,2,3,4\n5,,7,8\n"s, "line 2: column 2 is empty in '5,,7,8'"),
        std::pair("1;2;3;4\n5;6;;8\n"s, "line 2: column 3 is empty in '5;6;;8'"),
        std::pair("1,2,3,4\n,6,7,8\n"s, "line 2: column 1 is empty in ',6,7,8'"),
        std::pair("1;2;3;4\n;6;7;8\n"s, "line 2: column 1 is empty in ';6;7;8'"),
        std::pair(";2,5;3,5;4\n5;6;7;8\n"s, "line 1: column 1 is empty in"),
        std::pair("id,x,y,z,r\n1,2,3,4,5\n1,2,3,,5\n"s, "line 3: column 4 is empty in '1,2,3,,5'"),
        std::pair("1,2,3,4\n5, ,7,8\n"s, "line 2: column 2 is empty in '5, ,7,8'"),
        std::pair(many + "5,,7,8\n", "line 101: column 2 is empty in '5,,7,8'")}) {
    const auto reading = read(file, "a.csv");
    EXPECT_EQ(reading.code(), ErrorCode::kMalformed) << file;
    EXPECT_THAT(reading.message(), HasSubstr(place));
  }
  expect_points(read("1,2,3,,7,,\n-4,5.5,60,,7,,\n"), kTwo, false);
  expect_points(read("1,2,3,4\n# a,,b\n-4,5.5,60,4\n"), kTwo, false);
  expect_points(read("1,2,3,\n-4,5.5,60,\n"), kTwo, false);
  expect_points(read("1;2;3\n; 4 points; made by hand\n;4\n;;\n-4;5.5;60\n"), kTwo, false);
}

TEST(XyzReader, RefusesANumberOfThePointAsItsCoordinate) {
  std::string rows, image;
  for (int i = 1; i <= 8; ++i) {
    rows += std::to_string(i) + ",1." + std::to_string(i) + ",2,3,corner\n";
    image += std::to_string(i) + " 1 2 3\n";
  }
  const auto reading = read(rows, "survey.csv");
  EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
  EXPECT_THAT(reading.message(), HasSubstr("survey.csv: line 1: the first column seems to number the points; name"));
  const auto named = read("id,x,y,z\n" + rows, "survey.csv");
  ASSERT_TRUE(named.summary.has_value()) << named.message();
  EXPECT_TRUE(same_point(named.sink.points.back(), {1.8, 2, 3, 0, 0, 0}));
  EXPECT_TRUE(read(image).summary.has_value()) << "the first line of a range image";
}

TEST(XyzReader, DropsAndCountsPointsThatAreNotFinite) {
  const auto reading = read("nan nan nan\n1 2 3\n1e999 0 0\n");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_EQ(reading.summary->points, 1U);
  EXPECT_EQ(reading.summary->not_finite, 2U);
}

TEST(XyzReader, NamesTheLineWithTheError) {
  for (const int rows : {1, 100}) {  // within the sampled rows and after them
    std::string file = "# bust\n";
    for (int i = 0; i < rows; ++i) file += "1 2 3\n";
    const auto line = "line " + std::to_string(rows + 2) + ": ";
    const auto word = read(file + "1 2 x3\n1 2 3\n", "bust.xyz");
    EXPECT_EQ(word.code(), ErrorCode::kMalformed);
    EXPECT_THAT(word.message(), HasSubstr("bust.xyz: " + line + "expected a number for z, found 'x3'"));
    const auto few = read(file + "1 2\n1 2 3\n");
    EXPECT_EQ(few.code(), ErrorCode::kMalformed);
    EXPECT_THAT(few.message(), HasSubstr(line + "too few numbers, z is missing"));
    EXPECT_EQ(read(file + "1 2").code(), ErrorCode::kTruncated);
    EXPECT_EQ(read(file + "1 2 3.e").code(), ErrorCode::kTruncated);
  }
}

TEST(XyzReader, RefusesRowsThatLackTheNormalsOfTheOthers) {
  std::string file;
  for (int i = 0; i < 100; ++i) file += "1 2 3 0 1 0\n";
  EXPECT_EQ(read(file + "1 2 3 0\n").code(), ErrorCode::kMalformed);
  EXPECT_EQ(read("# x y z nx ny nz\n1 2 3 0 1 0\n1 2 3\n1 2 3 0 1 0\n").code(), ErrorCode::kMalformed);
}

TEST(XyzReader, ReadsDecimalCommas) {
  const std::vector<ScanPoint> points = {{1, 2, 3, 0, 0, 0}, {-4, 5.5, 60.25, 0, 0, 0}};
  for (const char* separator : {" ", "\t", ";", " ; ", "   ", "|", "; "}) {
    for (const char* rows :
         {"1,0_2,0_3,0\n-4,0_5,5_60,25\n", "1_2_3\n-4_5,5_60,25\n", "x_y_z\n1_2_3\n# 1.5\n-4,_5,5_60,25e0\n",
          "1,00_2,0_3_255_0_0\n-4_5,50_60,25_1_1_1\n", "2\n1,0_2,0_3,0_0,5\n-4,0_5,5_60,25_0,25\n"}) {
      const auto file = replaced(replaced(rows, "-4,_", "-4_"), "_", separator);
      expect_points(read(file, "a.asc"), points, false);
    }
  }
  expect_points(read("1,0 2,0 3,0 0 0,0 1,0\n-4 5,5 60 0,6 -0,8 0\n"), kTwoNormals, true);
}

TEST(XyzReader, ReadsDecimalCommasAfterTheSampledRows) {
  std::string rows;
  for (int i = 0; i < 100; ++i) rows += "1 2 3\n";
  auto reading = read(rows + "1,5 2,5 3,5\n  # 1.5\n");
  ASSERT_TRUE(reading.summary.has_value()) << reading.message();
  EXPECT_TRUE(same_point(reading.points().back(), {1.5, 2.5, 3.5, 0, 0, 0}));
  const auto mixed = read(rows + "1,5 2,5 3,5\n1.5 2.5 3.5\n", "a.asc");
  EXPECT_EQ(mixed.code(), ErrorCode::kMalformed);
  EXPECT_THAT(mixed.message(),
              HasSubstr("a.asc: line 102: '1.5 2.5 3.5' has a point, but the file has decimal commas"));
  const auto wide = read("1,5 2,5 3,5" + std::string(5000, ' ') + "4\n");
  EXPECT_THAT(wide.message(), HasSubstr("is long"));
}

TEST(XyzReader, ReadsNumbersInQuotes) {
  expect_points(read("\"1\",\"2\",\"3\"\n\"-4\",\"5.5\",\"60\"\n", "a.csv"), kTwo, false);
  expect_points(read("\"x\";\"y\";\"z\"\n\"1\";\"2,0\";\"3\"\n\"-4\";\"5,5\";\"60\"\n", "a.csv"), kTwo, false);
  std::string many = "\"x\",\"y\",\"z\"\n";
  for (int i = 0; i < 100; ++i) many += "\"1\",\"2\",\"3\"\n";
  EXPECT_EQ(read(many, "a.csv").summary->points, 100U);
  EXPECT_THAT(read(many + "\"5\",\"\",\"7\",\"8\"\n", "a.csv").message(), HasSubstr("line 102: column 2 is empty"));
}

TEST(XyzReader, RefusesCommasThatMayBeDecimalOrSeparateNumbers) {
  for (const char* file : {"1,2,3 4,5,6\n", "1,2,3\n1,5 2,5 3,5\n", "1,2 3\n", "1,2;3,4\n", "1,234.5 6.5 7.5\n",
                           "1.234,5 6,5 7,5\n", "1,5 2,5 3.5\n"}) {
    const auto reading = read(file);
    EXPECT_EQ(reading.code(), ErrorCode::kUnsupported) << file;
    EXPECT_THAT(reading.message(), HasSubstr("may be decimal or separate numbers"));
  }
  EXPECT_TRUE(read("1,2,3\n").summary.has_value());
  EXPECT_TRUE(read("1, 2, 3\n").summary.has_value());
  EXPECT_TRUE(read("1 ,2 ,3\n").summary.has_value());
  for (const char* file :
       {"1.5,2.5,3.5,a name of it\n", "1.5, 2.5, 3.5,4.5\n", "1.5 2.5 3.5 a,b\n", "1.5,2.5,3.5 255,0,0 2,0,0\n"}) {
    expect_points(read(file), {{1.5, 2.5, 3.5, 0, 0, 0}}, false);
  }
}

TEST(XyzReader, RefusesTextThatIsNoTable) {
  const auto reading = read("Dear printer,\nplease print my head.\nThanks\n", "letter.txt");
  EXPECT_EQ(reading.code(), ErrorCode::kUnknownFormat);
  EXPECT_EQ(read("# nothing\n", "a.xyz").code(), ErrorCode::kNoPoints);
  EXPECT_EQ(read("X Y Z\n", "a.xyz").code(), ErrorCode::kNoPoints);
  const auto json = read("[[1,2,3],[4,5,6]]", "a.txt");
  EXPECT_EQ(json.code(), ErrorCode::kUnknownFormat);
  EXPECT_THAT(json.message(), HasSubstr("a.txt: line 1: expected a row of numbers x y z, found '[[1,2,3],[4,5,6]]'"));
  EXPECT_EQ(read("1 2\n").code(), ErrorCode::kMalformed);
}

}  // namespace xyz_reader_test
}  // namespace plumbline::testing
