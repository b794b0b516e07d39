#include "slicer/reader/triangles/mesh_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/meshes.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using std::string_literals::operator""s;

class Triangles final : public TriangleSink {
 public:
  Status take(std::span<const Triangle> triangles) override {
    EXPECT_FALSE(triangles.empty());
    all.insert(all.end(), triangles.begin(), triangles.end());
    return {};
  }
  bool progress(double fraction) override {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    return !cancels;
  }
  std::vector<Triangle> all;
  bool cancels = false;
};

struct MeshReading {
  Expected<MeshSummary> summary;
  Triangles triangles;

  std::string message() const { return summary ? "" : summary.error().message(); }
  std::optional<ErrorCode> code() const {
    return summary ? std::nullopt : std::optional<ErrorCode>(summary.error().code());
  }
};

MeshReading read_triangles(const std::string& bytes, const std::string& name, std::vector<std::size_t> pieces = {},
                           std::uint64_t vertices = 10'000) {
  MemorySource source(bytes, name, std::move(pieces));
  ArenaBlock arena(VertexList::bytes_needed(vertices) + Arena::kAlignment);
  VertexList list = *VertexList::create(vertices, *arena);
  std::vector<std::byte> workspace(kReaderWorkspace, std::byte{0xA5});
  MeshReading reading{fail(ErrorCode::kMalformed, "not read"), {}};
  reading.summary = read_mesh(source, reading.triangles, list, workspace);
  return reading;
}

void expect_triangles(const MeshReading& reading, const TestMesh& mesh, const std::string& name) {
  ASSERT_TRUE(reading.summary) << name << ": " << reading.message();
  ASSERT_EQ(reading.triangles.all.size(), mesh.faces.size()) << name;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d expected = mesh.vertices[mesh.faces[i][c]].cast<float>().cast<double>();
      EXPECT_LT((reading.triangles.all[i][c] - expected).norm(), 1e-6) << name << ", face " << i;
    }
  }
}

TEST(MeshReader, EveryFormatDeliversTheSameTrianglesHoweverItsBytesArrive) {
  const TestMesh mesh = ball_mesh({1, -2, 3}, 4, 3);
  for (const SurfaceFile& file : files_of(mesh)) {
    for (const std::vector<std::size_t>& pieces : {std::vector<std::size_t>{}, {1}, {7, 300, 50}}) {
      const MeshReading reading = read_triangles(file.bytes, file.name, pieces);
      expect_triangles(reading, mesh, file.name);
      EXPECT_EQ(reading.summary->faces, mesh.faces.size());
      EXPECT_EQ(reading.summary->bytes, file.bytes.size());
      const bool is_indexed = reading.summary->format != ScanFormat::kStl;
      EXPECT_EQ(reading.summary->vertices, is_indexed ? mesh.vertices.size() : 0) << file.name;
      EXPECT_EQ(reading.summary->used_vertices, reading.summary->vertices) << file.name;
    }
  }
}

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(MeshReader, ObjFacesMayBePolygonsWithAnyIndices) {
  const std::tuple<const char*, std::size_t, std::uint64_t> cases[] = {{"f 1 2 3 4\n", 2, 4},
                                                                       {"f 1/1 2/2 3/3\n", 1, 3},
                                                                       {"f 1//1 2//1 3//1\n", 1, 3},
                                                                       {"f 1/1/1 2/2/2 4/3/3\n", 1, 3},
                                                                       {"f -4 -3 -2\n", 1, 3},
                                                                       {"f 1 2 \\\n 3 4\n", 2, 4},
                                                                       {"f 1 2\n", 0, 2},
                                                                       {"fo 1 2 3\n", 1, 3},
                                                                       {"f 1 2 3 # a comment\n", 1, 3},
                                                                       {"f 1 2 3\r\nf 1 3 4\r\n", 2, 4},
                                                                       {"g a\nusemtl b\ns 1\nf 1 2 3", 1, 3}};
  for (const auto& [faces, triangles, used] : cases) {
    const MeshReading reading = read_triangles(kSquare + faces, "a.obj");
    ASSERT_TRUE(reading.summary) << faces << reading.message();
    EXPECT_EQ(reading.triangles.all.size(), triangles) << faces;
    EXPECT_EQ(reading.summary->used_vertices, used) << faces;
  }
}

