#include <algorithm>
#include <cassert>

#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/formats/xyz_columns.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/number.hpp"

namespace plumbline {
namespace {

/// Rows from which the columns are identified. More rows make it less likely that colours pass for normals
/// (columns_by_values). They are kept in memory, 9 KiB for 64.
constexpr std::size_t kSampleRows = 64;

/// Bytes of the longest row with decimal commas. Sixteen numbers of 24 digits take a tenth of it.
constexpr std::size_t kLongestDecimalRow = 4096;

/// As some programs do, numbers may stand in quotes.
constexpr Separators kBetween{" \t\v\f,;|\""};
constexpr Separators kBetweenDecimals{" \t\v\f;|\""};
constexpr Separators kNothing{" \t\v\f\""};  ///< what an empty cell may hold

/// How Excel names the separator, in the first line: "sep=;".
bool is_excel_line(std::string_view text) {
  constexpr std::string_view kSep = "sep=";
  return text.size() == kSep.size() + 1 && same_word(text.substr(0, kSep.size()), kSep);
}

/// A row whose first cell is empty: ";2;3". A comment that begins with a semicolon has words, or no second semicolon.
bool lacks_first_cell(std::string_view text) {
  if (text.find(';', 1) == std::string_view::npos) return false;
  std::size_t numbers = 0;
  LineWords words(text, kBetween);
  for (auto word = words.next(); !word.empty(); word = words.next(), ++numbers) {
    double value = 0;
    if (parse_real(word.data(), word.data() + word.size(), value) != word.data() + word.size()) return false;
  }
  return numbers > 1;
}

bool is_comment(std::string_view text) {
  return text.starts_with('#') || text.starts_with("//") || (text.starts_with(';') && !lacks_first_cell(text));
}

std::string_view without_indent(std::string_view text) {
  while (!text.empty() && kBlanks(text.front())) text.remove_prefix(1);
  return text;
}

XyzRow parse_numbers(std::string_view text, const Separators& separators) {
  XyzRow row;
  const char* at = text.data();
  const char* const last = at + text.size();
  while (row.columns < kMaxColumns) {
    at = skip_separators(at, last, separators);
    if (at == last) break;
    double value = 0;
    const char* stop = parse_real(at, last, value);
    if (stop == nullptr || (stop != last && !separators(*stop))) break;
    row.values[row.columns++] = value;
    at = stop;
  }
  return row;
}

/// What the commas of a row are.
enum class Commas : std::uint8_t { kNone, kSeparators, kDecimal, kUnclear };

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Commas are decimal in "1,25 3,5 7": no number has a decimal point, none has two commas, each comma is between digits, and
/// other characters separate at least three numbers. They separate where none is between digits with other separators
/// around, as in "1,2,3" or "1, 2, 3", and where there are decimal points, as in "1.5,2.5,3". A row such as "1,2,3 4,5,6", "1,234.5 6 7" or
/// "1.234,5 6 7" could be either.
Commas commas_of(std::string_view text) {
  if (text.find(',') == std::string_view::npos) return Commas::kNone;
  bool is_decimal = true;
  bool has_inner = false;
  bool has_point = false;
  bool is_number = true;  // x, y and z may be numbers by themselves
  bool has_inner_xyz = false;
  std::size_t numbers = 0;
  LineWords words(text, kBetweenDecimals);
  for (auto word = words.next(); !word.empty(); word = words.next(), ++numbers) {
    has_point = has_point || word.find('.') != std::string_view::npos;
    const std::size_t comma = word.find(',');
    if (comma == std::string_view::npos) continue;
    const bool inner = comma > 0 && comma + 1 < word.size() && is_digit(word[comma - 1]) && is_digit(word[comma + 1]);
    const bool one = inner && word.find(',', comma + 1) == std::string_view::npos;
    has_inner = has_inner || inner;
    is_decimal = is_decimal && one;
    if (numbers >= 3) continue;
    is_number = is_number && one;
    has_inner_xyz = has_inner_xyz || inner;
  }
  if (has_point) return numbers >= 3 && is_number && has_inner_xyz ? Commas::kUnclear : Commas::kSeparators;
  if (numbers >= 3 && is_decimal) return Commas::kDecimal;
  return numbers > 1 && has_inner ? Commas::kUnclear : Commas::kSeparators;
}

class XyzReader {
 public:
  /// @param points  room for a row with its decimal commas made points
  XyzReader(ByteInput& input, PointBatch& batch, std::span<XyzRow> sample, std::span<char> points)
      : input_(input), lines_(input), batch_(batch), sample_(sample), points_(points) {}

  Status read() {
    PLUMBLINE_TRY(read_sample());
    if (sampled_ == 0 && heading_ && !named_) return fail_unknown(heading_line_, *heading_);
    PLUMBLINE_TRY(decide_columns());
    PLUMBLINE_TRY(deliver_sample());
    if (!ended_) PLUMBLINE_TRY(read_rest());
    if (declared_ && rows_ < *declared_) {
      return input_.fail(
          ErrorCode::kTruncated,
          "the file ends after line %llu, with %llu of the %llu points that it declares;\tcopy or export "
          "it again",
          number(), static_cast<unsigned long long>(rows_), static_cast<unsigned long long>(*declared_));
    }
    return {};
  }

