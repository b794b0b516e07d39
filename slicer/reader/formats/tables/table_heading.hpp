#pragma once
/// What the heading of a table says: which columns are coordinates, and in which unit.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {

/// Splits a line into cells. Blanks around a cell and quotes are not part of it; within quotes nothing separates.
class RowCells {
 public:
  /// @param between  what separates cells; a blank: any number of blanks
  RowCells(std::string_view line, char between) : rest_(line), between_(between) {}

  /// @returns false behind the last cell
  bool next(std::string_view& cell);

 private:
  std::string_view rest_;
  char between_;
  bool ended_ = false;
};

/// What separates the cells of tables. In this order: decimal commas stand in tables with semicolons, blanks in names with commas.
inline constexpr std::string_view kCellSeparators = ";\t|, ";

/// Cells up to the last one that is not empty.
std::size_t count_cells(std::string_view line, char between);

/// The columns of a table by their names: x, y, z; easting, northing, elevation in any order and some languages; `Points:0`,
/// `CoordX`, `pos_x`. Names that mean something else, such as a depth or a latitude, are refused and not guessed.
struct TableHeading {
  static constexpr std::size_t kNoColumn = SIZE_MAX;

  std::array<std::size_t, kSlots> columns;  ///< by Slot; kNoColumn: none
  std::array<double, 3> mm{};               ///< of a unit of x, y and z; 0: it is not said
  std::size_t names = 0;                    ///< cells of the heading
  const char* problem = nullptr;            ///< why the names are not understood; null: they are

  bool is_understood() const { return problem == nullptr; }
  bool has_normals() const { return columns[kNz] != kNoColumn; }
  bool has_units() const { return mm[0] > 0; }
  /// Of the coordinates, without other columns between them.
  bool is_adjacent() const;
  bool begins_with_xyz() const { return columns[kX] == 0 && columns[kY] == 1 && columns[kZ] == 2; }
};

/// Parses a line such as "//X Y Z Nx Ny Nz", "id,x,y,z" or "Rechtswert [m];Hochwert [m];Höhe [m]".
TableHeading parse_heading(std::string_view line);

/// Parses a line of units below the heading, such as ";mm;mm;mm", if it is one.
void take_unit_line(std::string_view line, TableHeading& heading);

}  // namespace plumbline::inline slicer
