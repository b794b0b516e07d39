#include "slicer/reader/formats/pcd/pcd_header.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "slicer/core/words/plural.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

/// Far above what any scanner writes; more only come from an attack or a damaged file.
constexpr std::size_t kMaxFields = 1024;

std::optional<ScalarType> type_of(char kind, std::uint32_t size) {
  const bool is_signed = kind == 'I';
  if (kind == 'F') {
    if (size == 4) return ScalarType::kFloat;
    if (size == 8) return ScalarType::kDouble;
    return std::nullopt;
  }
  switch (size) {
    case 1: return is_signed ? ScalarType::kInt8 : ScalarType::kUint8;
    case 2: return is_signed ? ScalarType::kInt16 : ScalarType::kUint16;
    case 4: return is_signed ? ScalarType::kInt32 : ScalarType::kUint32;
    case 8: return is_signed ? ScalarType::kInt64 : ScalarType::kUint64;
    default: return std::nullopt;
  }
}

class HeaderParser {
 public:
  HeaderParser(LineInput& lines, std::span<PcdField> fields, std::span<RecordStep> steps)
      : lines_(lines), room_(fields), layout_(steps) {}

  Expected<PcdHeader> parse() {
    Line line;
    for (;;) {
      const auto found = lines_.next(line);
      PLUMBLINE_TRY(found);
      if (!*found) {
        return lines_.input().fail(ErrorCode::kTruncated,
                                   "the file ends after line %llu, before 'DATA';\tcopy or export it again", number());
      }
      LineWords words(line.text);
      const auto keyword = words.next();
      if (keyword.starts_with('#')) continue;
      if (line.cut) {
        return lines_.input().fail(ErrorCode::kUnsupported, "line %llu: a line of the header is longer than %zu bytes",
                                   number(), lines_.input().capacity());
      }
      if (keyword.empty()) continue;
      if (keyword == "DATA") {
        PLUMBLINE_TRY(parse_data(words.next()));
        return finish();
      }
      PLUMBLINE_TRY(parse_line(keyword, words));
    }
  }

 private:
  unsigned long long number() const { return static_cast<unsigned long long>(lines_.number()); }

  tl::unexpected<Error> expected(const char* what, std::string_view found) const {
    return lines_.input().fail(ErrorCode::kMalformed, "line %llu: expected %s, found '%s';\texport the file again",
                               number(), what, Quote(found).c_str());
  }

  Status parse_line(std::string_view keyword, LineWords& words) {
    if (keyword == "VERSION") return parse_version(words.next());
    if (keyword == "FIELDS" || keyword == "COLUMNS") return parse_fields(words);
    if (keyword == "SIZE" || keyword == "TYPE" || keyword == "COUNT") return parse_per_field(keyword, words);
    if (keyword == "WIDTH") return parse_number(words.next(), width_);
    if (keyword == "HEIGHT") return parse_number(words.next(), height_);
    if (keyword == "POINTS") return parse_number(words.next(), points_);
    if (keyword == "VIEWPOINT") {
      parse_viewpoint(words);
      return {};
    }
    return expected("a line of a PCD header", keyword);
  }

  Status parse_version(std::string_view word) {
    for (const std::string_view known : {".5", "0.5", ".6", "0.6", ".7", "0.7"}) {
      if (word == known) return {};
    }
    return lines_.input().fail(ErrorCode::kUnsupported,
                               "line %llu: PCD version '%s' is not supported;\tsave the file as 0.5 to 0.7", number(),
                               Quote(word).c_str());
  }

  Status parse_fields(LineWords& words) {
    if (used_ > 0) return expected("one line of field names", "another one");
    for (auto name = words.next(); !name.empty(); name = words.next()) {
      if (used_ == room_.size()) {
        return lines_.input().fail(ErrorCode::kUnsupported,
                                   "line %llu: more than %zu fields;\tsave the file with only x, y and z", number(),
                                   room_.size());
      }
      room_[used_++] = {.slot = static_cast<std::uint8_t>(slot_of(name))};
    }
    if (used_ == 0) return expected("the names of the fields", "none");
    return {};
  }

  Status parse_per_field(std::string_view keyword, LineWords& words) {
    if (used_ == 0) return expected("FIELDS before SIZE, TYPE and COUNT", keyword);
    for (PcdField& field : room_.first(used_)) {
      const auto word = words.next();
      if (word.empty()) return expected("as many values as there are fields", "fewer");
      if (keyword == "TYPE") {
        if (word != "I" && word != "U" && word != "F") return expected("a type I, U or F", word);
        field.kind = word.front();
        continue;
      }
      // 32 bits each, so that size times count can't overflow.
      const auto value = parse_count(word);
      if (!value || *value > std::numeric_limits<std::uint32_t>::max()) return expected("a number below 2^32", word);
      if (keyword == "SIZE") {
        if (*value == 0) return expected("a size of at least 1 byte", word);
        field.size = static_cast<std::uint32_t>(*value);
      } else {
        field.count = *value;
      }
    }
    if (const auto more = words.next(); !more.empty()) return expected("as many values as there are fields", more);
    return {};
  }

