#include "slicer/reader/formats/xyz_columns.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/reader/stream/words.hpp"

namespace plumbline {
namespace {

/// Rows whose first column counts them; fewer may do so by chance.
constexpr std::size_t kLeastCounted = 8;

enum class Length : std::uint8_t { kOne, kNone, kOther };

Length length_of(const double* v) {
  const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (std::isnan(square) || square == 0) return Length::kNone;
  return square >= 0.95 * 0.95 && square <= 1.05 * 1.05 ? Length::kOne : Length::kOther;
}

bool are_normals(std::span<const XyzRow> rows, std::size_t column) {
  bool any = false;
  for (const XyzRow& row : rows) {
    if (row.columns < column + 3) return false;
    const Length length = length_of(row.values.data() + column);
    if (length == Length::kOther) return false;
    any = any || length == Length::kOne;
  }
  return any;
}

/// A name may have blanks, as in "Point ID,X,Y,Z".
constexpr Separators kCells{",;|\t"};

std::optional<XyzColumns> columns_between(std::string_view line, const Separators& separators, std::size_t& names) {
  XyzColumns columns;
  columns.of.fill(kMaxColumns);
  LineWords words(line, separators);
  names = line.starts_with(',') ? 1 : 0;  // as pandas leaves the first column's name empty
  for (auto name = words.next(); !name.empty(); name = words.next(), ++names) {
    while (kBlanks(name.front()) && name.size() > 1) name.remove_prefix(1);
    while (kBlanks(name.back()) && name.size() > 1) name.remove_suffix(1);
    while (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    name = name.substr(0, name.find_first_of("[("));  // a unit follows, as in "X [mm]"
    while (name.size() > 1 && kBlanks(name.back())) name.remove_suffix(1);
    const std::size_t slot = slot_of(name);
    if (slot == kSlots || columns.of[slot] < kMaxColumns) continue;
    if (names < kMaxColumns) columns.of[slot] = names;
    columns.too_far = columns.too_far || (names >= kMaxColumns && slot <= kZ);
  }
  const auto missing = [&](std::size_t slot) { return columns.of[slot] == kMaxColumns; };
  if (columns.too_far) return columns;
  if (missing(kX) || missing(kY) || missing(kZ)) return std::nullopt;
  if (missing(kNx) || missing(kNy) || missing(kNz)) std::fill_n(columns.of.begin() + kNx, 3, kMaxColumns);
  return columns;
}

}  // namespace

std::size_t XyzColumns::needed() const {
  std::size_t most = 0;
  for (const std::size_t column : of) {
    if (column < kMaxColumns) most = std::max(most, column + 1);
  }
  return most;
}

std::optional<XyzColumns> columns_by_name(std::string_view line, std::size_t& names) {
  while (!line.empty() && (line.front() == '#' || line.front() == '/' || line.front() == ';')) line.remove_prefix(1);
  if (const auto columns = columns_between(line, kCells, names)) return columns;
  return columns_between(line, kBlanksAndCommas, names);
}

bool counts_points(std::span<const XyzRow> rows) {
  if (rows.size() < kLeastCounted || rows.front().columns < 4) return false;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].columns < 4 || rows[i].values[0] != rows[i - 1].values[0] + 1) return false;
  }
  return std::any_of(rows.begin(), rows.end(),
                     [&](const XyzRow& row) { return row.values[1] != rows.front().values[1]; });
}

XyzColumns columns_by_values(std::span<const XyzRow> rows) {
  XyzColumns columns;
  for (const std::size_t first : {3U, 6U, 7U}) {
    if (!are_normals(rows, first)) continue;
    columns.of[kNx] = first;
    columns.of[kNy] = first + 1;
    columns.of[kNz] = first + 2;
    break;
  }
  return columns;
}

}  // namespace plumbline