TEST(MeshReader, PlyFacesMayHaveOtherPropertiesAndElementsBetween) {
  const std::string text =
      "ply\nformat ascii 1.0\ncomment x\nelement camera 1\nproperty float f\nelement vertex 4\nproperty uchar red\n"
      "property double x\nproperty double y\nproperty double z\nelement edge 2\nproperty int a\nproperty int b\n"
      "element face 2\nproperty uchar flags\nproperty list uchar uint vertex_index\nproperty list uchar float "
      "texcoord\nelement more 1\nproperty int i\nend_header\n1.5\n9 0 0 0\n9 1 0 0\n9 1 1 0\n9 0 1 0\n0 1\n1 2\n"
      "7 3 0 1 2 2 .5 .5\n7 4 0 1 2 3 0\n5\n";
  const MeshReading reading = read_triangles(text, "a.ply");
  ASSERT_TRUE(reading.summary) << reading.message();
  EXPECT_EQ(reading.triangles.all.size(), 3U);
  EXPECT_EQ(reading.triangles.all[2][2], Vec3d(0, 1, 0));
}

TEST(MeshReader, PlyMayHaveFacesOfFloatsAndHarmlessBytesBehindThem) {
  const TestMesh box = box_mesh({0, 0, 0}, {1, 2, 3});
  expect_triangles(read_triangles(replaced(ascii_ply(box), "uchar int vertex", "uchar float vertex"), "a.ply"), box,
                   "floats");
  for (const std::string& harmless : {"\n \n"s, "# the end\n"s, "\x1a"s, std::string(100, '\0')}) {
    expect_triangles(read_triangles(ascii_ply(box) + harmless, "a.ply"), box, harmless);
  }
  const std::string binary = binary_ply_of<std::endian::little>(box);
  for (const std::string& harmless : {"\n"s, std::string(12, 'x'), std::string(100, '\0')}) {
    expect_triangles(read_triangles(binary + harmless, "a.ply"), box, harmless);
  }
  const std::string more = replaced(binary, "end_header", "element edge 9\nproperty int vertex1\nend_header");
  expect_triangles(read_triangles(more + std::string(36, 'x'), "a.ply"), box, "edges");
}

TEST(MeshReader, OffMayHaveCommentsColoursAndItsCountsInTheFirstLine) {
  for (const std::string text :
       {"# made by\n\nOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "OFF # x\n# y\n3 1 0\n\n0 0 0\n1 0 0 # z\n0 1 0\n3 0 1 2 255 0 0\n",
        "COFF\n3 1 3\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n",
        "NOFF 3 1 0\r\n0 0 0 0 0 1\r\n1 0 0 0 0 1\r\n0 1 0 0 0 1\r\n3 0 1 2\r\n",
        "STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2 1 1 1\n",
        // ModelNet's files have the word glued to the number, some others no word.
        "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "off\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "OFF\n3\n1\n2\n0 0 0\n1 0 0\n0 1 0\n3\n0 1\n\n# x\n2\n"}) {
    const MeshReading reading = read_triangles(text, "a.off");
    ASSERT_TRUE(reading.summary) << text << reading.message();
    ASSERT_EQ(reading.triangles.all.size(), 1U);
    EXPECT_EQ(reading.triangles.all[0][1], Vec3d(1, 0, 0));
  }
}

TEST(MeshReader, StlMayHaveSeveralSolidsTheWordSolidInABinaryFileOrNoNumberOfTriangles) {
  const TestMesh mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  const std::string twice = ascii_stl(mesh) + ascii_stl(mesh);
  EXPECT_EQ(read_triangles(twice, "a.stl").triangles.all.size(), 24U);
  std::string binary = binary_stl(mesh);
  std::copy_n("solid facet", 11, binary.begin());
  expect_triangles(read_triangles(binary, "a.stl"), mesh, "solid");
  for (const char count : {'\0', '\xff'}) {
    std::fill_n(binary.begin() + 80, 4, count);
    expect_triangles(read_triangles(binary, "a.stl"), mesh, "no number");
  }
  std::string capital = replaced(replaced(ascii_stl(mesh), "solid", "SOLID"), "vertex", "VERTEX");
  expect_triangles(read_triangles(capital, "a.stl"), mesh, "capital letters");
}

