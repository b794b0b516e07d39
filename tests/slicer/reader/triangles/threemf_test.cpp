/// 3MF: how it is packed, what stands where, and what is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <string>
#include <tuple>
#include <vector>

#include "slicer/reader/scan_reader.hpp"
#include "slicer/reader/triangles/mesh_reader.hpp"
#include "tests/slicer/support/meshes.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using std::string_literals::operator""s;

class ThreeMfTriangles final : public TriangleSink {
 public:
  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) {
      for (const Vec3d& p : t) bounds.extend(p);
      volume += t[0].dot(t[1].cross(t[2])) / 6;
    }
    count += triangles.size();
    since_report += triangles.size();
    most_unreported = std::max(most_unreported, since_report);
    return {};
  }
  bool progress(double /*fraction*/) override {
    since_report = 0;
    return true;
  }
  std::size_t count = 0;
  std::size_t since_report = 0;
  std::size_t most_unreported = 0;
  double volume = 0;  ///< mm^3; negative: inside out
  Box3d bounds;
};

/// Reads a file, and again with a copy: everything must be the same.
struct ThreeMf {
  explicit ThreeMf(const std::string& bytes, std::uint64_t vertices = 1000) {
    ModelCopy none({});
    summary = read(bytes, vertices, found, none);
    const std::size_t bytes_of_copy = static_cast<std::size_t>(vertices) * sizeof(Vec3f);
    ArenaBlock room(bytes_of_copy + 2 * Arena::kAlignment);
    ModelCopy copy(*(*room).take_bottom<std::byte>(bytes_of_copy, "test"));
    ThreeMfTriangles again;
    const auto other = read(bytes, vertices, again, copy);
    expect_same(other, again);
    is_copied = other && copy.is_finished();
    if (!is_copied) return;
    std::vector<std::uint64_t> moved((copy.bytes().size() + 7) / 8);
    std::memcpy(moved.data(), copy.bytes().data(), copy.bytes().size());
    std::memset(const_cast<std::byte*>(copy.bytes().data()), 0xA5, copy.bytes().size());
    copy.move_to(std::as_writable_bytes(std::span(moved)));
    std::vector<std::byte> workspace(kReaderWorkspace, std::byte{0xA5});
    for (int reading = 0; reading < 2; ++reading) {
      ThreeMfTriangles copied;
      expect_same(read_mesh(copy, copied, workspace), copied);
    }
    for (const std::size_t missing : {std::size_t{1}, copy.bytes().size() / 2, copy.bytes().size() - 1}) {
      ModelCopy full(std::as_writable_bytes(std::span(moved)).first(copy.bytes().size() - missing));
      ThreeMfTriangles without;
      expect_same(read(bytes, vertices, without, full), without);
      EXPECT_FALSE(full.is_finished());
    }
  }
  static Expected<MeshSummary> read(const std::string& bytes, std::uint64_t vertices, ThreeMfTriangles& sink,
                                    ModelCopy& copy) {
    MemorySource source(bytes, "part.3mf");
    ArenaBlock arena(VertexList::bytes_needed(vertices) + Arena::kAlignment);
    VertexList list = *VertexList::create(vertices, *arena);
    std::vector<std::byte> workspace(kReaderWorkspace, std::byte{0xA5});
    return read_mesh(source, sink, list, workspace, copy);
  }
  void expect_same(const Expected<MeshSummary>& other, const ThreeMfTriangles& sink) const {
    // Only a second pass relies on the sizes of parts that the first one reads to their end.
    if (other && !summary) {
      EXPECT_THAT(message(), AnyOf(HasSubstr("header of a part"), HasSubstr("before its archive does")));
      return;
    }
    ASSERT_EQ(other.has_value(), summary.has_value()) << (other ? message() : other.error().message());
    if (!other) {
      EXPECT_STREQ(other.error().message(), summary.error().message());
      return;
    }
    EXPECT_EQ(sink.volume, found.volume);
    EXPECT_EQ(sink.bounds.low, found.bounds.low);
    EXPECT_EQ(sink.bounds.high, found.bounds.high);
    const auto counts = [](const MeshSummary& s) {
      return std::tuple(s.format, s.is_in_mm, s.faces, s.triangles, s.not_finite, s.vertices, s.most_vertices, s.bytes);
    };
    EXPECT_EQ(counts(*other), counts(*summary));
  }
  std::string message() const { return summary ? "" : std::string(summary.error().message()); }
  std::string advice() const { return summary ? "" : std::string(summary.error().advice()); }

