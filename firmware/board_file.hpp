#pragma once
/// The file that describes a printer: board/*.toml, each key explained in board/README.md.

#include <cstdint>
#include <string>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline {

/// What a printer is, as its board file has it. Every number is inside the range that board/README.md gives.
struct BoardFile {
  std::string name;             ///< [printer]
  std::uint32_t columns = 0;    ///< [panel] pixels along x
  std::uint32_t rows = 0;       ///< [panel] pixels along y
  double pixel_pitch_x_mm = 0;  ///< [panel] mm
  double pixel_pitch_y_mm = 0;  ///< [panel] mm
  double travel_mm = 0;         ///< [z_stage] mm, tallest print
  double layer_height_mm = 0;   ///< [print] mm
  std::uint32_t arena_mib = 0;  ///< [memory] MiB
};

/// Largest board file that is read, bytes. A real one has some hundred; a file of another kind is noticed before it is
/// parsed.
inline constexpr std::size_t kMaxBoardFileBytes = std::size_t{64} * 1024;

/// Reads a board file. Every key is required, none else is known.
/// @param path  as it is to appear in messages
/// @retval ErrorCode::kCannotOpen, kCannotRead
/// @retval ErrorCode::kMalformed   not TOML, or too large: the file and the line
/// @retval ErrorCode::kBadSetting  a key is unknown, missing, of a wrong type or out of range: file and line, the key,
///         what was found, what is allowed; for an unknown key the nearest known one
[[nodiscard]] Expected<BoardFile> read_board_file(const std::string& path);

/// The same from text in memory.
/// @param path  for messages only
[[nodiscard]] Expected<BoardFile> parse_board_file(std::string_view text, std::string_view path);

}  // namespace plumbline
