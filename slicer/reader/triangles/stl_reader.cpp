#include <bit>
#include <cstring>
#include <limits>

#include "slicer/core/words/plural.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/records/records_end.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/triangles/triangle_formats.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::size_t kHead = 84;    ///< bytes before the first triangle of a binary file
constexpr std::size_t kRecord = 50;  ///< bytes of a triangle: normal, three corners, two bytes of attributes
constexpr std::size_t kNormal = 12;  ///< bytes; the corners say more than the normal, which many programs leave 0

float load_float(const char* bytes) {
  std::uint32_t word = 0;
  for (std::uint32_t i = 0; i < 4; ++i) word |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  return std::bit_cast<float>(word);
}

std::uint64_t declared_triangles(const char* head) {
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < 4; ++i) count |= std::uint64_t{static_cast<unsigned char>(head[80 + i])} << (8 * i);
  return count;
}

/// A binary file may begin with "solid", too, and text with something else: a comment, or a program's name. A size that fits the
/// number of triangles decides, else the words of facets, else a byte that no text has.
bool is_ascii(const ByteInput& input) {
  const std::string_view window(input.begin(), input.available());
  if (window.size() >= kHead && input.size() == kHead + kRecord * declared_triangles(window.data())) return false;
  constexpr Separators kBlanksAndLineEnds{" \t\v\f\r\n"};
  const bool is_text = window.find('\0') == std::string_view::npos;
  if (is_text && same_word(LineWords(window, kBlanksAndLineEnds).next(), "solid")) return true;
  const auto has = [&](std::string_view word) { return window.find(word) != std::string_view::npos; };
  return (has("facet") && has("vertex")) || (has("FACET") && has("VERTEX"));
}

Status read_binary(ByteInput& input, TriangleBatch& batch) {
  batch.summary().encoding = "binary little endian";
  const auto head = input.fill(kHead);
  PLUMBLINE_TRY(head);
  if (*head < kHead) {
    return input.fail(
        ErrorCode::kTruncated,
        "the file has %zu byte%s, a binary STL has 84 before its first triangle;\tcopy or export it again", *head,
        plural_s(*head));
  }
  std::uint64_t count = declared_triangles(input.begin());
  input.consume(kHead);
  const bool to_the_end = count == 0 || count == std::numeric_limits<std::uint32_t>::max();
  if (to_the_end) count = std::numeric_limits<std::uint64_t>::max();
  for (std::uint64_t done = 0; done < count; ++done) {
    const auto ready = input.fill(kRecord);
    PLUMBLINE_TRY(ready);
    if (*ready < kRecord) {
      if (to_the_end) return {};
      return input.fail(
          ErrorCode::kTruncated,
          "the file ends at byte %llu, with %llu of the %llu triangles that its header declares;\tcopy or "
          "export it again",
          static_cast<unsigned long long>(input.bytes_read()), static_cast<unsigned long long>(done),
          static_cast<unsigned long long>(count));
    }
    Triangle triangle;
    const char* at = input.begin() + kNormal;
    for (Vec3d& corner : triangle) {
      for (int axis = 0; axis < 3; ++axis, at += 4) corner[axis] = static_cast<double>(load_float(at));
    }
    input.consume(kRecord);
    ++batch.summary().faces;
    PLUMBLINE_TRY(batch.add(triangle));
  }
  return check_end(input, "triangles", count, kRecord);
}

class AsciiReader {
 public:
  AsciiReader(ByteInput& input, TriangleBatch& batch) : lines_(input), batch_(batch) {}

  Status read() {
    batch_.summary().encoding = "ascii";
    Line line;
    for (;;) {
      const auto found = lines_.next(line);
      PLUMBLINE_TRY(found);
      if (!*found) break;
      PLUMBLINE_TRY(read_line(line));
    }
    if (corners_ == 0 && !open_) return {};
    return lines_.input().fail(ErrorCode::kTruncated,
                               "the file ends after line %llu, before 'endsolid';\tcopy or export it again", number());
  }

 private:
  unsigned long long number() const { return static_cast<unsigned long long>(lines_.number()); }

