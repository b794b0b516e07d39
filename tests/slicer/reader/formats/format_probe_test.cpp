#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {
namespace {

using ::testing::HasSubstr;
using std::string_literals::operator""s;

TEST(FormatProbe, NamesAFormatThatIsNoScanAndSaysWhatToDo) {
  const std::tuple<std::string, const char*, const char*> cases[] = {
      {"\x1f\x8b\x08\x00 rest"s, "gzip", "unpack it"},
      {"PK\x03\x04 rest", "zip", "unpack it"},
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

TEST(FormatProbe, NamesForeignFilesByTheirBytes) {
  const std::string iges = "Start" + std::string(67, ' ') + "S      1\n";
  const std::string length = little(std::uint32_t{26});
  const std::pair<std::string, const char*> cases[] = {
      {"glTF\2\0\0\0"s, "is a model that is not read (glTF); export the mesh as STL, OBJ, PLY, OFF or 3MF"},
      {"{ \"asset\": { \"version\": \"2.0\" } }", "(glTF)"},
      {"ISO-10303-21;\nHEADER;", "is a CAD model (STEP); export it as STL or 3MF"},
      {"\xef\xbb\xbfISO-10303-21;\nHEADER;", "(STEP)"},
      {"BLENDER-v300", "is a project (Blender); export its mesh as STL"},
      {"3D Geometry File Format 5", "(Rhino)"},
      {"#VRML V2.0 utf8\n", "(VRML)"},
      {iges + "S      2\n", "is a CAD model (IGES); export it as STL or 3MF"},
      {"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", "(DXF)"},
      {"999\nmade by hand\n0\nSECTION\n", "(DXF)"},
      {"AutoCAD Binary DXF\r\n\x1a\0"s, "(DXF)"},
      {"AC1032\0\0\0"s, "(DWG)"},
      {"**ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz****\n**PARASOLID !", "(Parasolid)"},
      {"400 0 1 0\n11 Box Program 8 ACIS 4.0 24 Thu Jan 1 00:00:00 1998\n25.4 1e-06 1e-10\n", "(ACIS)"},
      {"Version 9.5 JT  DM 7.0.0.0", "(JT)"},
      {"\xff\xfe\xff\x0eS\0k\0e\0t\0c\0h\0U\0p\0 \0M\0o\0d\0e\0l\0"s, "(SketchUp)"},
      {"Kaydara FBX Binary  ", "(FBX)"},
      {"; FBX 7.3.0 project file\n", "(FBX)"},
      {"<?xml version=\"1.0\"?>\n<!-- a <b> -->\n<amf unit=\"mm\">", "(AMF)"},
      {"<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"\">", "(COLLADA)"},
      {"MM" + length + std::string(20, '\1'), "(3D Studio)"},
      {"FORM\0\0\1\0LWO2"s, "(LightWave)"},
      {"xof 0303txt 0032", "(DirectX)"},
      {"*3DSMAX_ASCIIEXPORT\t200\n", "(3D Studio)"},
      {"# vtk DataFile Version 3.0\n", "(VTK)"},
      {"\x19\0\xfd\x12 rest"s, "is sliced for another printer (Chitubox); export it as .sl1"},
      {"ANYCUBIC\0\0\0\0"s, "(Photon Workshop)"},
      {"V3.0\x07\0\0\0DLP\0"s, "(Elegoo)"},
      {"\xff\xd8\xff\xe0 rest", "is a picture (JPEG)"},
      {"GIF89a rest", "is a picture (GIF)"},
      {"II*\0 rest"s, "is a picture (TIFF)"},
      {"BM" + length + std::string(20, '\1'), "is a picture (BMP)"},
      {"RIFF\0\1\0\0WEBPVP8 "s, "is a picture (WebP)"},
      {"\0\0\0\x18"
       "ftypheic\0\0\0\0"s,
       "is a picture (HEIC)"},
      {"; made by a slicer\nM140 S60\nG28\nG1 X1 Y2 Z3\n", "is sliced for a filament printer (G-code)"},
      {"part.stl" + std::string(249, '\0') + "ustar" + std::string(400, '\0'), "is packed"},
  };
  for (const auto& [bytes, words] : cases) {
    for (const char* name : {"part.xyz", "part.stl", "part"}) {
      const auto reading = read(bytes, name);
      EXPECT_EQ(reading.code(), ErrorCode::kUnknownFormat) << words;
      EXPECT_THAT(reading.message(), HasSubstr(words)) << name;
    }
    // Cut off, it may be anything, but nothing is looked for behind its end.
    for (std::size_t bytes_left = 1; bytes_left < std::min<std::size_t>(bytes.size(), 16); ++bytes_left) {
      const auto reading = read(bytes.substr(0, bytes_left), "part");
      EXPECT_EQ(reading.summary.has_value(), reading.message().empty()) << words;
    }
  }
}

TEST(FormatProbe, NamesASlicedPrintUnderTheNameOfAScan) {
  const auto zip_of = [](const std::string& first) {
    return "PK\3\4" + std::string(22, '\0') + little(static_cast<std::uint32_t>(first.size())) + first + " rest";
  };
  for (const char* first : {"config.ini", "layer00000.png", "thumbnail/thumbnail400x400.png"}) {
    for (const char* name : {"part.3mf", "part.stl", "part"}) {
      EXPECT_THAT(read(zip_of(first), name).message(),
                  HasSubstr("this is a print that is sliced already; give it the ending .sl1 to print it"));
    }
    EXPECT_THAT(read(zip_of(first), "part.zip").message(), HasSubstr("sliced already; print it, or check it"));
  }
  EXPECT_THAT(read(zip_of("Metadata/plate_1.png"), "part.stl").message(),
              HasSubstr("this is a zip archive; unpack it"));
}

TEST(FormatProbe, TellsTheKindOfAForeignFileAsACodeWithItsName) {
  const std::string ole = "\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1 rest";
  for (const auto& [bytes, name, code] :
       {std::tuple("ISO-10303-21;\n"s, "part.stl", ToldCode::kForeignCad),
        std::tuple("\x19\0\xfd\x12 rest"s, "part.ctb", ToldCode::kForeignPrint),
        std::tuple("glTF\2\0"s, "part.glb", ToldCode::kForeignModel),
        std::tuple("PK\3\4 rest"s, "part.lys", ToldCode::kForeignProject),
        std::tuple("PK\3\4 rest"s, "part.zip", ToldCode::kPacked),
        std::tuple("7z\xbc\xaf\x27\x1c"s, "part.7z", ToldCode::kPacked),
        std::tuple("PK\3\4"s + std::string(22, '\0') + "\n\0\0\0config.ini"s, "part.stl", ToldCode::kSlicedPrint),
        std::tuple(ole, "part", ToldCode::kForeignCad), std::tuple("<!DOCTYPE html>"s, "part.stl", ToldCode::kWebPage),
        std::tuple("\xff\xfe\x31\0"s, "part.xyz", ToldCode::kWideText),
        std::tuple("\xff\xd8\xff\xe0"s, "part.obj", ToldCode::kPicture)}) {
    const auto reading = read(bytes, name);
    ASSERT_FALSE(reading.summary.has_value()) << name;
    EXPECT_EQ(reading.summary.error().told().code, code) << name;
    EXPECT_EQ(reading.summary.error().told().name(), name);
  }
}

TEST(FormatProbe, NamesForeignFilesByTheirNamesWhereTheBytesSayNothing) {
  const std::string ole = "\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1 rest";
  const std::string rubbish = "\x01\x02\0\0\x03\x7f\0\0 abc\n"s;
  for (const auto& [bytes, name, words] : {std::tuple(ole, "part.SLDPRT", "is a CAD model (SolidWorks)"),
                                           std::tuple(ole, "part.ipt", "is a CAD model (Inventor)"),
                                           std::tuple(ole, "part", "this is a document of SolidWorks, Inventor"),
                                           std::tuple(rubbish, "part.sldasm", "is a CAD model (SolidWorks)"),
                                           std::tuple("PK\3\4 rest"s, "part.lys", "is a project (Lychee Slicer)"),
                                           std::tuple("PK\3\4 rest"s, "part.fcstd", "is a project (FreeCAD)"),
                                           std::tuple("\x1f\x8b\x08 rest"s, "part.blend", "is a project (Blender)"),
                                           std::tuple("\x1f\x8b\x08 rest"s, "part.stl.gz", "is packed (7z, gzip"),
                                           std::tuple("1 2 3\n"s, "part.dwg", "is a CAD model (DWG)"),
                                           std::tuple("\xff\xfe<\0?\0x\0m\0l\0"s, "part.dae", "(COLLADA)"),
                                           std::tuple(rubbish, "scan.fls", "is a scan that is not read (FARO)")}) {
    EXPECT_THAT(read(bytes, name).message(), HasSubstr(words)) << name;
  }
  EXPECT_EQ(read("ply\n", "part.step").code(), read("ply\n", "part.ply").code()) << "bytes count before names";
  EXPECT_THAT(read("solid a\nfacet normal 0 0 1\n", "part.iges").message(), HasSubstr("this is STL"));
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
    EXPECT_THAT(reading.message(), HasSubstr("read it as a mesh"));
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

TEST(FormatProbe, ABinaryStlMayHaveWideTextInItsHead) {
  std::string head;
  for (const char c : "solid made by a program"s) head += {c, '\0'};
  head.resize(80);
  const auto reading = read(head + little(1U) + std::string(50, '\0'), "part.stl");
  EXPECT_THAT(reading.message(), HasSubstr("this is STL"));
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
  const std::string table = "North East Up\n1 2 3\n";
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
