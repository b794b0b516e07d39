#include "slicer/reader/formats/tables/xyz_columns.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// Rows whose first column counts them; fewer may do so by chance.
constexpr std::size_t kLeastCounted = 8;

enum class NormalLength : std::uint8_t { kOne, kNone, kOther };

NormalLength length_of(const double* v) {
  const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (std::isnan(square) || square == 0) return NormalLength::kNone;
  return square >= 0.95 * 0.95 && square <= 1.05 * 1.05 ? NormalLength::kOne : NormalLength::kOther;
}

bool are_normals(std::span<const XyzRow> rows, std::size_t column) {
  bool any = false;
  for (const XyzRow& row : rows) {
    if (row.columns < column + 3) return false;
    const NormalLength length = length_of(row.values.data() + column);
    if (length == NormalLength::kOther) return false;
    any = any || length == NormalLength::kOne;
  }
  return any;
}

}  // namespace

std::size_t XyzColumns::needed() const {
  std::size_t most = 0;
  for (const std::size_t column : of) {
    if (column < kMaxColumns) most = std::max(most, column + 1);
  }
  return most;
}

bool counts_points(std::span<const XyzRow> rows) {
  if (rows.size() < kLeastCounted || rows.front().columns < 4) return false;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].columns < 4 || rows[i].values[0] != rows[i - 1].values[0] + 1) return false;
  }
  return std::any_of(rows.begin(), rows.end(),
                     [&](const XyzRow& row) { return row.values[1] != rows.front().values[1]; });
}

std::size_t leading_counters(std::span<const XyzRow> rows) {
  if (rows.size() < kLeastCounted || columns_by_values(rows).has_normals()) return 0;
  const auto has_whole = [](const XyzRow& row, std::size_t column) { return ((row.whole >> column) & 1U) != 0; };
  for (const std::size_t counters : {2U, 1U}) {
    std::array<std::size_t, 3> fractions{};
    const bool all = std::all_of(rows.begin(), rows.end(), [&](const XyzRow& row) {
      for (std::size_t axis = 0; axis < 3; ++axis) fractions[axis] += has_whole(row, counters + axis) ? 0 : 1;
      return row.columns >= counters + 3 && has_whole(row, 0) && has_whole(row, counters - 1);
    });
    if (all && 2 * *std::min_element(fractions.begin(), fractions.end()) > rows.size()) return counters;
  }
  return 0;
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

}  // namespace plumbline::inline slicer