  ThreeMfTriangles found;
  bool is_copied = false;
  Expected<MeshSummary> summary = fail(ErrorCode::kMalformed, "not read");
};

const TestMesh kBlock = box_mesh({0, 0, 0}, {1, 2, 3});  // 6 mm^3

std::string block(int id, const std::string& attributes = "") { return object_of(kBlock, id, attributes); }
std::string built(const std::string& resources, const std::string& build) {
  return model_of("<resources>" + resources + "</resources><build>" + build + "</build>");
}
void expect_box(const ThreeMf& file, const Vec3d& low, const Vec3d& high, double volume, const std::string& what) {
  ASSERT_TRUE(file.summary) << what << ": " << file.message();
  EXPECT_LT((file.found.bounds.low - low).norm() + (file.found.bounds.high - high).norm(), 1e-9) << what;
  EXPECT_NEAR(file.found.volume, volume, 1e-9) << what;
}

TEST(ThreeMf, IsReadHoweverItIsPacked) {
  const std::string model = built(block(1), "<item objectid=\"1\"/>");
  for (const bool deflate : {true, false}) {
    for (const bool follow : {true, false}) {
      for (const bool sign : {true, false}) {
        for (const bool long_sizes : {true, false}) {
          if (follow && !deflate) continue;  // where such a part ends, nobody can tell
          const auto part = [&](const std::string& name, const std::string& content) {
            return ZipPart{name, content, deflate, follow, sign, long_sizes};
          };
          const ThreeMf file(
              zip_of({part("Metadata/thumbnail.png", std::string(300, 'x')), part("3D/3dmodel.model", model),
                      part("_rels/.rels", relations_to("3D/3dmodel.model")), part("Metadata/", "")}));
          expect_box(file, {0, 0, 0}, {1, 2, 3}, 6,
                     "deflate " + std::to_string(deflate) + ", follow " + std::to_string(follow) + ", signed " +
                         std::to_string(sign) + ", long " + std::to_string(long_sizes));
        }
      }
    }
  }
}

