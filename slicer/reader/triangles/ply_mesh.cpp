#include <cmath>

#include "slicer/reader/formats/ply_header.hpp"
#include "slicer/reader/records/record_binary.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/records/records_end.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/triangles/faces.hpp"
#include "slicer/reader/triangles/triangle_formats.hpp"

namespace plumbline::inline slicer {
namespace {

/// 2^53: a double holds every index up to it.
constexpr double kLargestIndex = 9007199254740992.0;

/// Adds the vertices of the file to the list.
class VertexSink final : public PointSink {
 public:
  VertexSink(const ByteInput& input, VertexList& vertices) : input_(input), vertices_(vertices) {}
  Status begin(const ScanHeader& /*header*/) override { return {}; }
  Status take(std::span<const ScanPoint> points) override {
    for (const ScanPoint& p : points) {
      if (!vertices_.add({p.x, p.y, p.z})) return fail_vertices(input_, vertices_);
    }
    return {};
  }
  bool progress(double /*fraction*/) override { return true; }

 private:
  const ByteInput& input_;
  VertexList& vertices_;
};

class PlyMeshReader {
 public:
  PlyMeshReader(ByteInput& input, TriangleBatch& batch, VertexList& vertices)
      : input_(input),
        lines_(input),
        batch_(batch),
        vertices_(vertices),
        fan_(vertices, batch),
        strip_(vertices, batch) {}

  Status read(Arena& memory) {
    const auto header = read_ply_header(lines_, memory);
    PLUMBLINE_TRY(header);
    header_ = *header;
    batch_.summary().format = ScanFormat::kPly;
    batch_.summary().encoding = header_.encoding();
    if (header_.declared_faces == 0) {
      return telling(Told(ToldCode::kNoFaces),
                     input_.fail(ErrorCode::kUnsupported, "the file has points but no faces;\tread it as points"));
    }
    if (header_.face.count < header_.declared_faces) {
      return telling(
          Told(ToldCode::kFacesBroken),
          input_.fail(ErrorCode::kUnsupported,
                      "%llu of its %llu faces can be read: those of one element behind the vertices, with a list "
                      "'vertex_indices';\texport it again, or read it as points",
                      static_cast<unsigned long long>(header_.face.count),
                      static_cast<unsigned long long>(header_.declared_faces)));
    }
    PLUMBLINE_TRY(skip(header_.before_vertex));
    PLUMBLINE_TRY(read_vertices(memory));
    PLUMBLINE_TRY(skip(header_.before_face));
    for (std::uint64_t done = 0; done < header_.face.count; ++done) {
      face_ = done;
      PLUMBLINE_TRY(header_.ascii ? read_text_face() : read_binary_face());
    }
    if (!header_.ends_with_faces) return {};
    const PlyElement& face = header_.face;
    return header_.ascii ? records_.check_end("faces", face.count)
                         : check_end(input_, "faces", face.count, face.layout.least_bytes());
  }

 private:
  using Kind = RecordStep::Kind;

  Status skip(std::span<const PlyElement> elements) {
    for (const PlyElement& element : elements) {
      if (element.layout.steps().empty()) continue;  // no properties: no bytes, no words
      PLUMBLINE_TRY(header_.ascii ? records_.skip(element.layout, element.count, "records before its faces")
                                  : skip_binary_records(input_, element.layout, element.count, header_.order));
    }
    return {};
  }

  Status read_vertices(Arena& memory) {
    const auto room = memory.take_bottom<ScanPoint>(PointBatch::kPoints, "reading PLY");
    PLUMBLINE_TRY(room);
    VertexSink sink(input_, vertices_);
    ScanSummary summary;
    PointBatch points(sink, *room, summary);
    points.keep_not_finite();
    PLUMBLINE_TRY(points.begin({}));
    const PlyElement& vertex = header_.vertex;
    PLUMBLINE_TRY(header_.ascii ? records_.read_points(vertex.layout, vertex.count, points)
                                : read_binary_points(input_, vertex.layout, vertex.count, header_.order, points));
    is_loose_ = header_.ascii && records_.is_loose();
    return points.flush();
  }

  tl::unexpected<Error> fail_truncated() const {
    return telling(
        Told(ToldCode::kFacesBroken),
        input_.fail(ErrorCode::kTruncated,
                    "the file ends at byte %llu, with %llu of the %llu faces that its header declares;\tcopy or "
                    "export it again, or read it as points",
                    static_cast<unsigned long long>(input_.bytes_read()), static_cast<unsigned long long>(face_),
                    static_cast<unsigned long long>(header_.face.count)));
  }

  void begin_corners() { header_.strips ? strip_.begin() : fan_.begin(); }