TEST(MeshReader, TextMayHaveDecimalCommas) {
  const TestMesh mesh = box_mesh({0.5, -0.25, 0}, {1.5, 2.25, 3.125});
  expect_triangles(read_triangles(replaced(ascii_stl(mesh), ".", ","), "a.stl"), mesh, "STL");
  expect_triangles(read_triangles(replaced(obj_of(mesh), ".", ","), "a.obj"), mesh, "OBJ");
  EXPECT_EQ(read_triangles(replaced(ascii_stl(mesh), "2.25", "1,002.25"), "a.stl").code(), ErrorCode::kMalformed);
}

TEST(MeshReader, ReadsTextPlyByWordsWhereverLinesEnd) {
  const TestMesh mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  const std::string text = ascii_ply(mesh);
  const std::size_t head = text.find("end_header\n") + 11;
  for (std::size_t period = 1; period < 100; period += 3) {
    std::string broken = text.substr(0, head);
    std::size_t count = 0;
    for (const char c : text.substr(head)) {
      broken += c != ' ' && c != '\n' ? c : ++count % period == 0 ? '\n' : ' ';
    }
    expect_triangles(read_triangles(broken, "a.ply"), mesh, std::to_string(period));
  }
}

TEST(MeshReader, StlIsTextWhateverIsBeforeItsSolid) {
  const TestMesh mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  const std::string text = ascii_stl(mesh);
  for (const std::string before :
       {"\n\n  ", "\xef\xbb\xbf", "\t \r\n", "# made by a program\n", "; made by a program\nfacet"}) {
    expect_triangles(read_triangles(before + text, "a.stl"), mesh, before);
  }
  expect_triangles(read_triangles("\n  " + text, "no ending"), mesh, "no ending");
  expect_triangles(read_triangles(text.substr(text.find('\n') + 1), "a.stl"), mesh, "no solid");
  std::string shouted = text;
  std::transform(shouted.begin(), shouted.end(), shouted.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
  expect_triangles(read_triangles("; by\n" + shouted, "a.stl"), mesh, "all capital");
}

TEST(MeshReader, TextThatIsCalledStlIsReadAsWhatItIs) {
  const TestMesh mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  expect_triangles(read_triangles(obj_of(mesh), "a.stl"), mesh, "OBJ");
  EXPECT_EQ(read_triangles(std::string(200, 'x'), "a.stl").code(), ErrorCode::kUnknownFormat);
}

TEST(MeshReader, StlTextMayHaveAFacetInALine) {
  const TestMesh mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  std::string lines = "solid a vertex of its name\n";
  const std::string text = ascii_stl(mesh);
  for (std::size_t at = text.find('\n') + 1; at < text.size(); ++at) {
    const bool ends = text[at] == '\n' && text.compare(at - 8, 8, "endfacet") != 0;
    lines += ends ? ' ' : text[at];
  }
  expect_triangles(read_triangles(lines, "a.stl"), mesh, lines);
}

TEST(MeshReader, BytesAfterTheLastTriangleOfABinaryStlAreNoTrianglesOrAnError) {
  const TestMesh mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  const std::string stl = binary_stl(mesh);
  for (const std::string& harmless : {"\n"s, std::string(49, 'x'), std::string(512, '\0')}) {
    expect_triangles(read_triangles(stl + harmless, "a.stl"), mesh, harmless);
  }
  for (const std::string& more : {std::string(100, 'x'), stl}) {
    const MeshReading reading = read_triangles(stl + more, "a.stl");
    EXPECT_EQ(reading.code(), ErrorCode::kMalformed);
    const std::string bytes = std::to_string(more.size());
    EXPECT_THAT(reading.message(), HasSubstr("declares 12 triangles, but " + bytes + " bytes follow them, enough for " +
                                             std::to_string(more.size() / 50) + " more"));
  }
}

/// The corners of a strip of two triangles, and of another one.
TEST(MeshReader, PlyMayHaveStripsOfTriangles) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  const std::string text = head + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n8 0 1 2 3 -1 2 3 4\n";
  std::string binary = replaced(head, "ascii", "binary_little_endian");
  const auto append = [&](auto value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if constexpr (std::endian::native == std::endian::big) std::reverse(std::begin(bytes), std::end(bytes));
    binary.append(bytes, sizeof value);
  };
  for (const float number : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 1.F, 1.F, 0.F, 0.F, 2.F, 0.F}) append(number);
  for (const std::int32_t index : {8, 0, 1, 2, 3, -1, 2, 3, 4}) append(index);
  const Vec3d p[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}};
  const std::vector<Triangle> expected = {{p[0], p[1], p[2]}, {p[2], p[1], p[3]}, {p[2], p[3], p[4]}};
  for (const std::string& bytes : {text, binary}) {
    const MeshReading reading = read_triangles(bytes, "a.ply");
    ASSERT_TRUE(reading.summary) << reading.message();
    EXPECT_EQ(reading.triangles.all, expected);
    EXPECT_EQ(reading.summary->faces, 3U);
    EXPECT_EQ(reading.summary->used_vertices, 5U);
  }
  const MeshReading missing = read_triangles(replaced(text, "-1", "-2"), "a.ply");
  EXPECT_EQ(missing.code(), ErrorCode::kMalformed);
}

