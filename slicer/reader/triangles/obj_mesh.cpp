#include <charconv>

#include "slicer/reader/formats/obj_lines.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/triangles/faces.hpp"
#include "slicer/reader/triangles/triangle_formats.hpp"

namespace plumbline::inline slicer {
namespace {

class ObjMeshReader {
 public:
  ObjMeshReader(ByteInput& input, TriangleBatch& batch, VertexList& vertices, std::span<char> joined)
      : lines_(input, joined), batch_(batch), vertices_(vertices), fan_(vertices, batch) {}

  Status read() {
    batch_.summary().format = ScanFormat::kObj;
    batch_.summary().encoding = "ascii";
    const auto wanted = [](std::string_view keyword) {
      return keyword == "v" || keyword == "f" || keyword == "fo" || keyword == "surf";
    };
    for (;;) {
      const auto found = lines_.next(wanted);
      PLUMBLINE_TRY(found);
      if (!*found) return {};
      if (lines_.keyword() == "surf") {
        return input().fail(ErrorCode::kUnsupported,
                            "line %llu: a free-form surface, whose vertices don't lie on it;\texport it as a mesh",
                            number());
      }
      PLUMBLINE_TRY(lines_.keyword() == "v" ? read_vertex() : read_face());
    }
  }

 private:
  const ByteInput& input() const { return lines_.lines().input(); }
  unsigned long long number() const { return static_cast<unsigned long long>(lines_.lines().number()); }

  Status read_vertex() {
    const char* at = lines_.rest().data();
    const char* const last = at + lines_.rest().size();
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) {
      at = skip_separators(at, last, kBlanks);
      const char* const end = skip_word(at, last, kBlanks);
      const char* stop = parse_real(at, last, p[axis]);
      if (stop != end) stop = parse_decimal_comma(at, end, p[axis]);
      if (stop != end || at == end) {
        const std::string_view word(at, static_cast<std::size_t>(end - at));
        return fail_row(lines_.lines(), lines_.line(),
                        {.kind = word.empty() ? RowOutcome::Kind::kTooFew : RowOutcome::Kind::kNotANumber,
                         .word = word,
                         .wanted = axis == 0   ? "x"
                                   : axis == 1 ? "y"
                                               : "z"});
      }
      at = stop;
    }
    return vertices_.add(p) ? Status() : Status(fail_vertices(input(), vertices_));
  }

  /// Corners are "v", "v/vt", "v//vn" or "v/vt/vn": numbers from 1, or from -1 backwards.
  Status read_face() {
    if (lines_.line().cut) {
      return telling(
          Told(ToldCode::kFacesBroken),
          input().fail(
              ErrorCode::kUnsupported,
              "line %llu: a face longer than a line may be (%zu bytes);\texport triangles, or read it as points",
              number(), input().capacity()));
    }
    fan_.begin();
    LineWords words(lines_.rest());
    for (auto word = words.next(); !word.empty(); word = words.next()) {
      if (word.front() == '#') break;
      const auto digits = word.substr(0, word.find('/'));
      std::int64_t index = 0;
      const auto [stop, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
      if (problem != std::errc() || stop != digits.data() + digits.size()) {
        return telling(
            Told(ToldCode::kFacesBroken),
            input().fail(
                lines_.line().unterminated ? ErrorCode::kTruncated : ErrorCode::kMalformed,
                "line %llu: expected the number of a vertex, found '%s';\tcopy or export the file again, or read it "
                "as points",
                number(), Quote(word).c_str()));
      }
      const auto count = static_cast<std::int64_t>(vertices_.size());
      if (index == 0 || index > count || index < -count) {
        return telling(
            Told(ToldCode::kFacesBroken),
            input().fail(ErrorCode::kMalformed,
                         "line %llu: a face names vertex %lld, but %lld are before it, numbered from 1;\texport the "
                         "file again, or read it as points",
                         number(), static_cast<long long>(index), static_cast<long long>(count)));
      }
      PLUMBLINE_TRY(fan_.add(static_cast<std::uint64_t>(index > 0 ? index - 1 : count + index)));
    }
    if (!lines_.line().unterminated || fan_.corners() >= 3) return {};
    return telling(
        Told(ToldCode::kFacesBroken),
        input().fail(ErrorCode::kTruncated,
                     "line %llu: the file ends in the middle of a face;\tcopy or export it again, or read it as points",
                     number()));
  }

  ObjLines lines_;
  TriangleBatch& batch_;
  VertexList& vertices_;
  FaceFan fan_;
};

}  // namespace

Status read_obj_mesh(ByteInput& input, TriangleBatch& batch, const MeshRoom& room) {
  const auto joined = room.memory.take_bottom<char>(ObjLines::kLongestJoined, "reading OBJ");
  PLUMBLINE_TRY(joined);
  return ObjMeshReader(input, batch, room.vertices, *joined).read();
}

}  // namespace plumbline::inline slicer