TEST(ThreeMf, ALargeModelMayBeStored) {
  std::string model = built(block(1), "<item objectid=\"1\"/>");
  const std::string one = "<vertex x=\"1\" y=\"2\" z=\"3\"/>";
  std::string many;
  while (many.size() < 200'000) many += one;
  model.insert(model.find("</vertices>"), many);
  ZipPart part{"3D/3dmodel.model", model};
  part.deflated = false;
  expect_box(ThreeMf(zip_of({part}), 10'000), {0, 0, 0}, {1, 2, 3}, 6, "stored");
}

TEST(ThreeMf, NumbersMayHaveBlanksAroundThemAndPathsBackslashes) {
  std::string model = replaced(built(block(1), "<item objectid=\" 1\"/>"), "x=\"1\"", "x=\"  1.0E+00 \"");
  model = replaced(model, "v2=\"2\"", "v2=\" 2\n\"");
  const ThreeMf file(zip_of({{"3D\\root.model", model}, {"_rels\\.rels", relations_to("/3D/root.model")}}));
  expect_box(file, {0, 0, 0}, {1, 2, 3}, 6, "blanks and backslashes");
}

TEST(ThreeMf, IsInMillimetresWhateverItsUnit) {
  const std::pair<const char*, double> units[] = {{"micron", 0.001}, {"millimeter", 1}, {"centimeter", 10},
                                                  {"inch", 25.4},    {"foot", 304.8},   {"meter", 1000}};
  for (const auto& [unit, mm] : units) {
    std::string model = built(block(1), "<item objectid=\"1\"/>");
    model.replace(model.find("millimeter"), 10, unit);
    const ThreeMf file(threemf_with(model));
    ASSERT_TRUE(file.summary) << file.message();
    EXPECT_TRUE(file.summary->is_in_mm);
    EXPECT_NEAR(file.found.bounds.high[2], 3 * mm, 1e-9 * mm) << unit;
  }
}

TEST(ThreeMf, ObjectsStandWhereTheBuildPutsThem) {
  struct Case {
    const char* what;
    std::string resources, build;
    Vec3d low, high;
    double volume;
  };
  const std::string group =
      block(1) + R"(<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 10"/>)" +
      R"(<component objectid="1"/></components></object>)";
  const Case cases[] = {
      {"moved",
       block(1),
       R"(<item objectid="1" transform="1 0 0 0 1 0 0 0 1 10 20 30"/>)",
       {10, 20, 30},
       {11, 22, 33},
       6},
      {"a quarter turn around z",
       block(1),
       R"(<item objectid="1" transform="0 1 0  -1 0 0  0 0 1  0 0 0"/>)",
       {-2, 0, 0},
       {0, 1, 3},
       6},
      {"mirrored, and not inside out",
       block(1),
       R"(<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>)",
       {-1, 0, 0},
       {0, 2, 3},
       6},
      {"twice",
       block(1),
       R"(<item objectid="1"/><item objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>)",
       {0, 0, 0},
       {6, 2, 3},
       12},
      {"components, then the item",
       group,
       R"(<item objectid="2" transform="2 0 0 0 2 0 0 0 2 0 0 1"/>)",
       {0, 0, 1},
       {2, 4, 27},
       96},
      {"no item of it", block(1) + block(2), R"(<item objectid="2"/>)", {0, 0, 0}, {1, 2, 3}, 6},
      {"a support beside it",
       block(1) + block(2, R"(type="support")"),
       R"(<item objectid="1"/><item objectid="2" transform="1 0 0 0 1 0 0 0 1 50 0 0"/>)",
       {0, 0, 0},
       {1, 2, 3},
       6},
      {"one that is not to be printed",
       block(1),
       R"(<item objectid="1"/><item objectid="1" printable="0" transform="9 0 0 0 9 0 0 0 9 0 0 0"/>)",
       {0, 0, 0},
       {1, 2, 3},
       6},
      {"an unknown element with vertices",
       block(1) + R"(<x:object id="3"/><metadata><vertex x="9" y="9" z="9"/></metadata>)",
       R"(<item objectid="1"/>)",
       {0, 0, 0},
       {1, 2, 3},
       6},
  };
  for (const Case& c : cases)
    expect_box(ThreeMf(threemf_with(built(c.resources, c.build))), c.low, c.high, c.volume, c.what);
}

TEST(ThreeMf, ObjectsMayBeInOtherModelsOfTheFile) {
  const std::string other = built(block(1), "");
  const std::string root = built(
      R"(<object id="1"><components><component p:path="/3D/Objects/one.model" objectid="1"/></components></object>)",
      R"(<item objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 5"/>)");
  const ThreeMf before(zip_of(
      {{"3D/Objects/one.model", other}, {"3D/root.model", root}, {"_rels/.rels", relations_to("/3D/root.model")}}));
  expect_box(before, {0, 0, 5}, {1, 2, 8}, 6, "the object first");
  const ThreeMf after(zip_of({{"3D/3dmodel.model", root}, {"3d/objects/One.model", other}}));
  expect_box(after, {0, 0, 5}, {1, 2, 8}, 6, "the object last, with other letters");
  const std::string coded = replaced(root, "/3D/Objects/one.model", "/3D/one%20part%C3%A4.model");
  for (const char* name : {"3D/one part\xc3\xa4.model", "3D/one%20part%c3%a4.model"}) {
    expect_box(ThreeMf(zip_of({{"3D/3dmodel.model", coded}, {name, other}})), {0, 0, 5}, {1, 2, 8}, 6, name);
  }
}

TEST(ThreeMf, IsCopiedWhereNothingIsWrongWithWhatMayBePrinted) {
  const std::string item = "<item objectid=\"1\"/>";
  EXPECT_TRUE(ThreeMf(threemf_with(built(block(1) + block(2), item))).is_copied);
  EXPECT_TRUE(
      ThreeMf(threemf_with(built(block(1) + replaced(block(2, R"(type="support")"), "x=\"1\"", ""), item))).is_copied);
  const ThreeMf other(threemf_with(built(block(1) + replaced(block(2), "x=\"1\"", ""), item)));
  EXPECT_FALSE(other.is_copied);
  expect_box(other, {0, 0, 0}, {1, 2, 3}, 6, "an object that is not printed has no x");
  const std::string vertex = "<vertex x=\"9\" y=\"9\" z=\"9\"/>";
  const std::string late = replaced(block(1), "</triangles>", "</triangles><vertices>" + vertex + "</vertices>");
  EXPECT_FALSE(ThreeMf(threemf_with(built(late, item))).is_copied);
}

TEST(ThreeMf, OneObjectsVerticesAreKeptAtATime) {
  const std::string model =
      built(block(1) + block(2) + block(3), R"(<item objectid="1"/><item objectid="2"/><item objectid="3"/>)");
  const ThreeMf file(threemf_with(model), 8);
  ASSERT_TRUE(file.summary) << file.message();
  EXPECT_EQ(file.summary->vertices, 24U);
  EXPECT_EQ(file.summary->most_vertices, 8U);
  EXPECT_EQ(file.summary->triangles, 36U);
  const ThreeMf full(threemf_with(model), 7);
  EXPECT_EQ(full.summary.error().code(), ErrorCode::kOutOfMemory);
  EXPECT_THAT(full.message(), HasSubstr("more vertices than the 7"));
}

TEST(ThreeMf, BrokenAndHostileFilesAreRefusedInWords) {
  const std::string good = built(block(1), "<item objectid=\"1\"/>");
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string model = good;
    const auto at = model.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return threemf_with(model.replace(at, from.size(), to));
  };
  const auto part = [&](ZipPart changed) {
    changed.name = "3D/3dmodel.model";
    changed.content = good;
    return zip_of({changed});
  };
  std::string many;
  for (int i = 0; i < 2000; ++i) many += "<item objectid=\"1\"/>";
  std::string levels = block(1);
  for (int id = 2; id < 30; ++id) {
    const std::string component = "<component objectid=\"" + std::to_string(id - 1) + "\"/>";
    levels +=
        "<object id=\"" + std::to_string(id) + "\"><components>" + component + component + "</components></object>";
  }
  const std::string whole = threemf_with(good);
  ZipPart encrypted;
  encrypted.flags = 1;
  ZipPart endless;
  endless.deflated = false;
  endless.sizes_follow = true;
  ZipPart other;
  other.method = 12;
  ZipPart wrong;
  wrong.checksum_error = 1;
  const std::tuple<const char*, std::string, ErrorCode, const char*> cases[] = {
      {"cut", whole.substr(0, whole.size() / 2), ErrorCode::kTruncated, "before its"},
      {"cut before its directory", whole.substr(0, whole.find("PK\x01\x02"s)), ErrorCode::kTruncated,
       "before its archive does"},
      {"encrypted", part(encrypted), ErrorCode::kUnsupported, "is encrypted"},
      {"stored without a size", part(endless), ErrorCode::kUnsupported,
       "is not compressed and does not say how long it is"},
      {"another method", part(other), ErrorCode::kUnsupported, "method 12"},
      {"a wrong checksum", part(wrong), ErrorCode::kMalformed, "the checksum of '3D/3dmodel.model' is wrong"},
      {"no model", zip_of({{"word/document.xml", "<a/>"}}), ErrorCode::kUnsupported, "no 3D model"},
      {"no XML", threemf_with("hello"), ErrorCode::kMalformed, "line 1 of 3D/3dmodel.model"},
      {"an entity bomb", with("<model", "<!DOCTYPE m [<!ENTITY a \"aaaa\">]><model"), ErrorCode::kMalformed,
       "a document type"},
      {"another root", with("<model", "<nodel"), ErrorCode::kMalformed, "expected a model"},
      {"an unknown unit", with("\"millimeter\"", "\"cubit\""), ErrorCode::kMalformed, "unknown unit 'cubit'"},
      {"a beam lattice",
       with("unit=",
            "requiredextensions=\"b\" xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" "
            "unit="),
       ErrorCode::kMalformed, "needs the extension 'b'"},
      {"a beam lattice that is not required", with("</mesh>", "<b:beamlattice xmlns:b=\"b\"/></mesh>"),
       ErrorCode::kMalformed, "an object has a lattice of beams, which is not supported"},
      {"no coordinate", with("x=\"1\"", "x=\"one\""), ErrorCode::kMalformed, "'one' is not a coordinate"},
      {"a missing coordinate", with("x=\"1\"", ""), ErrorCode::kMalformed, "'' is not a coordinate"},
      {"no number of a vertex", with("v2=\"2\"", "v2=\"-2\""), ErrorCode::kMalformed, "names vertex '-2'"},
      {"a vertex too many", with("v2=\"2\"", "v2=\"8\""), ErrorCode::kMalformed, "there are 8, numbered from 0"},
      {"a short transform", with("objectid=\"1\"", "objectid=\"1\" transform=\"1 0 0\""), ErrorCode::kMalformed,
       "is not a transform of 12 numbers"},
      {"an infinite transform", with("objectid=\"1\"", "objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0 1e999\""),
       ErrorCode::kMalformed, "is not a transform of 12 numbers"},
      {"no id", with("objectid=\"1\"", "objectid=\"x\""), ErrorCode::kMalformed, "expected an objectid from 1"},
      {"no item", threemf_with(built(block(1), "")), ErrorCode::kNoPoints, "no object is to be printed"},
      {"no item that is printable", threemf_with(built(block(1), R"(<item objectid="1" printable="0"/>)")),
       ErrorCode::kNoPoints, "no object is to be printed"},
      {"a surface only", threemf_with(built(block(1, R"(type="surface")"), R"(<item objectid="1"/>)")),
       ErrorCode::kNoPoints, "what its build places has no triangle, or is a support, a surface or a modifier"},
      {"an item without its object", threemf_with(built(block(1), "<item objectid=\"1\"/><item objectid=\"14\"/>")),
       ErrorCode::kMalformed, "the object with the id 14 is to be printed, but is not in the archive"},
      {"a component without its object",
       threemf_with(built(
           block(1) +
               R"(<object id="2"><components><component objectid="1"/><component objectid="9"/></components></object>)",
           "<item objectid=\"2\"/>")),
       ErrorCode::kMalformed, "the object with the id 9 is to be printed"},
      {"two meshes of one id", threemf_with(built(block(1) + block(1), "<item objectid=\"1\"/>")),
       ErrorCode::kMalformed, "another object with the id 1"},
      {"a mesh and components of one id",
       threemf_with(
           built(block(1) + block(2) + R"(<object id="2"><components><component objectid="1"/></components></object>)",
                 "<item objectid=\"2\"/>")),
       ErrorCode::kMalformed, "another object with the id 2"},
      {"too many items", threemf_with(built(block(1), many)), ErrorCode::kMalformed, "more than 1024 items"},
      {"too many copies", threemf_with(built(levels, "<item objectid=\"20\"/>")), ErrorCode::kMalformed,
       "more than 512 times"},
      {"itself",
       threemf_with(built(
           block(1) +
               R"(<object id="2"><components><component objectid="1"/><component objectid="2"/></components></object>)",
           "<item objectid=\"2\"/>")),
       ErrorCode::kMalformed, "contains itself"},
  };
  for (const auto& [what, bytes, code, text] : cases) {
    const ThreeMf file(bytes);
    ASSERT_FALSE(file.summary) << what;
    EXPECT_EQ(file.summary.error().code(), code) << what << ": " << file.message();
    EXPECT_THAT(file.message(), HasSubstr("part.3mf: ")) << what;
    EXPECT_THAT(file.message(), HasSubstr(text)) << what;
    EXPECT_FALSE(file.advice().empty()) << what << ": " << file.message();
  }
}

TEST(ThreeMf, AnyByteChangedIsReadOrRefused) {
  const std::string whole = threemf_with(built(block(1), "<item objectid=\"1\"/>"));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    const ThreeMf file(bytes);
    EXPECT_TRUE(file.summary || file.message().size() > 10) << at;
  }
}