  Status add_corner(double index) {
    if (header_.strips && index == -1) {
      strip_.begin();
      return {};
    }
    if (!(index >= 0) || index >= static_cast<double>(vertices_.size()) || index >= kLargestIndex ||
        index != std::floor(index)) {
      return telling(Told(ToldCode::kFacesBroken), input_.fail(ErrorCode::kMalformed,
                                                               "face %llu names vertex %.10g, but there are %llu, "
                                                               "numbered from 0;\texport the file again, or read it as "
                                                               "points",
                                                               static_cast<unsigned long long>(face_), index,
                                                               static_cast<unsigned long long>(vertices_.size())));
    }
    const auto vertex = static_cast<std::uint64_t>(index);
    return header_.strips ? strip_.add(vertex) : fan_.add(vertex);
  }

  /// @returns the scalar at the window's beginning
  Expected<double> take_scalar(ScalarType type) {
    const std::size_t size = size_of(type);
    const auto ready = input_.fill(size);
    PLUMBLINE_TRY(ready);
    if (*ready < size) return fail_truncated();
    const double value = load_scalar(type, input_.begin(), header_.order);
    input_.consume(size);
    return value;
  }

  Status read_binary_face() {
    for (const RecordStep& step : header_.face.layout.steps()) {
      std::uint64_t bytes = step.bytes;
      if (step.kind == Kind::kList) {
        const auto count = take_scalar(step.type);
        PLUMBLINE_TRY(count);
        if (!(*count >= 0) || *count > 1e15) {
          return input_.fail(ErrorCode::kMalformed,
                             "byte %llu: a list claims to have %.0f items; the file is damaged, export it again",
                             static_cast<unsigned long long>(input_.offset()), *count);
        }
        const auto items = static_cast<std::uint64_t>(*count);
        if (step.slot == 1) {
          begin_corners();
          for (std::uint64_t i = 0; i < items; ++i) {
            const auto index = take_scalar(step.item);
            PLUMBLINE_TRY(index);
            PLUMBLINE_TRY(add_corner(*index));
          }
          continue;
        }
        bytes = items * size_of(step.item);
      }
      const auto skipped = input_.skip(bytes);
      PLUMBLINE_TRY(skipped);
      if (*skipped < bytes) return fail_truncated();
    }
    return {};
  }

  Status read_text_face() {
    const bool begins_line = records_.is_line_end();
    unsigned long long line = 0;
    bool has_corners = false;
    for (const RecordStep& step : header_.face.layout.steps()) {
      if (has_corners && records_.is_line_end()) break;  // what follows the corners may be missing
      std::uint64_t items = step.words;
      const bool is_corners = step.kind == Kind::kList && step.slot == 1;
      if (step.kind == Kind::kList) {
        const auto word = records_.next_word();
        PLUMBLINE_TRY(word);
        const auto count = parse_count(*word);
        if (!count) return fail_face(*word);
        if (line == 0) line = lines_.number();
        items = *count;
        if (is_corners) begin_corners();
      }
      for (std::uint64_t i = 0; i < items; ++i) {
        const auto word = records_.next_word();
        PLUMBLINE_TRY(word);
        if (word->empty()) return fail_truncated();
        if (!is_corners) continue;
        const auto whole = parse_count(*word);
        double index = static_cast<double>(whole.value_or(0));
        const char* const end = word->data() + word->size();
        if (!whole && parse_real(word->data(), end, index) != end) return fail_face(*word);
        PLUMBLINE_TRY(add_corner(index));
      }
      has_corners = has_corners || is_corners;
    }
    // A corner that is missing would be taken from the next face.
    const bool is_whole = line == lines_.number() || (begins_line && records_.is_line_end());
    return is_whole || is_loose_ ? Status() : Status(fail_face(records_.line().text));
  }

  tl::unexpected<Error> fail_face(std::string_view word) const {
    if (word.empty()) return fail_truncated();
    return telling(Told(ToldCode::kFacesBroken),
                   input_.fail(records_.line().unterminated ? ErrorCode::kTruncated : ErrorCode::kMalformed,
                               "line %llu: expected a face, found '%s';\tcopy or export the file again, or read it as "
                               "points",
                               static_cast<unsigned long long>(lines_.number()), Quote(word).c_str()));
  }

  ByteInput& input_;
  LineInput lines_;
  TextRecords records_{lines_};
  TriangleBatch& batch_;
  VertexList& vertices_;
  FaceFan fan_;
  FaceStrip strip_;
  PlyHeader header_;
  std::uint64_t face_ = 0;
  bool is_loose_ = false;  ///< lines of the vertices end anywhere
};

}  // namespace

Status read_ply_mesh(ByteInput& input, TriangleBatch& batch, const MeshRoom& room) {
  return PlyMeshReader(input, batch, room.vertices).read(room.memory);
}

}  // namespace plumbline::inline slicer
