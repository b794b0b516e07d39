#pragma once
/// The rows of a table whose columns have names.

#include <array>
#include <cstddef>
#include <string_view>

#include "slicer/reader/formats/tables/table_heading.hpp"
#include "slicer/reader/records/record_text.hpp"

namespace plumbline::inline slicer {

/// Whether a cell says that there is no value: NA, N/A, null, none. NaN is a number.
bool is_missing(std::string_view cell);

/// Reads the named columns of each row; the others may hold text.
class TableRows {
 public:
  /// Adopts a heading if this row fits it: as many cells, and numbers where the coordinates are.
  /// @returns false if it doesn't
  bool adopt(const TableHeading& heading, std::string_view first_row);
  bool is_adopted() const { return between_ != 0; }

  /// Reads a row, coordinates in the heading's unit or else as they are. Missing values are NaN.
  RowOutcome parse(std::string_view row, SlotValues& values);

  const TableHeading& heading() const { return heading_; }
  char between() const { return between_; }
  /// Columns up to the last one that is read.
  std::size_t needed() const { return needed_; }

 private:
  bool take_number(std::string_view cell, double& value);

  TableHeading heading_;
  char between_ = 0;  ///< what separates cells; 0: no heading was adopted
  std::size_t needed_ = 0;
  std::size_t cells_ = 0;  ///< of every row, where text before the coordinates may hold separators; 0: any number
  bool has_point_ = false;
  bool has_comma_ = false;
};

/// A heading to write above a row: its first numbers are x, y and z.
class ProposedHeading {
 public:
  ProposedHeading() = default;
  /// @param counters  numbers before x that count: of a point, or row and column
  explicit ProposedHeading(std::string_view row, std::size_t counters = 0);
  const char* c_str() const { return text_.data(); }
  bool has_xyz() const { return has_xyz_; }

 private:
  void add(std::string_view name);

  std::array<char, 96> text_{};
  std::size_t size_ = 0;
  bool has_xyz_ = false;
};

}  // namespace plumbline::inline slicer