TEST(MeshReader, CoordinatesThatAreNotFiniteOrHugeAreLeftOutWithTheirTriangles) {
  const std::string nan =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv nan 0 0\nv 1e300 0 0\nv inf 0 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 2 6\n";
  const MeshReading reading = read_triangles(nan, "a.obj");
  ASSERT_TRUE(reading.summary) << reading.message();
  EXPECT_EQ(reading.summary->triangles, 1U);
  EXPECT_EQ(reading.summary->not_finite, 3U);
  TestMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  mesh.vertices[0][1] = std::numeric_limits<double>::infinity();
  for (const SurfaceFile& file : files_of(mesh)) {
    const std::string_view name = file.name;
    if (name == "ascii.stl" || name == "mesh.off" || name == "mesh.3mf") continue;  // such text is no number there
    const MeshReading other = read_triangles(file.bytes, file.name);
    ASSERT_TRUE(other.summary) << file.name << other.message();
    EXPECT_EQ(other.summary->triangles + other.summary->not_finite, 12U) << file.name;
    EXPECT_GE(other.summary->not_finite, 4U) << file.name;
  }
  const MeshReading far = read_triangles("v 1e30 1e30 1e30\nv 0 0 0\nv 1 0 0\nf 1 2 3\n", "a.obj");
  ASSERT_TRUE(far.summary);
}

struct Broken {
  const char* name;
  std::string bytes;
  ErrorCode code;
  const char* message;
};

