#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/records/records_end.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/triangles/faces.hpp"
#include "slicer/reader/triangles/triangle_formats.hpp"

namespace plumbline::inline slicer {
namespace {

class OffReader {
 public:
  OffReader(ByteInput& input, TriangleBatch& batch, VertexList& vertices)
      : lines_(input), batch_(batch), vertices_(vertices) {}

  Status read() {
    batch_.summary().format = ScanFormat::kOff;
    batch_.summary().encoding = "ascii";
    PLUMBLINE_TRY(next_line("its header"));
    // OFF and its like: programs leave it out, and data sets have it glued to the number after it.
    const auto first = words_.next();
    const std::size_t end = first.find_last_not_of("0123456789") + 1;
    words_ = LineWords(text_.substr(static_cast<std::size_t>(first.data() - text_.data()) + end));
    if (same_word(LineWords(words_.rest()).next(), "BINARY")) {
      return lines_.input().fail(ErrorCode::kUnsupported, "line 1: binary OFF can't be read;\texport it as ascii");
    }
    std::uint64_t vertices = 0;
    std::uint64_t faces = 0;
    PLUMBLINE_TRY(count("the number of its vertices", vertices));
    const std::uint64_t line = lines_.number();
    PLUMBLINE_TRY(count("the number of its faces", faces));
    std::uint64_t edges = 0;
    if (lines_.number() != line) PLUMBLINE_TRY(count("the number of its edges", edges));
    for (std::uint64_t i = 0; i < vertices; ++i) PLUMBLINE_TRY(read_vertex());
    FaceFan fan(vertices_, batch_);
    for (std::uint64_t i = 0; i < faces; ++i) PLUMBLINE_TRY(read_face(fan));
    return check_text_end(lines_, "faces", faces);
  }

 private:
  unsigned long long number() const { return static_cast<unsigned long long>(lines_.number()); }

  /// Sets text_ and words_ to the next line that has more than a comment.
  Status next_line(const char* wanted) {
    for (;;) {
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (!*found) {
        return lines_.input().fail(ErrorCode::kTruncated,
                                   "the file ends after line %llu, before %s;\tcopy or export it again", number(),
                                   wanted);
      }
      if (line_.cut) {
        return lines_.input().fail(ErrorCode::kUnsupported,
                                   "line %llu: longer than a line may be (%zu bytes);\texport triangles", number(),
                                   lines_.input().capacity());
      }
      text_ = line_.text.substr(0, line_.text.find('#'));
      words_ = LineWords(text_);
      if (!is_blank(text_)) return {};
    }
  }

  /// Takes the next word, which may be on a later line.
  Status count(const char* wanted, std::uint64_t& out) {
    auto word = words_.next();
    while (word.empty()) {
      PLUMBLINE_TRY(next_line(wanted));
      word = words_.next();
    }
    const auto value = parse_count(word);
    if (!value) {
      return lines_.input().fail(line_.unterminated ? ErrorCode::kTruncated : ErrorCode::kMalformed,
                                 "line %llu: expected %s, found '%s';\tcopy or export the file again", number(), wanted,
                                 Quote(word).c_str());
    }
    out = *value;
    return {};
  }

  Status read_vertex() {
    PLUMBLINE_TRY(next_line("the last vertex that its header declares"));
    const char* at = text_.data();
    const char* const last = at + text_.size();
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) {
      at = skip_separators(at, last, kBlanks);
      const char* const stop = parse_real(at, last, p[axis]);
      if (stop == nullptr || (stop != last && !kBlanks(*stop))) {
        return lines_.input().fail(
            line_.unterminated ? ErrorCode::kTruncated : ErrorCode::kMalformed,
            "line %llu: expected three numbers of a vertex, found '%s';\tcopy or export the file again", number(),
            Quote(text_).c_str());
      }
      at = stop;
    }
    return vertices_.add(p) ? Status() : Status(fail_vertices(lines_.input(), vertices_));
  }

  Status read_face(FaceFan& fan) {
    PLUMBLINE_TRY(next_line("the last face that its header declares"));
    std::uint64_t corners = 0;
    PLUMBLINE_TRY(count("the number of a face's corners", corners));
    const std::uint64_t line = lines_.number();
    fan.begin();
    for (std::uint64_t i = 0; i < corners; ++i) {
      std::uint64_t vertex = 0;
      PLUMBLINE_TRY(count("the number of a vertex", vertex));
      if (vertex >= vertices_.size()) {
        return lines_.input().fail(ErrorCode::kMalformed,
                                   "line %llu: a face names vertex %llu, but there are %llu, numbered from 0;\texport "
                                   "the file again",
                                   number(), static_cast<unsigned long long>(vertex),
                                   static_cast<unsigned long long>(vertices_.size()));
      }
      PLUMBLINE_TRY(fan.add(vertex));
    }
    // A colour may follow on the line of a face. Behind one that goes on over several lines, it is rather the next face, and a
    // corner is missing.
    const auto more = words_.next();
    if (lines_.number() == line || more.empty()) return {};
    return lines_.input().fail(
        ErrorCode::kMalformed,
        "line %llu: expected the end of a face that begins in line %llu, found '%s';\texport the "
        "file again",
        number(), static_cast<unsigned long long>(line), Quote(more).c_str());
  }

  LineInput lines_;
  TriangleBatch& batch_;
  VertexList& vertices_;
  Line line_;
  std::string_view text_;  ///< of the line, without its comment
  LineWords words_{{}};    ///< of text_, those that were not read
};

}  // namespace

Status read_off(ByteInput& input, TriangleBatch& batch, const MeshRoom& room) {
  return OffReader(input, batch, room.vertices).read();
}

}  // namespace plumbline::inline slicer