 private:
  unsigned long long number() const { return static_cast<unsigned long long>(lines_.number()); }

  /// Reads up to kSampleRows rows, and what may precede them: comments, one line of names, one count.
  Status read_sample() {
    while (sampled_ < sample_.size()) {
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (!*found) {
        ended_ = true;
        return {};
      }
      std::string_view text = without_indent(line_.text);
      if (text.empty() && !line_.cut) continue;
      if (lines_.number() == 1 && is_excel_line(text)) continue;
      if (is_comment(text)) {
        if (sampled_ == 0) remember_names(text);
        continue;
      }
      if (take_count(text)) continue;
      XyzRow row = parse_numbers(text, kBetween);
      if (row.columns == 0 && sampled_ == 0 && !heading_) {
        heading_.emplace(text);
        heading_line_ = lines_.number();
        remember_names(text);
        continue;
      }
      PLUMBLINE_TRY(settle_commas(text));
      if (commas_ == Commas::kSeparators) cell_ = ',';
      if (cell_ == 0 && text.find(';') != std::string_view::npos) cell_ = ';';
      PLUMBLINE_TRY(refuse_empty_cell(text));
      if (commas_ == Commas::kDecimal) row = parse_numbers(text, *separators_);
      row.line = lines_.number();
      PLUMBLINE_TRY(check(row, text));
      sample_[sampled_++] = row;
      ++rows_;
    }
    return {};
  }

  void remember_names(std::string_view text) {
    std::size_t count = 0;
    if (const auto columns = columns_by_name(text, count)) {
      named_ = columns;
      names_ = count;
    }
  }

  /// In PTS, a line of one whole number is the number of points that follow. Merged scans have one before each part.
  bool take_count(std::string_view text) {
    if (rows_ > 0 && rows_ != declared_) return false;
    LineWords words(text, kBetween);
    const auto count = parse_count(words.next());
    if (!count || !words.next().empty()) return false;
    declared_ = saturating_add(declared_.value_or(0), *count);
    return true;
  }

  tl::unexpected<Error> fail_unknown(std::uint64_t line, const Quote& found) const {
    return input_.fail(ErrorCode::kUnknownFormat,
                       "line %llu: expected a row of numbers x y z, found '%s';\tgive a scan in PLY, XYZ, PTS, PTX, "
                       "LAS, PCD or OBJ",
                       static_cast<unsigned long long>(line), found.c_str());
  }

  Status check(const XyzRow& row, std::string_view text) {
    if (row.columns == 0 && sampled_ == 0) {
      return fail_unknown(lines_.number(), Quote(text));
    }
    if (row.columns < 3) {
      static constexpr const char* kMissing[] = {"x", "y", "z"};
      RowOutcome outcome{.kind = RowOutcome::Kind::kTooFew, .word = {}, .wanted = kMissing[row.columns]};
      LineWords words(text, *separators_);
      for (std::size_t i = 0; i < row.columns; ++i) words.next();
      outcome.word = words.next();
      if (!outcome.word.empty()) outcome.kind = RowOutcome::Kind::kNotANumber;
      return fail_row(lines_, line_, outcome);
    }
    return {};
  }

  /// Decides what commas are from the first row that has any, and makes decimal ones points.
  /// @param text  of line_; changed where it has decimal commas
  Status settle_commas(std::string_view& text) {
    if (commas_ == Commas::kNone) {
      commas_ = commas_of(text);
      if (commas_ == Commas::kDecimal) separators_ = &kBetweenDecimals;
    } else if (commas_ == Commas::kSeparators && commas_of(text) >= Commas::kDecimal) {
      commas_ = Commas::kUnclear;
    }
    if (commas_ == Commas::kUnclear) {
      return input_.fail(ErrorCode::kUnsupported,
                         "line %llu: the commas in '%s' may be decimal or separate numbers;\texport the file with "
                         "decimal points and without separators of thousands",
                         number(), Quote(text).c_str());
    }
    if (commas_ != Commas::kDecimal) return {};
    if (text.find('.') != std::string_view::npos || text.size() > points_.size()) {
      return input_.fail(ErrorCode::kMalformed,
                         "line %llu: '%s' %s, but the file has decimal commas;\texport it with decimal points",
                         number(), Quote(text).c_str(), text.size() > points_.size() ? "is long" : "has a point");
    }
    std::replace_copy(text.begin(), text.end(), points_.begin(), ',', '.');
    line_.text = text = {points_.data(), text.size()};
    return {};
  }

