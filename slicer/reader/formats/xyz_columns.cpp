#include "slicer/reader/formats/xyz_columns.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/reader/stream/words.hpp"

namespace plumbline {
namespace {

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
  names = 0;
  for (auto name = words.next(); !name.empty(); name = words.next(), ++names) {
    while (kBlanks(name.front()) && name.size() > 1) name.remove_prefix(1);
    while (kBlanks(name.back()) && name.size() > 1) name.remove_suffix(1);
    while (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    const std::size_t slot = slot_of(name);
    if (slot < kSlots && names < kMaxColumns && columns.of[slot] == kMaxColumns) columns.of[slot] = names;
  }
  const auto missing = [&](std::size_t slot) { return columns.of[slot] == kMaxColumns; };
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
