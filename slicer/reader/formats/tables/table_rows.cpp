#include "slicer/reader/formats/tables/table_rows.hpp"

#include <algorithm>
#include <limits>

#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::size_t kNone = TableHeading::kNoColumn;

bool is_number(std::string_view cell) {
  double value = 0;
  const char* const end = cell.data() + cell.size();
  return !cell.empty() && (parse_real(cell.data(), end, value) == end || is_missing(cell) ||
                           parse_decimal_comma(cell.data(), end, value) == end);
}

}  // namespace

bool is_missing(std::string_view cell) {
  constexpr std::string_view kMissing[] = {"NA", "N/A", "#N/A", "null", "none", "missing"};
  return std::any_of(std::begin(kMissing), std::end(kMissing), [cell](auto word) { return same_word(cell, word); });
}

bool TableRows::adopt(const TableHeading& heading, std::string_view first_row) {
  heading_ = heading;
  needed_ = 0;
  for (const std::size_t column : heading.columns) {
    if (column != kNone) needed_ = std::max(needed_, column + 1);
  }
  for (const char between : kCellSeparators) {
    // The last cells may be missing, but not where any number of blanks separates. More than the names may follow if they are text: where
    // numbers do, the first column may be the one without a name, as R writes it.
    const std::size_t count = count_cells(first_row, between);
    if (count < (between == ' ' ? heading.names : needed_)) continue;
    if (between != ' ' && first_row.find(between) == std::string_view::npos) continue;
    if (count > heading.names && needed_ < heading.names) continue;
    between_ = between;
    has_point_ = has_comma_ = false;
    cells_ = 0;
    SlotValues values;
    if (parse(first_row, values).kind != RowOutcome::Kind::kWhole) continue;
    RowCells cells(first_row, between);
    std::string_view cell;
    bool fits = true;
    for (std::size_t column = 0; cells.next(cell); ++column) {
      if (column < needed_ && !is_number(cell)) cells_ = count;
      fits = fits && (column < heading.names || !is_number(cell));
    }
    if (fits) return true;
  }
  between_ = 0;
  return false;
}

RowOutcome TableRows::parse(std::string_view row, SlotValues& values) {
  RowCells cells(row, between_);
  std::string_view cell;
  std::size_t column = 0;
  for (; column < needed_ && cells.next(cell); ++column) {
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      if (heading_.columns[slot] != column) continue;
      if (cell.empty()) return {.kind = RowOutcome::Kind::kTooFew, .word = {}, .wanted = slot_name(slot)};
      if (!take_number(cell, values[slot])) {
        return {.kind = RowOutcome::Kind::kNotANumber, .word = cell, .wanted = slot_name(slot)};
      }
      if (slot <= kZ && heading_.has_units()) values[slot] *= heading_.mm[slot];
    }
  }
  if (column < needed_) return {.kind = RowOutcome::Kind::kTooFew, .word = {}, .wanted = "a column"};
  if (cells_ > 0 && count_cells(row, between_) != cells_) return {.kind = RowOutcome::Kind::kOtherCells};
  return {};
}

bool TableRows::take_number(std::string_view cell, double& value) {
  const char* const end = cell.data() + cell.size();
  if (parse_real(cell.data(), end, value) == end) {
    has_point_ = has_point_ || cell.find('.') != std::string_view::npos;
    return !has_comma_ || cell.find('.') == std::string_view::npos;
  }
  if (!has_point_ && parse_decimal_comma(cell.data(), end, value) == end) return has_comma_ = true;
  if (!is_missing(cell)) return false;
  value = std::numeric_limits<double>::quiet_NaN();
  return true;
}

ProposedHeading::ProposedHeading(std::string_view row, std::size_t counters) {
  static constexpr std::string_view kXyz[] = {"x", "y", "z"};
  for (const char between : kCellSeparators) {
    if (between != ' ' && row.find(between) == std::string_view::npos) continue;
    size_ = 0;
    std::size_t numbers = 0;
    RowCells cells(row, between);
    std::string_view cell;
    while (cells.next(cell)) {
      const bool has_number = is_number(cell);
      const std::size_t axis = numbers - counters;
      if (has_number) ++numbers;
      if (has_number && numbers <= counters) {
        add(counters == 1 ? "id" : numbers == 1 ? "row" : "col");
      } else {
        add(numbers > counters + 3 || (!has_number && numbers == counters + 3) ? "-"
            : has_number                                                       ? kXyz[axis]
                                                                               : "name");
      }
    }
    has_xyz_ = numbers >= counters + 3;
    if (has_xyz_) return;
  }
  size_ = 0;
  for (const std::string_view name : kXyz) add(name);
}

void ProposedHeading::add(std::string_view name) {
  if (size_ + name.size() + 2 > text_.size()) return;
  if (size_ > 0) text_[size_++] = ',';
  name.copy(&text_[size_], name.size());
  size_ += name.size();
  text_[size_] = '\0';
}

}  // namespace plumbline::inline slicer