TEST(MeshReader, BrokenFilesAreRefusedWithPlaceAndRemedy) {
  const TestMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const std::string stl = binary_stl(box);
  std::string many = stl;
  many[80] = 13;
  const std::string text = ascii_stl(box);
  const std::string ply = binary_ply_of<std::endian::little>(box);
  const std::string off = off_of(box);
  const std::string faces = "element face 12\nproperty list uchar int vertex_indices\n";
  const std::string faces_first =
      replaced(replaced(ascii_ply(box), faces, ""), "element vertex", faces + "element vertex");
  constexpr auto kTruncated = ErrorCode::kTruncated;
  constexpr auto kMalformed = ErrorCode::kMalformed;
  const std::vector<Broken> all = {
      {"a.stl", stl.substr(0, 60), kTruncated, "the file has 60 bytes, a binary STL has 84 before its first triangle"},
      {"a.stl", stl.substr(0, 84 + 120), kTruncated, "ends at byte 204, with 2 of the 12 triangles that its header"},
      {"a.stl", many, kTruncated, "12 of the 13 triangles"},
      {"a.stl", text.substr(0, text.size() / 2), kTruncated, "copy or export it again"},
      {"a.stl", text.substr(0, text.rfind("endsolid")), kTruncated, "before 'endsolid'"},
      {"a.stl", replaced(text, "vertex 0 0 0", "vertex 0 x 0"), kMalformed, "expected a number for y, found 'x'"},
      {"a.stl", replaced(text, "endloop", "endl\0\0p"s), kMalformed, "has bytes that are zero"},
      {"a.stl", "solid\nfacet\nvertex 0 0 0\nvertex 1 1 1\nendfacet\nendsolid\n", kMalformed,
       "line 5: a facet has 2 corners"},
      {"a.stl", "solid\nfacet\nvertex 0 0 0\nvertex 1 1 1\nvertex 1 0 1\nvertex 2 0 1\nendfacet\nendsolid\n",
       kMalformed, "line 6: a facet has more than three corners"},
      {"a.stl", "solid\nfacet\nvertx 0 0 0\nvertx 1 1 1\nvertx 1 0 1\nendfacet\nendsolid\n", kMalformed,
       "line 6: a facet has 0 corners"},
      {"a.stl", "solid\nfacet\nfacet\nvertex 0 0 0\nvertex 1 1 1\nvertex 1 0 1\nendfacet\nendsolid\n", kMalformed,
       "line 3: a facet has 0 corners"},
      {"a.stl",
       "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 1 1\nouter loop\nvertex 1 0 1\nendloop\nendfacet\nendsolid\n",
       kMalformed, "line 6: a facet has 2 corners"},
      {"a.stl", "solid\nfacet\nouter loop\nvertex 0 0 0\nendloop\nvertex 1 1 1\nvertex 1 0 1\nendfacet\nendsolid\n",
       kMalformed, "line 5: a facet has 1 corner,"},
      {"a.stl", "solid\nfacet\nendsolid\n", kMalformed, "line 3: a facet has 0 corners"},
      {"a.obj", kSquare + "\0\0\0 2 3\nf 1 2 3\n"s, kMalformed, "line 5: has bytes that are zero"},
      {"a.obj", replaced(kSquare, "v 1 1 0", "\0\0\0\0\0\0\0"s) + "f 1 2 3\n", kMalformed, "has bytes that are zero"},
      {"a.obj", kSquare + "f 1 2 5\n", kMalformed,
       "line 5: a face names vertex 5, but 4 are before it, numbered from 1"},
      {"a.obj", kSquare + "cstype bezier\nsurf 0 1 0 1 1 2 3 4\nend\n", ErrorCode::kUnsupported,
       "line 6: a free-form surface, whose vertices don't lie on it"},
      {"a.obj", kSquare + "f 0 1 2\n", kMalformed, "a face names vertex 0"},
      {"a.obj", kSquare + "f 1 2 -5\n", kMalformed, "a face names vertex -5"},
      {"a.obj", kSquare + "f 1 2 x\n", kMalformed, "expected the number of a vertex, found 'x'"},
      {"a.obj", kSquare + "f 1 2 99999999999999999999\n", kMalformed, "expected the number of a vertex"},
      {"a.obj", kSquare + "f 1 2 3\nf 1 2", kTruncated, "line 6: the file ends in the middle of a face"},
      {"a.obj", "v 0 0\nf 1 1 1\n", kMalformed, "line 1: too few numbers, z is missing"},
      {"a.ply", ply.substr(0, ply.size() - 5), kTruncated, "with 11 of the 12 faces that its header declares"},
      {"a.ply", ply.substr(0, ply.size() - 12 * 13 - 5), kTruncated, "points that its header declares"},
      {"a.ply", replaced(ascii_ply(box), "\n3 0 2 3\n", "\n3 0 2 8\n"), kMalformed,
       "face 0 names vertex 8, but there are 8, numbered from 0"},
      {"a.ply", replaced(ascii_ply(box), "\n3 0 2 3\n", "\n3 0 2\n"), kMalformed, "expected a face, found '3 "},
      {"a.ply", replaced(ascii_ply(box), "vertex_indices", "corners"), ErrorCode::kUnsupported,
       "0 of its 12 faces can be read"},
      {"a.ply", faces_first, ErrorCode::kUnsupported, "0 of its 12 faces can be read: those of one element behind the"},
      {"a.ply",
       replaced(ascii_ply(box), "end_header", "element tristrips 3\nproperty list int int vertex_indices\nend_header"),
       ErrorCode::kUnsupported, "12 of its 15 faces can be read"},
      {"a.ply", replaced(ascii_ply(box), "\n3 0 2 3\n", "\n3 0 1.5 3\n"), kMalformed, "face 0 names vertex 1.5, but"},
      {"a.ply", replaced(ascii_ply(box), "face 12", "face 11"), kMalformed, "its header declares 11 faces, but '3 "},
      {"a.ply", replaced(ply, "face 12", "face 11"), kMalformed,
       "its header declares 11 faces, but 13 bytes follow them, enough for 1 more"},
      {"a.off", off.substr(0, off.size() - 16), kTruncated, "before the last face"},
      {"a.off", off.substr(0, off.size() - 5), kTruncated, "before the number of a vertex"},
      {"a.off", replaced(off, "3 0 2 3\n", "3 0 2\n"), kMalformed, "expected the end of a face that begins in line"},
      {"a.off", "OFF\n", kTruncated, "before the number of its vertices"},
      {"a.off", "OFF\n-3 1 0\n", kMalformed, "line 2: expected the number of its vertices, found '-3'"},
      {"a.off", "OFF\n99999999999 1 0\n0 0 0\n", kTruncated, "before the last vertex"},
      {"a.off", replaced(off, "3 0 2 3\n", "3 0 2 8\n"), kMalformed, "a face names vertex 8, but there are 8"},
      {"a.off", off + "3 0 1 2\n", kMalformed, "its header declares 12 faces, but '3 0 1 2' follows them"},
      {"a.off", "OFF BINARY\n", ErrorCode::kUnsupported, "export it as ascii"},
  };
  for (const Broken& broken : all) {
    const MeshReading reading = read_triangles(broken.bytes, broken.name);
    EXPECT_EQ(reading.code(), broken.code) << broken.message << ": " << reading.message();
    EXPECT_THAT(reading.message(), HasSubstr(broken.name + ": "s));
    EXPECT_THAT(reading.message(), HasSubstr(broken.message));
  }
}

