#pragma once
/// Which column of a table of numbers is what.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline {

inline constexpr std::size_t kMaxColumns = 16;  ///< looked at; there may be more

/// The numbers at the start of a row.
struct XyzRow {
  std::array<double, kMaxColumns> values{};
  std::size_t columns = 0;  ///< numbers from the left, kMaxColumns where there are more
  std::uint64_t line = 0;
};

/// Column of each slot; kMaxColumns for one that is not in the file.
struct XyzColumns {
  std::array<std::size_t, kSlots> of{0, 1, 2, kMaxColumns, kMaxColumns, kMaxColumns};
  bool has_normals() const { return of[kNx] < kMaxColumns; }
  std::size_t needed() const;  ///< columns that a row must have
};

/// A header line such as "//X Y Z Nx Ny Nz" or "id,x,y,z".
/// @returns nothing where it does not name x, y and z
std::optional<XyzColumns> columns_by_name(std::string_view line, std::size_t& names);

/// What the first rows look like. Positions are the first three columns.
///
/// Files give normals, colours, intensities and class numbers behind the position without saying which. Normals are
/// what has length 1: the three columns from the 4th (x y z n), the 7th (x y z rgb n) or the 8th (x y z intensity rgb
/// n) are normals where in every row they have a length of 0.95 to 1.05, two decimals being enough for that, or are all
/// zero or NaN for a point without one, and not in all of the rows. Colours of 0 to 255 have other lengths; colours of
/// 0 to 1 pass only where every point is purely red, green, blue or black. Normals of other lengths are not recognised:
/// they are estimated from the points instead, which is safe, while colours taken for normals would not be.
XyzColumns columns_by_values(std::span<const XyzRow> rows);

}  // namespace plumbline