/// Seconds of the processor for searches for a mesh from which 2^13 ways lead up, but none to the build.
/// @param others  meshes beside it
double seconds_of_searches(std::uint32_t others) {
  constexpr std::uint32_t kLevels = 14;
  const auto key = [](std::uint32_t id) { return ObjectKey{1, id}; };
  ArenaBlock arena(std::size_t{256} * 1024);
  auto parts = *ModelParts::create(*arena);
  for (std::uint32_t level = 1; level <= kLevels; ++level) {
    EXPECT_TRUE(parts.add(key(level + 1), key(level), {}));
    EXPECT_TRUE(level == kLevels || parts.add(key(level + 1), key(level), {}));
  }
  for (std::uint32_t i = 0; i < others; ++i) EXPECT_TRUE(parts.add(key(100 + i), key(kLevels), {}));
  const std::clock_t begin = std::clock();
  for (int search = 0; search < 20; ++search) {
    EXPECT_EQ(parts.find_instances(key(kLevels + 1)), ModelParts::Found::kAll);
    EXPECT_TRUE(parts.instances().empty());
  }
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

TEST(ThreeMf, ASearchForAMeshTakesNoLongerBesideManyOthers) {
  // A file of 7 kB may have a thousand such meshes, and each is searched for.
  double alone = 1e9, beside_many = 1e9;
  for (int attempt = 0; attempt < 3; ++attempt) {
    alone = std::min(alone, seconds_of_searches(0));
    beside_many = std::min(beside_many, seconds_of_searches(900));
  }
  EXPECT_LT(beside_many, 8 * alone) << alone << " s alone";
}

TEST(ThreeMf, AMeshAtManyPlacesReportsProgressAsOftenAsManyMeshes) {
  constexpr std::size_t kPlaces = 512;
  std::string items;
  for (std::size_t k = 0; k < kPlaces; ++k) items += "<item objectid=\"1\"/>";
  const TestMesh ball = ball_mesh({0, 0, 0}, 1, 3);
  const std::string bytes = threemf_with(built(object_of(ball, 1), items));
  ArenaBlock room(257 * 1024);
  ModelCopy copy(*(*room).take_bottom<std::byte>(256 * 1024, "test"));
  ThreeMfTriangles first, copied;
  ASSERT_TRUE(ThreeMf::read(bytes, 1000, first, copy));
  ASSERT_TRUE(copy.is_finished());
  std::vector<std::byte> workspace(kReaderWorkspace);
  ASSERT_TRUE(read_mesh(copy, copied, workspace));
  EXPECT_EQ(copied.count, kPlaces * ball.faces.size());
  EXPECT_LE(copied.most_unreported, std::size_t{1} << 17U);
}

TEST(ThreeMf, IsPrintedAtItsSizeWhateverUnitIsAskedFor) {
  std::string model = built(block(1), "<item objectid=\"1\"/>");
  model.replace(model.find("millimeter"), 10, "inch");
  for (const Units units : {Units::kMillimetres, Units::kInches, Units::kAuto}) {
    SliceSettings settings = settings_with_pitch(0.5F);
    settings.placement.units = units;
    const Slicing slicing(MemorySource(threemf_with(model), "part.3mf"), settings, 64 * kMiB);
    EXPECT_NEAR(slicing.report().placement.size_mm.maxCoeff(), 76.2, 1e-3) << to_string(units);
    EXPECT_EQ(slicing.report().ignored_units, units == Units::kInches ? std::optional(units) : std::nullopt);
  }
}

TEST(ThreeMf, BesideAMeshInAnotherUnitIsRefused) {
  const std::string stl = binary_stl(kBlock);
  const std::string packed = threemf_of(kBlock);
  MemorySource first(stl, "a.stl");
  MemorySource second(packed, "b.3mf");
  ByteSource* const sources[] = {&first, &second};
  ArenaBlock arena(64 * kMiB);
  SliceSettings settings = settings_with_pitch(0.5F);
  settings.placement.units = Units::kCentimetres;
  SliceReport report;
  const auto rrep = slice(ScanSources(sources), settings, *arena, nullptr, report);
  ASSERT_FALSE(rrep);
  EXPECT_EQ(rrep.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(rrep.error().message(), HasSubstr("E57 and 3MF files are in mm"));
}

}  // namespace
}  // namespace plumbline