  /// A line has one keyword or a whole facet.
  Status read_line(const Line& line) {
    if (line.cut) {
      return lines_.input().fail(ErrorCode::kUnsupported,
                                 "line %llu: longer than a line may be (%zu bytes);\texport it as binary STL", number(),
                                 lines_.input().capacity());
    }
    // What a failing stick or a broken copy leaves: words that are lost would be facets that are missing.
    if (open_ && line.text.find('\0') != std::string_view::npos) {
      return fail_zeros(lines_);
    }
    LineWords words(line.text);
    for (auto keyword = words.next(); !keyword.empty(); keyword = words.next()) {
      // Most words are numbers of a normal.
      switch (keyword.front()) {
        case 's':
        case 'S':
          if (same_word(keyword, "solid")) return {};  // what follows is its name
          break;
        case 'v':
        case 'V':
          if (same_word(keyword, "vertex")) PLUMBLINE_TRY(add_corner(line, words));
          break;
        case 'o':
        case 'O':
          if (corners_ % 3 != 0 && same_word(keyword, "outer")) return fail_corners();
          break;
        case 'f':
        case 'F':
        case 'e':
        case 'E': {
          const bool begins = same_word(keyword, "facet");
          const bool ends = same_word(keyword, "endfacet");
          const bool is_last = same_word(keyword, "endsolid");
          if (!begins && !ends && !is_last) {
            if (corners_ < 3 && same_word(keyword, "endloop")) return fail_corners();
            break;
          }
          PLUMBLINE_TRY(end_facet(in_facet_ || ends));
          in_facet_ = begins;
          open_ = !is_last;
          if (is_last) return {};
          break;
        }
        default: break;
      }
    }
    return {};
  }

  Status add_corner(const Line& line, LineWords& words) {
    const std::string_view rest = words.rest();
    const char* at = rest.data();
    const char* const last = at + rest.size();
    Vec3d corner;
    for (int axis = 0; axis < 3; ++axis) {
      at = skip_separators(at, last, kBlanks);
      const char* const end = skip_word(at, last, kBlanks);
      const char* stop = parse_real(at, last, corner[axis]);
      if (stop != end) stop = parse_decimal_comma(at, end, corner[axis]);
      if (stop != end || at == end) {
        const std::string_view word(at, static_cast<std::size_t>(end - at));
        return fail_row(lines_, line,
                        {.kind = word.empty() ? RowOutcome::Kind::kTooFew : RowOutcome::Kind::kNotANumber,
                         .word = word,
                         .wanted = axis == 0   ? "x"
                                   : axis == 1 ? "y"
                                               : "z"});
      }
      at = stop;
    }
    if (corners_ == 3) {
      return lines_.input().fail(ErrorCode::kMalformed,
                                 "line %llu: a facet has more than three corners;\texport the file again", number());
    }
    triangle_[corners_++] = corner;
    words = LineWords({at, static_cast<std::size_t>(last - at)});
    return {};
  }

  /// @param begun  without corners, lines of the facet are lost
  Status end_facet(bool begun) {
    if (corners_ == 0 && !begun) return {};
    if (corners_ < 3) return fail_corners();
    corners_ = 0;
    ++batch_.summary().faces;
    return batch_.add(triangle_);
  }

  tl::unexpected<Error> fail_corners() const {
    return lines_.input().fail(ErrorCode::kMalformed,
                               "line %llu: a facet has %zu corner%s, not three;\texport the file again", number(),
                               corners_, plural_s(corners_));
  }

  LineInput lines_;
  TriangleBatch& batch_;
  Triangle triangle_;
  std::size_t corners_ = 0;
  bool in_facet_ = false;
  bool open_ = true;  ///< no 'endsolid' since the last facet
};

}  // namespace

Status read_stl(ByteInput& input, TriangleBatch& batch) {
  batch.summary().format = ScanFormat::kStl;
  const auto filled = input.fill(input.capacity());
  PLUMBLINE_TRY(filled);
  return is_ascii(input) ? AsciiReader(input, batch).read() : read_binary(input, batch);
}

}  // namespace plumbline::inline slicer
