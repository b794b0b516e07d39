#pragma once
/// Identifies the columns of a table of numbers.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {

inline constexpr std::size_t kMaxColumns = 16;  ///< columns that are read; a row may have more

/// The numbers at the start of a row.
struct XyzRow {
  std::array<double, kMaxColumns> values{};
  std::size_t columns = 0;  ///< leading numbers, at most kMaxColumns
  std::uint32_t whole = 0;  ///< a bit for each that has neither a decimal point nor an exponent
  std::uint64_t line = 0;
};

/// The column of each slot of a table without heading; kMaxColumns if the file does not have it.
struct XyzColumns {
  std::array<std::size_t, kSlots> of{0, 1, 2, kMaxColumns, kMaxColumns, kMaxColumns};
  bool has_normals() const { return of[kNx] < kMaxColumns; }
  std::size_t needed() const;  ///< columns that a row must have
};

/// Whether the first of four columns or more seems to be the number of the point: it grows by one from row to row, while the second one
/// varies. In the first line of a range image, where the first column counts too, the second one is the same for all pixels.
bool counts_points(std::span<const XyzRow> rows);

/// How many columns, one or two, seem to be counters before x, y and z, such as the row and column of a range image: they are whole numbers,
/// and the next three are not. 0: none
std::size_t leading_counters(std::span<const XyzRow> rows);

/// Guesses the columns from the first rows. The first three are the position.
///
/// Normals, colours, intensities and class numbers may follow, and the file doesn't say which. Three columns are taken for
/// normals if they start at the 4th (x y z n), the 7th (x y z rgb n) or the 8th (x y z intensity rgb n) and have length
/// 0.95 to 1.05 in every row (two decimals are that exact), except for points without a normal: all zero or NaN, but not
/// in all rows. Colours of 0 to 255 have other lengths. Colours of 0 to 1 pass only if every point is purely red, green,
/// blue or black. Normals of other lengths are not recognised and will be estimated, which is safe; taking colours for
/// normals would not be.
XyzColumns columns_by_values(std::span<const XyzRow> rows);

}  // namespace plumbline::inline slicer