  Status parse_number(std::string_view word, std::optional<std::uint64_t>& number) {
    number = parse_count(word);
    if (!number) return expected("a number from 0 to 2^64 - 1", word);
    return {};
  }

  /// The scanner's place and its turn as a quaternion, in the frame of the points. It is no reason to refuse a file.
  void parse_viewpoint(LineWords& words) {
    std::array<double, 7> numbers = {};
    for (double& number : numbers) {
      const auto word = words.next();
      const char* const end = word.data() + word.size();
      if (word.empty() || parse_real(word.data(), end, number) != end || !std::isfinite(number)) return;
    }
    constexpr std::array<double, 7> kDefault = {0, 0, 0, 1, 0, 0, 0};
    if (numbers != kDefault) header_.scanner = {numbers[0], numbers[1], numbers[2]};
  }

  Status parse_data(std::string_view word) {
    if (word == "ascii") {
      header_.data = PcdData::kAscii;
    } else if (word == "binary") {
      header_.data = PcdData::kBinary;
    } else if (word == "binary_compressed") {
      header_.data = PcdData::kBinaryCompressed;
    } else {
      return expected("ascii, binary or binary_compressed", word);
    }
    return {};
  }

  Expected<PcdHeader> finish() {
    if (used_ == 0) return expected("a line 'FIELDS' before the data", "none");
    PLUMBLINE_TRY(count_points());
    std::array<bool, kSlots> present{};
    for (const PcdField& field : room_.first(used_)) {
      if (field.slot < kSlots) present[field.slot] = true;
    }
    const bool whole_normal = present[kNx] && present[kNy] && present[kNz];
    for (PcdField& field : room_.first(used_)) {
      if (field.slot >= kNx && !whole_normal) field.slot = kSlots;
      if (field.slot < kSlots) {
        const auto type = type_of(field.kind, field.size);
        if (!type) return expected("a number's SIZE and TYPE for a coordinate", "another combination");
        if (field.count != 1) return expected("COUNT 1 for a coordinate", "another one");
        field.type = *type;
        if (layout_.has(field.slot)) field.slot = kSlots;  // if two fields have the same name, the first counts
      }
      const bool fits = field.slot < kSlots ? layout_.add_field(field.type, field.slot)
                                            : layout_.add_skip(field.bytes(), field.count);
      if (!fits) return expected("fewer fields", "too many");
    }
    if (!layout_.has_position()) {
      return lines_.input().fail(ErrorCode::kNoPoints,
                                 "line %llu: the FIELDS have no '%s';\tsave the file with x, y and z", number(),
                                 !layout_.has(kX)   ? "x"
                                 : !layout_.has(kY) ? "y"
                                                    : "z");
    }
    // Most programs write the default because they don't know the place. But points in rows and columns come from a sensor, at the origin.
    const bool organized = width_.value_or(0) > 1 && height_.value_or(0) > 1;
    if (organized && !header_.scanner) header_.scanner = Vec3d::Zero();
    header_.fields = room_.first(used_);
    header_.layout = layout_;
    return header_;
  }

  /// WIDTH times HEIGHT must equal POINTS. Versions before 0.7 may leave out either.
  Status count_points() {
    if (!width_ && !points_) return expected("a line 'WIDTH' or 'POINTS' before the data", "neither");
    const auto area = width_ ? saturating_multiply(*width_, height_.value_or(1)) : *points_;
    header_.points = points_.value_or(area);
    if (header_.points != area) {
      return lines_.input().fail(
          ErrorCode::kMalformed,
          "the header declares %llu point%s, but WIDTH times HEIGHT is %llu; export the file again",
          static_cast<unsigned long long>(header_.points), plural_s(header_.points),
          static_cast<unsigned long long>(area));
    }
    if (header_.points == 0) {
      return lines_.input().fail(ErrorCode::kNoPoints, "the header declares 0 points: there is nothing to print");
    }
    return {};
  }

  LineInput& lines_;
  std::span<PcdField> room_;
  std::size_t used_ = 0;
  RecordLayout layout_;
  PcdHeader header_;
  std::optional<std::uint64_t> width_;
  std::optional<std::uint64_t> height_;
  std::optional<std::uint64_t> points_;
};

}  // namespace

Expected<PcdHeader> read_pcd_header(LineInput& lines, Arena& memory) {
  const auto fields = memory.take_bottom<PcdField>(kMaxFields, "reading PCD");
  PLUMBLINE_TRY(fields);
  // At most six wanted fields, with a skip before, between and after them.
  const auto steps = memory.take_bottom<RecordStep>(2 * kSlots + 1, "reading PCD");
  PLUMBLINE_TRY(steps);
  return HeaderParser(lines, *fields, *steps).parse();
}

}  // namespace plumbline::inline slicer
