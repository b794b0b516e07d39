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

bool is_comment(std::string_view text) {
  return text.starts_with('#') || text.starts_with("//") || text.starts_with(';');
}

XyzRow parse_numbers(std::string_view text) {
  XyzRow row;
  const char* at = text.data();
  const char* const last = at + text.size();
  while (row.columns < kMaxColumns) {
    at = skip_separators(at, last, kBlanksAndCommas);
    if (at == last) break;
    double value = 0;
    const char* stop = parse_real(at, last, value);
    if (stop == nullptr || (stop != last && !kBlanksAndCommas(*stop))) break;
    row.values[row.columns++] = value;
    at = stop;
  }
  return row;
}

/// Whether a row looks like "1,25 3,5 7,0", which would be six wrong columns with the comma as a separator: commas between
/// two digits, other separators too, and no decimal point in the whole row.
bool has_decimal_commas(std::string_view text) {
  bool inner_comma = false;
  bool other = false;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] == '.') return false;
    const auto is_digit = [&](std::size_t at) { return text[at] >= '0' && text[at] <= '9'; };
    if (text[i] == ',' && i > 0 && is_digit(i - 1) && is_digit(i + 1)) inner_comma = true;
    if (text[i] != ',' && kBlanksAndCommas(text[i]) && i > 0 && is_digit(i - 1)) {
      const std::size_t next = text.find_first_not_of(" \t;", i);
      other = other || (next != std::string_view::npos && text[next] != ',');
    }
  }
  return inner_comma && other;
}

class XyzReader {
 public:
  XyzReader(ByteInput& input, PointBatch& batch, std::span<XyzRow> sample)
      : input_(input), lines_(input), batch_(batch), sample_(sample) {}

  Status read() {
    PLUMBLINE_TRY(read_sample());
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
      std::string_view text = line_.text;
      while (!text.empty() && kBlanks(text.front())) text.remove_prefix(1);
      if (text.empty() && !line_.cut) continue;
      if (is_comment(text)) {
        if (sampled_ == 0) remember_names(text);
        continue;
      }
      const auto is_count = take_count(text);
      PLUMBLINE_TRY(is_count);
      if (*is_count) continue;
      XyzRow row = parse_numbers(text);
      row.line = lines_.number();
      if (row.columns == 0 && sampled_ == 0 && !has_words_) {
        has_words_ = true;
        remember_names(text);
        continue;
      }
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
  Expected<bool> take_count(std::string_view text) {
    if (rows_ > 0 && rows_ != declared_) return false;
    Words words(text, kBlanksAndCommas);
    const auto count = parse_count(words.next());
    if (!count || !words.next().empty()) return false;
    if (declared_ && rows_ == 0) {
      return input_.fail(ErrorCode::kUnsupported,
                         "line %llu: two counts before the first point, as in PTX, which is not supported;\texport the "
                         "scan as PLY or PTS",
                         number());
    }
    declared_ = saturating_add(declared_.value_or(0), *count);
    return true;
  }

  Status check(const XyzRow& row, std::string_view text) {
    if (row.columns == 0 && sampled_ == 0) {
      return input_.fail(
          ErrorCode::kUnknownFormat,
          "line %llu: expected a row of numbers x y z, found '%s';\tgive a scan in PLY, XYZ, PTS, PCD or "
          "OBJ",
          number(), Quote(text).c_str());
    }
    if (row.columns < 3) {
      static constexpr const char* kMissing[] = {"x", "y", "z"};
      RowOutcome outcome{.kind = RowOutcome::Kind::kTooFew, .word = {}, .wanted = kMissing[row.columns]};
      Words words(text, kBlanksAndCommas);
      for (std::size_t i = 0; i < row.columns; ++i) words.next();
      outcome.word = words.next();
      if (!outcome.word.empty()) outcome.kind = RowOutcome::Kind::kNotANumber;
      return fail_row(lines_, line_, outcome);
    }
    if (has_decimal_commas(text)) {
      return input_.fail(ErrorCode::kUnsupported,
                         "line %llu: '%s' has decimal commas;\texport the file with decimal points", number(),
                         Quote(text).c_str());
    }
    return {};
  }

  Status decide_columns() {
    const auto rows = sample_.first(sampled_);
    if (named_ && !rows.empty() && rows.front().columns == std::min(names_, kMaxColumns)) {
      columns_ = *named_;
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
      const RowOutcome outcome = parse_row(line_.text, layout_, kBlanksAndCommas, row);
      if (outcome.kind != RowOutcome::Kind::kWhole) {
        std::string_view text = line_.text;
        while (!text.empty() && kBlanks(text.front())) text.remove_prefix(1);
        if ((text.empty() && !line_.cut) || is_comment(text)) continue;
        const auto is_count = take_count(text);
        PLUMBLINE_TRY(is_count);
        if (*is_count) continue;
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
  std::size_t sampled_ = 0;
  std::optional<XyzColumns> named_;
  std::size_t names_ = 0;  ///< names in the line that named_ comes from
  XyzColumns columns_;
  RecordStep steps_[kMaxColumns];
  RecordLayout layout_{steps_};
  Line line_;
  std::optional<std::uint64_t> declared_;
  std::uint64_t rows_ = 0;
  bool has_words_ = false;
  bool ended_ = false;
};

}  // namespace

Status read_xyz(ByteInput& input, PointBatch& batch, Arena& memory) {
  const auto sample = memory.take_bottom<XyzRow>(kSampleRows, "reading XYZ");
  PLUMBLINE_TRY(sample);
  return XyzReader(input, batch, *sample).read();
}

}  // namespace plumbline
