#include <algorithm>
#include <cassert>
#include <limits>

#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/formats/tables/table_rows.hpp"
#include "slicer/reader/formats/tables/xyz_columns.hpp"
#include "slicer/reader/records/record_text.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

/// Rows from which the columns are identified. More rows make it less likely that colours pass for normals
/// (columns_by_values). They are kept in memory, 9 KiB for 64.
constexpr std::size_t kSampleRows = 64;

/// Lines of words before the first row, at most: the heading, its units, a title.
constexpr std::size_t kMostWordLines = 64;

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

/// @param may_begin  the first one may be missing
XyzRow parse_numbers(std::string_view text, const Separators& separators, bool may_begin = false) {
  XyzRow row;
  const char* at = text.data();
  const char* const last = at + text.size();
  while (row.columns < kMaxColumns) {
    at = skip_separators(at, last, separators);
    if (at == last) break;
    double value = 0;
    const char* stop = parse_real(at, last, value);
    if (stop == nullptr || (stop != last && !separators(*stop))) {
      stop = skip_word(at, last, separators);
      if ((row.columns == 0 && !may_begin) || !is_missing({at, static_cast<std::size_t>(stop - at)})) break;
      value = std::numeric_limits<double>::quiet_NaN();
    }
    const std::string_view number(at, static_cast<std::size_t>(stop - at));
    if (number.find_first_of(".eE") == std::string_view::npos) row.whole |= 1U << row.columns;
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
    const auto has_row = find_first_row();
    PLUMBLINE_TRY(has_row);
    if (table_.is_adopted()) {
      PLUMBLINE_TRY(read_named());
    } else if (*has_row) {
      PLUMBLINE_TRY(read_sample());
      PLUMBLINE_TRY(decide_columns());
      PLUMBLINE_TRY(deliver_sample());
      if (!ended_) PLUMBLINE_TRY(read_rest());
    } else if (unknown_) {
      return fail_unknown(unknown_line_, *unknown_, {});
    }
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

  /// Reads what precedes the first row: comments, a count, lines of words. Adopts the heading among these, if the row fits it.
  /// @returns false if there is no row; else it is line_
  Expected<bool> find_first_row() {
    std::size_t word_lines = 0;
    for (;;) {
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (!*found) return false;
      const std::string_view text = without_indent(line_.text);
      if (text.empty() && !line_.cut) continue;
      if (lines_.number() == 1 && is_excel_line(text)) continue;
      if (heading_ && !heading_is_comment_ && text.starts_with(';') && table_.adopt(*heading_, line_.text)) return true;
      if (is_comment(text)) {
        if (!heading_ || heading_is_comment_) remember_heading(true);
        comment_cells_ = {};
        for (std::size_t i = 0; i < comment_cells_.size(); ++i)
          comment_cells_[i] = count_cells(text, kCellSeparators[i]);
        continue;
      }
      if (take_count(text)) continue;
      if (heading_ && table_.adopt(*heading_, line_.text)) return true;
      const ProposedHeading proposed(line_.text);
      if (parse_numbers(text, kBetween).columns > 0 || (proposed.has_xyz() && (heading_ || unknown_))) {
        PLUMBLINE_TRY(check_heading(text, proposed));
        return true;
      }
      if (proposed.has_xyz() || ++word_lines > kMostWordLines)
        return fail_unknown(lines_.number(), Quote(text), proposed);
      if (heading_ && !heading_is_comment_) {
        take_unit_line(line_.text, *heading_);
      } else {
        remember_heading(false);
      }
    }
  }

  /// The first line of words counts, else the last comment.
  void remember_heading(bool is_comment) {
    const TableHeading heading = parse_heading(line_.text);
    if (heading.is_understood()) {
      heading_ = heading;
      heading_is_comment_ = is_comment;
    } else if (!is_comment) {
      unknown_.emplace(without_indent(line_.text));
      unknown_problem_ = heading.problem;
    }
    if (heading.is_understood() || !is_comment)
      (heading.is_understood() ? heading_line_ : unknown_line_) = lines_.number();
  }

  /// A row that no heading describes can be read only if there is none: its columns may be any. A comment may name x, y and z
  /// by chance.
  Status check_heading(std::string_view text, const ProposedHeading& proposed) const {
    if (heading_) {
      const bool is_prose = heading_is_comment_ && !heading_->is_adjacent();
      const bool has_more = heading_->begins_with_xyz() && !heading_->has_units() &&
                            (heading_is_comment_ || (text.find(',') == std::string_view::npos &&
                                                     count_cells(text, ' ') != heading_->names + 1));
      if (is_prose || has_more) return {};
      return telling(Told(ToldCode::kColumnsUnclear, {}, proposed.c_str()),
                     input_.fail(ErrorCode::kMalformed,
                                 "line %llu: '%s' does not fit the heading in line %llu, which has %zu names;\twrite "
                                 "above it what its columns are, such as %s",
                                 number(), Quote(text).c_str(), static_cast<unsigned long long>(heading_line_),
                                 heading_->names, proposed.c_str()));
    }
    if (!unknown_) return check_comment(text, proposed);
    return telling(Told(ToldCode::kColumnsUnclear, {}, proposed.c_str()),
                   input_.fail(ErrorCode::kUnsupported,
                               "line %llu: the heading '%s' %s;\twrite above it what its columns are, such as %s",
                               static_cast<unsigned long long>(unknown_line_), unknown_->c_str(), unknown_problem_,
                               proposed.c_str()));
  }

  /// A comment with as many cells as the row is a heading, unless blanks separate them: then it may be prose.
  Status check_comment(std::string_view text, const ProposedHeading& proposed) const {
    for (std::size_t i = 0; i < comment_cells_.size(); ++i) {
      if (heading_ || comment_cells_[i] < 3 || comment_cells_[i] != count_cells(text, kCellSeparators[i])) continue;
      return telling(
          Told(ToldCode::kColumnsUnclear, {}, proposed.c_str()),
          input_.fail(ErrorCode::kUnsupported,
                      "line %llu: the comment above it names %zu columns, but does not say which are x, y and "
                      "z;\twrite below it what its columns are, such as %s",
                      number(), comment_cells_[i], proposed.c_str()));
    }
    return {};
  }

  /// Reads up to kSampleRows rows, from that in line_ on.
  Status read_sample() {
    proposed_ = ProposedHeading(line_.text);
    with_id_ = ProposedHeading(line_.text, 1);
    with_grid_ = ProposedHeading(line_.text, 2);
    for (bool first = true; sampled_ < sample_.size(); first = false) {
      if (!first) {
        const auto found = lines_.next(line_);
        PLUMBLINE_TRY(found);
        if (!*found) {
          ended_ = true;
          return {};
        }
      }
      std::string_view text = without_indent(line_.text);
      if ((text.empty() && !line_.cut) || is_comment(text) || take_count(text)) continue;
      XyzRow row = parse_numbers(text, kBetween, sampled_ > 0);
      PLUMBLINE_TRY(settle_commas(text));
      if (commas_ == Commas::kSeparators) cell_ = ',';
      if (cell_ == 0 && text.find(';') != std::string_view::npos) cell_ = ';';
      PLUMBLINE_TRY(refuse_cell(text, 3));
      if (commas_ == Commas::kDecimal) row = parse_numbers(text, *separators_, sampled_ > 0);
      row.line = lines_.number();
      PLUMBLINE_TRY(check(row, text));
      sample_[sampled_++] = row;
      ++rows_;
    }
    return {};
  }

  /// Reads the rows of a table with a heading, from that in line_ on.
  Status read_named() {
    cell_ = table_.between() == ' ' ? '\0' : table_.between();
    PLUMBLINE_TRY(batch_.begin({.format = ScanFormat::kXyz,
                                .encoding = "ascii",
                                .has_normals = table_.heading().has_normals(),
                                .is_in_mm = table_.heading().has_units(),
                                .declared_points = declared_}));
    SlotValues row = {};
    for (;;) {
      const RowOutcome outcome = table_.parse(line_.text, row);
      const std::string_view text = without_indent(line_.text);
      if (is_note(text) || (outcome.kind != RowOutcome::Kind::kWhole && take_count(text))) {
      } else if (outcome.kind != RowOutcome::Kind::kWhole) {
        PLUMBLINE_TRY(refuse_cell(line_.text, table_.needed()));
        return fail_row(lines_, line_, outcome);
      } else {
        ++rows_;
        batch_.add(row);
        if (batch_.full()) PLUMBLINE_TRY(batch_.flush());
      }
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (!*found) return {};
    }
  }

  /// An empty line or a comment. A semicolon may stand behind an empty cell.
  bool is_note(std::string_view text) const {
    if (text.empty()) return !line_.cut;
    return is_comment(text) && !(cell_ == ';' && text.starts_with(';') && table_.is_adopted());
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

  tl::unexpected<Error> fail_unknown(std::uint64_t line, const Quote& found, const ProposedHeading& proposed) const {
    if (proposed.has_xyz()) {
      return telling(Told(ToldCode::kColumnsUnclear, {}, proposed.c_str()),
                     input_.fail(ErrorCode::kUnsupported,
                                 "line %llu: expected a row of numbers x y z, found '%s';\twrite above it what its "
                                 "columns are, such as %s",
                                 static_cast<unsigned long long>(line), found.c_str(), proposed.c_str()));
    }
    return input_.fail(ErrorCode::kUnknownFormat,
                       "line %llu: expected a row of numbers x y z, found '%s';\tgive a scan in PLY, XYZ, PTS, PTX, "
                       "LAS, PCD or OBJ",
                       static_cast<unsigned long long>(line), found.c_str());
  }

  Status check(const XyzRow& row, std::string_view text) {
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

  /// The numbers behind an empty cell would count as those of the columns before them, and a number with a blank as two.
  /// @param needed  columns
  Status refuse_cell(std::string_view text, std::size_t needed) const {
    if (cell_ == 0 || is_note(without_indent(text))) return {};
    std::string_view rest = text;
    for (std::size_t column = 1; column <= needed; ++column) {
      const std::size_t end = rest.find(cell_);
      const std::string_view cell = rest.substr(0, end);
      const char* const last = cell.data() + cell.size();
      const char* const at = skip_separators(cell.data(), last, kNothing);
      if (at == last && end != std::string_view::npos) {
        return input_.fail(ErrorCode::kMalformed,
                           "line %llu: column %zu is empty in '%s';\tleave out such lines, or export the file again",
                           number(), column, Quote(text).c_str());
      }
      const char* const stop = skip_word(at, last, kNothing);
      if (cell_ == ';' && !table_.is_adopted() && skip_separators(stop, last, kNothing) != last) {
        return input_.fail(ErrorCode::kUnsupported,
                           "line %llu: column %zu has blanks in '%s';\texport the file without separators of thousands",
                           number(), column, Quote(text).c_str());
      }
      if (end == std::string_view::npos) return {};
      rest.remove_prefix(end + 1);
    }
    return {};
  }

  Status decide_columns() {
    const auto rows = sample_.first(sampled_);
    const std::size_t counters = std::max<std::size_t>(leading_counters(rows), counts_points(rows) ? 1 : 0);
    if (counters > 0) {
      const ProposedHeading& counted = counters == 1 ? with_id_ : with_grid_;
      return telling(
          Told(ToldCode::kColumnsUnclear, {}, counted.c_str()),
          input_.fail(ErrorCode::kUnsupported,
                      "line %llu: the first %s to number the points;\tname all columns in a line above it, "
                      "such as %s (or %s if they are coordinates)",
                      static_cast<unsigned long long>(rows.front().line),
                      counters == 1 ? "column seems" : "two columns seem", counted.c_str(), proposed_.c_str()));
    }
    columns_ = columns_by_values(rows);
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
      PLUMBLINE_TRY(refuse_cell(line_.text, 3));
      const RowOutcome outcome = parse_row(line_.text, layout_, *separators_, row);
      if (outcome.kind != RowOutcome::Kind::kWhole) {
        const std::string_view text = without_indent(line_.text);
        if ((text.empty() && !line_.cut) || is_comment(text)) continue;
        if (take_count(text)) continue;
        if (!is_missing(outcome.word)) return fail_row(lines_, line_, outcome);
        row[kX] = std::numeric_limits<double>::quiet_NaN();
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
  std::optional<TableHeading> heading_;
  bool heading_is_comment_ = false;
  std::uint64_t heading_line_ = 0;
  TableRows table_;                                 ///< adopts heading_, if the rows fit it
  ProposedHeading proposed_, with_id_, with_grid_;  ///< for the first row, without a heading
  XyzColumns columns_;
  RecordStep steps_[kMaxColumns];
  RecordLayout layout_{steps_};
  Line line_;
  std::optional<std::uint64_t> declared_;
  std::uint64_t rows_ = 0;
  std::optional<Quote> unknown_;  ///< the last line of words before the first row that is no heading
  const char* unknown_problem_ = "";
  std::array<std::size_t, 4>
      comment_cells_{};  ///< of the last comment before the first row, by the separators but the blank
  std::uint64_t unknown_line_ = 0;
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

}  // namespace plumbline::inline slicer
