#include "slicer/reader/formats/ply_header.hpp"

#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

/// Far above what any scanner writes; more only come from an attack or a damaged file.
constexpr std::size_t kMaxSteps = 1024;
constexpr std::size_t kMaxElements = 64;

std::optional<ScalarType> type_of(std::string_view name) {
  static constexpr struct {
    std::string_view name;
    ScalarType type;
  } kTypes[] = {
      {"char", ScalarType::kInt8},     {"int8", ScalarType::kInt8},     {"uchar", ScalarType::kUint8},
      {"uint8", ScalarType::kUint8},   {"short", ScalarType::kInt16},   {"int16", ScalarType::kInt16},
      {"ushort", ScalarType::kUint16}, {"uint16", ScalarType::kUint16}, {"int", ScalarType::kInt32},
      {"int32", ScalarType::kInt32},   {"uint", ScalarType::kUint32},   {"uint32", ScalarType::kUint32},
      {"int64", ScalarType::kInt64},   {"uint64", ScalarType::kUint64}, {"float", ScalarType::kFloat},
      {"float32", ScalarType::kFloat}, {"double", ScalarType::kDouble}, {"float64", ScalarType::kDouble},
  };
  for (const auto& known : kTypes) {
    if (same_word(name, known.name)) return known.type;
  }
  return std::nullopt;
}

class HeaderParser {
 public:
  HeaderParser(LineInput& lines, std::span<RecordStep> steps, std::span<PlyElement> elements)
      : lines_(lines), steps_(steps), elements_(elements) {}

  Expected<PlyHeader> parse() {
    Line line;
    for (bool first = true;; first = false) {
      const auto found = lines_.next(line);
      PLUMBLINE_TRY(found);
      if (!*found) {
        return lines_.input().fail(ErrorCode::kTruncated,
                                   "the file ends after line %llu, before 'end_header';\tcopy or export it again",
                                   number());
      }
      LineWords words(line.text);
      const std::string_view keyword = words.next();
      if (first || keyword == "comment" || keyword == "obj_info") continue;
      if (line.cut) {
        return lines_.input().fail(ErrorCode::kMalformed, "line %llu: a line of the header is longer than %zu bytes",
                                   number(), lines_.input().capacity());
      }
      if (keyword.empty()) continue;
      if (keyword == "end_header") return finish();
      if (keyword == "format") {
        PLUMBLINE_TRY(parse_format(words));
      } else if (keyword == "element") {
        PLUMBLINE_TRY(parse_element(words));
      } else if (keyword == "property") {
        PLUMBLINE_TRY(parse_property(words));
      } else if (place_ != Place::kStart) {
        return expected("'element', 'property', 'comment' or 'end_header'", keyword);
      }
      // Before the first element, an unknown line is a comment without its keyword (Blender once wrote such): it can't
      // shift a column. After the first element it could.
    }
  }

 private:
  /// The element whose properties are being read: none yet, one before the vertices, the vertices, one between them and the
  /// faces, the faces, or one that does not matter.
  enum class Place : std::uint8_t { kStart, kBefore, kVertex, kBetween, kFace, kAfter };

  unsigned long long number() const { return static_cast<unsigned long long>(lines_.number()); }
  static bool is_faces(std::string_view element) { return element == "face" || element == "tristrips"; }

  tl::unexpected<Error> expected(const char* what, std::string_view found) const {
    return lines_.input().fail(ErrorCode::kMalformed, "line %llu: expected %s, found '%s';\texport the file again",
                               number(), what, Quote(found).c_str());
  }

  Status parse_format(LineWords& words) {
    const auto encoding = words.next();
    const auto version = words.next();
    if (encoding == "ascii") {
      header_.ascii = true;
    } else if (encoding == "binary_little_endian" || encoding == "binary_big_endian") {
      header_.ascii = false;
      header_.order = encoding == "binary_big_endian" ? std::endian::big : std::endian::little;
    } else {
      return expected("a format ascii, binary_little_endian or binary_big_endian", encoding);
    }
    if (version != "1.0") {
      return lines_.input().fail(ErrorCode::kUnsupported,
                                 "line %llu: PLY version '%s' is not supported;\texport the file as version 1.0",
                                 number(), Quote(version).c_str());
    }
    has_format_ = true;
    return {};
  }

  Status parse_element(LineWords& words) {
    const auto name = words.next();
    const auto count_word = words.next();
    const auto count = parse_count(count_word);
    if (name.empty()) return expected("the name of an element", name);
    if (!count) return expected("a number of elements from 0 to 2^64 - 1", count_word);
    if (is_faces(name)) header_.declared_faces = saturating_add(header_.declared_faces, *count);
    if (place_ >= Place::kVertex) {
      begin_after_vertex(name, *count);
      return {};
    }
    if (place_ == Place::kBefore) close(elements_[before_++]);
    if (name == "vertex") {
      place_ = Place::kVertex;
    } else {
      if (before_ == elements_.size()) {
        return lines_.input().fail(ErrorCode::kUnsupported,
                                   "line %llu: more than %zu elements before the vertices;\texport only the points",
                                   number(), elements_.size());
      }
      place_ = Place::kBefore;
    }
    count_ = *count;
    layout_ = RecordLayout(steps_);
    return {};
  }

