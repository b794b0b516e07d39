#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;
using std::string_literals::operator""s;

TEST(FormatProbe, NamesAFormatThatIsNoScanAndSaysWhatToDo) {
  const std::tuple<std::string, const char*, const char*> cases[] = {
      {"\x1f\x8b\x08\x00 rest"s, "gzip", "unpack it"},
      {"PK\x03\x04 rest", "zip", "unpack it"},
      {"glTF rest", "glTF", "export the mesh as STL"},
      {"ISO-10303-21;\nHEADER;", "STEP", "export the mesh as STL"},
      {"BLENDER-v300", "a Blender project", "export the mesh as STL"},
      {"3D Geometry File Format 5", "a Rhino model", "export the mesh as STL"},
      {"#VRML V2.0 utf8\n", "VRML", "export the mesh as STL"},
      {"<!DOCTYPE html>\n<html>", "a web page", "download the file itself"},
      {"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS", "git lfs pull"},
      {"7z\xbc\xaf\x27\x1c rest", "7z", "unpack it"},
  };
  for (const auto& [bytes, what, advice] : cases) {
    const auto reading = read(bytes, "scan.bin");
    EXPECT_EQ(reading.code(), ErrorCode::kUnknownFormat) << what;
    EXPECT_THAT(reading.message(), HasSubstr("scan.bin: "));
    EXPECT_THAT(reading.message(), HasSubstr(what));
    EXPECT_THAT(reading.message(), HasSubstr(advice));
    EXPECT_EQ(reading.sink.begun, 0);
  }
}

TEST(FormatProbe, AMeshWithoutPointsIsNotReadAsAScan) {
  const std::pair<std::string, const char*> cases[] = {
      {"solid cube\nfacet normal 0 0 1\n", "STL"},
      {std::string(80, 'h') + little(1U) + std::string(50, '\0'), "STL"},
      {"OFF\n8 6 0\n", "OFF"},
      {"NOFF 8 6 0\n", "OFF"},
  };
  for (const auto& [bytes, what] : cases) {
    const auto reading = read(bytes, "scan.bin");
    EXPECT_EQ(reading.code(), ErrorCode::kUnsupported) << what;
    EXPECT_THAT(reading.message(), HasSubstr("scan.bin: this is "s + what));
    EXPECT_THAT(reading.message(), HasSubstr("slice it as a mesh"));
    EXPECT_EQ(reading.sink.begun, 0);
  }
}

TEST(FormatProbe, RefusesWideTextWithAndWithoutByteOrderMark) {
  std::string wide, swapped, four;
  for (const char c : "v 1 2 3\nv 4 5 6\n"s) {
    wide += c;
    wide += '\0';
    swapped += '\0';
    swapped += c;
    four += c + "\0\0\0"s;
  }
  for (const auto& bytes : {"\xff\xfe" + wide, "\xfe\xff" + swapped, wide, swapped}) {
    const auto reading = read(bytes, "scan.obj");
    EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
    EXPECT_THAT(reading.message(), HasSubstr("UTF-16"));
    EXPECT_THAT(reading.message(), HasSubstr("save it as UTF-8"));
  }
  const auto reading = read("\xff\xfe\0\0"s + four, "scan.obj");
  EXPECT_EQ(reading.code(), ErrorCode::kUnsupported);
  EXPECT_THAT(reading.message(), HasSubstr("UTF-32"));
}

TEST(FormatProbe, FindsNoPointsInAnEmptyFile) {
  for (const char* name : {"a.ply", "a.obj", "a.xyz", "a"}) EXPECT_EQ(read("", name).code(), ErrorCode::kNoPoints);
  EXPECT_THAT(read("", "a.ply").message(), HasSubstr("0 bytes"));
}

TEST(FormatProbe, PrefersTheBytesToTheName) {
  EXPECT_EQ(read("v 1 2 3\n", "scan.xyz").summary->header.format, ScanFormat::kObj);
  EXPECT_EQ(read("1 2 3\n", "scan.ply").summary->header.format, ScanFormat::kXyz);
  EXPECT_EQ(read("# hello\n\n  mtllib x\nv 1 2 3\n", "scan").summary->header.format, ScanFormat::kObj);
}

TEST(FormatProbe, UsesTheNameIfTheFirstLineIsUndecided) {
  const std::string table = "left right up\n1 2 3\n";
  EXPECT_EQ(read(table, "SCAN.XYZ").summary->header.format, ScanFormat::kXyz);
  EXPECT_EQ(read(table, "scan.csv").summary->header.format, ScanFormat::kXyz);
  EXPECT_EQ(read(table, "scan.xyzrgb").summary->header.format, ScanFormat::kXyz);
  EXPECT_EQ(read(table, "scan").code(), ErrorCode::kUnknownFormat);
  EXPECT_EQ(read("exported by a program\nv 1 2 3\n", "scan.obj").summary->header.format, ScanFormat::kObj);
}

TEST(FormatProbe, RefusesBinaryRubbishUnderAnyName) {
  const auto rubbish = "\x01\x00\x00\x00\x03\x7f\x00\x00 abc\n"s;
  for (const char* name : {"a.ply", "a.obj", "a.xyz", "a.pcd", "a.meshb"}) {
    const auto reading = read(rubbish, name);
    EXPECT_EQ(reading.code(), ErrorCode::kUnknownFormat) << name;
    EXPECT_EQ(reading.message().find('\x01'), std::string::npos) << "control bytes must not reach a terminal";
  }
}

TEST(FormatProbe, IgnoresAWordThatOnlyBeginsLikeASignature) {
  EXPECT_EQ(read("plywood\n", "a").code(), ErrorCode::kUnknownFormat);
  EXPECT_EQ(read("OFFSET 1\n", "a").code(), ErrorCode::kUnknownFormat);
}

TEST(FormatProbe, ALongNameLeavesRoomForTheReason) {
  std::string name(1000, 'd');
  name += "/bust.ply";
  const auto reading = read("", name);
  EXPECT_THAT(reading.message(), HasSubstr("/bust.ply: the file is empty"));
}

}  // namespace
}  // namespace plumbline::testing