  /// The numbers behind an empty cell would count as those of the columns before them.
  Status refuse_empty_cell(std::string_view text) const {
    if (cell_ == 0) return {};
    const std::size_t needed = named_ ? named_->needed() : 3;
    std::string_view rest = text;
    for (std::size_t column = 1; column <= needed; ++column) {
      const std::size_t end = rest.find(cell_);
      if (end == std::string_view::npos) return {};
      const bool is_empty = skip_separators(rest.data(), rest.data() + end, kNothing) == rest.data() + end;
      if (is_empty && !is_comment(without_indent(text))) {
        return input_.fail(ErrorCode::kMalformed,
                           "line %llu: column %zu is empty in '%s';\tleave out such lines, or export the file again",
                           number(), column, Quote(text).c_str());
      }
      rest.remove_prefix(end + 1);
    }
    return {};
  }

  Status decide_columns() {
    const auto rows = sample_.first(sampled_);
    if (named_ && !rows.empty() && rows.front().columns == std::min(names_, kMaxColumns)) {
      columns_ = *named_;
      if (columns_.too_far) {
        return input_.fail(ErrorCode::kUnsupported,
                           "x, y and z are named behind the %zu columns that are read;\texport them as the first ones",
                           kMaxColumns);
      }
    } else if (counts_points(rows)) {
      return input_.fail(
          ErrorCode::kUnsupported,
          "line %llu: the first column seems to number the points;\tname all columns in a line above it, "
          "such as 'id x y z'",
          static_cast<unsigned long long>(rows.front().line));
    } else {
      columns_ = columns_by_values(rows);
    }
    const std::size_t needed = columns_.needed();
    bool fits = true;
    for (std::size_t column = 0; column < needed; ++column) {
      std::size_t slot = 0;
      while (slot < kSlots && columns_.of[slot] != column) ++slot;
      fits = fits && (slot < kSlots ? layout_.add_field(ScalarType::kDouble, slot) : layout_.add_skip(0, 1));
    }
    assert(fits);
    return batch_.begin({.format = ScanFormat::kXyz,
                         .encoding = "ascii",
                         .has_normals = columns_.has_normals(),
                         .declared_points = declared_});
  }

  Status deliver_sample() {
    for (const XyzRow& from : sample_.first(sampled_)) {
      if (from.columns < columns_.needed()) {
        return input_.fail(ErrorCode::kMalformed,
                           "line %llu: too few numbers, %zu instead of %zu;\tcorrect the line or export the file again",
                           static_cast<unsigned long long>(from.line), from.columns, columns_.needed());
      }
      SlotValues row = {};
      for (std::size_t slot = 0; slot < kSlots; ++slot) {
        if (columns_.of[slot] < kMaxColumns) row[slot] = from.values[columns_.of[slot]];
      }
      batch_.add(row);
    }
    return {};
  }

  Status read_rest() {
    SlotValues row = {};
    for (;;) {
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (!*found) return {};
      if (commas_ != Commas::kSeparators && !is_comment(without_indent(line_.text))) {
        PLUMBLINE_TRY(settle_commas(line_.text));
      }
      PLUMBLINE_TRY(refuse_empty_cell(line_.text));
      const RowOutcome outcome = parse_row(line_.text, layout_, *separators_, row);
      if (outcome.kind != RowOutcome::Kind::kWhole) {
        const std::string_view text = without_indent(line_.text);
        if ((text.empty() && !line_.cut) || is_comment(text)) continue;
        if (take_count(text)) continue;
        return fail_row(lines_, line_, outcome);
      }
      ++rows_;
      batch_.add(row);
      if (batch_.full()) PLUMBLINE_TRY(batch_.flush());
    }
  }

  ByteInput& input_;
  LineInput lines_;
  PointBatch& batch_;
  std::span<XyzRow> sample_;
  std::span<char> points_;
  Commas commas_ = Commas::kNone;  ///< of the rows so far
  const Separators* separators_ = &kBetween;
  char cell_ = 0;  ///< a comma or a semicolon that separates numbers; 0: none does
  std::size_t sampled_ = 0;
  std::optional<XyzColumns> named_;
  std::size_t names_ = 0;  ///< names in the line that named_ comes from
  XyzColumns columns_;
  RecordStep steps_[kMaxColumns];
  RecordLayout layout_{steps_};
  Line line_;
  std::optional<std::uint64_t> declared_;
  std::uint64_t rows_ = 0;
  std::optional<Quote> heading_;  ///< a line of words before the first row
  std::uint64_t heading_line_ = 0;
  bool ended_ = false;
};

}  // namespace

Status read_xyz(ByteInput& input, PointBatch& batch, Arena& memory) {
  const auto sample = memory.take_bottom<XyzRow>(kSampleRows, "reading XYZ");
  PLUMBLINE_TRY(sample);
  const auto points = memory.take_bottom<char>(kLongestDecimalRow, "reading XYZ");
  PLUMBLINE_TRY(points);
  return XyzReader(input, batch, *sample, *points).read();
}

}  // namespace plumbline