TEST(MeshReader, VerticesThatDoNotFitAreRefusedWithRemedy) {
  for (const char* name : {"a.obj", "a.off", "a.ply"}) {
    const TestMesh mesh = ball_mesh({0, 0, 0}, 1, 2);
    const std::string bytes = name == "a.obj"s ? obj_of(mesh) : name == "a.off"s ? off_of(mesh) : ascii_ply(mesh);
    const MeshReading reading = read_triangles(bytes, name, {}, 20);
    EXPECT_EQ(reading.code(), ErrorCode::kOutOfMemory);
    EXPECT_THAT(reading.message(), HasSubstr(": the mesh has more vertices than the 20 that the arena has room for"));
    EXPECT_THAT(reading.message(), HasSubstr("save it as binary STL"));
  }
}

TEST(MeshReader, StopsWhenItIsCancelledAndPassesTheSourcesErrorOn) {
  const std::string bytes = binary_stl(ball_mesh({0, 0, 0}, 1, 5));
  MemorySource source(bytes, "a.stl");
  source.fail_at(200'000);
  VertexList none;
  std::vector<std::byte> workspace(kReaderWorkspace);
  Triangles triangles;
  EXPECT_EQ(read_mesh(source, triangles, none, workspace).error().code(), ErrorCode::kCannotRead);
  MemorySource again(bytes, "a.stl");
  triangles.cancels = true;
  EXPECT_EQ(read_mesh(again, triangles, none, workspace).error().code(), ErrorCode::kCancelled);
}

TEST(MeshHint, ComesFromTheBeginningOfTheFile) {
  const TestMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  std::vector<std::byte> workspace(kReaderWorkspace);
  const auto hint = [&](const std::string& bytes, const char* name) {
    MemorySource source(bytes, name);
    return *hint_of(source, workspace);
  };
  for (const SurfaceFile& file : files_of(mesh)) {
    const std::string_view name = file.name;
    EXPECT_EQ(hint(file.bytes, file.name), name.ends_with(".stl")   ? MeshHint::kTriangles
                                           : name.ends_with(".off") ? MeshHint::kMesh
                                           : name.ends_with(".3mf") ? MeshHint::kPackedMesh
                                                                    : MeshHint::kMaybe)
        << name;
  }
  EXPECT_EQ(hint("0 0 0\n", "a.xyz"), MeshHint::kNone);
  EXPECT_EQ(hint("", "a.stl"), MeshHint::kNone);
  EXPECT_EQ(hint("\x1f\x8b", "a.gz"), MeshHint::kNone);
  EXPECT_EQ(hint("ply\nformat ascii 1.0\nelement vertex 100\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 3\nproperty list uchar int vertex_indices\nend_header\n",
                 "a.ply"),
            MeshHint::kNone);
  EXPECT_EQ(hint("ply\nformat ascii 1.0\nelement face 8\nproperty list uchar int vertex_indices\nelement vertex 4\n"
                 "property float x\nproperty float y\nproperty float z\nend_header\n",
                 "a.ply"),
            MeshHint::kMaybe);
  EXPECT_EQ(hint("ply\nformat ascii 1.0\nelement vertex 100\nproperty float x\nproperty float y\nproperty float z\n"
                 "element tristrips 1\nproperty list int int vertex_indices\nend_header\n",
                 "a.ply"),
            MeshHint::kMaybe);
}

}  // namespace
}  // namespace plumbline