  void begin_after_vertex(std::string_view name, std::uint64_t count) {
    close_after_vertex();
    header_.ends_with_vertices = header_.ends_with_vertices && count == 0;
    header_.ends_with_faces = header_.ends_with_faces && (place_ < Place::kFace || count == 0);
    if (place_ == Place::kFace || place_ == Place::kAfter || before_ + between_ == elements_.size()) {
      place_ = Place::kAfter;
      return;
    }
    header_.strips = name == "tristrips";
    place_ = is_faces(name) ? Place::kFace : Place::kBetween;
    count_ = count;
    layout_ = RecordLayout(steps_);
  }

  void close_after_vertex() {
    if (place_ == Place::kVertex) close(header_.vertex);
    if (place_ == Place::kBetween) close(elements_[before_ + between_++]);
    if (place_ == Place::kFace) close(header_.face);
  }

  /// @returns false if the property can't be understood
  bool parse_after_vertex(LineWords& words) {
    auto word = words.next();
    if (word != "list") {
      const auto type = type_of(word);
      return type && layout_.add_skip(size_of(*type), 1);
    }
    const auto count = type_of(words.next());
    const auto item = type_of(words.next());
    if (!count || !item || !is_integer(*count)) return false;
    const auto name = words.next();
    const bool wanted = place_ == Place::kFace && (name == "vertex_indices" || name == "vertex_index");
    return layout_.add_list(*count, *item, wanted);
  }

  Status parse_property(LineWords& words) {
    if (place_ == Place::kStart) return expected("an element before its properties", "property");
    if (place_ == Place::kAfter) return {};
    if (place_ > Place::kVertex) {
      if (!parse_after_vertex(words)) place_ = Place::kAfter;
      return {};
    }
    auto word = words.next();
    const bool is_list = word == "list";
    std::optional<ScalarType> count;
    if (is_list) {
      word = words.next();
      count = type_of(word);
      if (!count || !is_integer(*count)) return expected("an integer type for the length of a list", word);
      word = words.next();
    }
    const auto type = type_of(word);
    if (!type) return expected("a type such as float, double, uchar or int32", word);
    const auto name = words.next();
    if (name.empty()) return expected("the name of a property", name);
    std::size_t slot = place_ == Place::kVertex ? slot_of(name) : kRowSlots;
    if (slot == kSlots) slot = splat_slot_of(name);
    is_compressed_ = is_compressed_ || name == "packed_position";
    if (is_list && slot < kSlots) return expected("one number a vertex, not a list, for a coordinate", name);
    const bool fits = is_list            ? layout_.add_list(*count, *type)
                      : slot < kRowSlots ? layout_.add_field(*type, slot)
                                         : layout_.add_skip(size_of(*type), 1);
    if (!fits) {
      return lines_.input().fail(ErrorCode::kUnsupported,
                                 "line %llu: too many properties (at most %zu can be read);\texport only the points",
                                 number(), kMaxSteps);
    }
    return {};
  }

  /// Completes the open element. The steps that it did not use are left for the next one.
  void close(PlyElement& element) {
    element = {count_, layout_};
    steps_ = steps_.subspan(layout_.steps().size());
  }

  Expected<PlyHeader> finish() {
    if (!has_format_) return expected("a line 'format' before the end of the header", "end_header");
    if (place_ >= Place::kVertex) close_after_vertex();
    if (place_ == Place::kStart || place_ == Place::kBefore) {
      return lines_.input().fail(ErrorCode::kNoPoints,
                                 "line %llu: the header declares no 'element vertex', so there are no points to print",
                                 number());
    }
    if (is_compressed_ && !header_.vertex.layout.has_position()) {
      return telling(
          Told(ToldCode::kSplatsCompressed),
          lines_.input().fail(ErrorCode::kUnsupported,
                              "line %llu: these are Gaussian splats in a compressed PLY;\texport them as PLY without "
                              "compression, or as SPZ",
                              number()));
    }
    if (!header_.vertex.layout.has_position()) {
      return lines_.input().fail(
          ErrorCode::kNoPoints, "line %llu: the vertices have no property '%s';\texport them with x, y and z", number(),
          !header_.vertex.layout.has(kX)   ? "x"
          : !header_.vertex.layout.has(kY) ? "y"
                                           : "z");
    }
    if (header_.vertex.count == 0) {
      return lines_.input().fail(ErrorCode::kNoPoints, "the header declares 0 vertices: there is nothing to print");
    }
    header_.before_vertex = elements_.first(before_);
    header_.before_face = elements_.subspan(before_, between_);
    if (!header_.face.layout.has_wanted_list()) header_.face = {};
    return header_;
  }

  LineInput& lines_;
  std::span<RecordStep> steps_;
  std::span<PlyElement> elements_;
  PlyHeader header_;
  Place place_ = Place::kStart;
  bool has_format_ = false;
  bool is_compressed_ = false;  ///< by SuperSplat's scheme
  std::size_t before_ = 0;      ///< elements before the vertices
  std::size_t between_ = 0;     ///< elements between the vertices and the faces
  std::uint64_t count_ = 0;
  RecordLayout layout_;
};

}  // namespace

Expected<PlyHeader> read_ply_header(LineInput& lines, Arena& memory) {
  const auto steps = memory.take_bottom<RecordStep>(kMaxSteps, "reading PLY");
  PLUMBLINE_TRY(steps);
  const auto elements = memory.take_bottom<PlyElement>(kMaxElements, "reading PLY");
  PLUMBLINE_TRY(elements);
  return HeaderParser(lines, *steps, *elements).parse();
}

}  // namespace plumbline::inline slicer
