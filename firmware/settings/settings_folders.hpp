#pragma once
/// Finds board files and profiles by name.

#include <string>
#include <vector>

#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline settings {

/// Folders that may hold board files, in the order in which they are searched: `board` in the working directory,
/// `../share/plumbline/board` of the installed program, and `board` of the source tree that the program was built in.
std::vector<std::string> board_folders();

/// The path of a board file.
/// @param name_or_path  a path if it has a slash or ends in .toml, else the name of a file in board_folders()
/// @retval ErrorCode::kCannotOpen  no such file: the message lists the folders searched and the printers found
[[nodiscard]] Expected<std::string> find_board_file(const std::string& name_or_path);

/// The path of a profile.
/// @param name_or_path  as above; a name is looked for in `profiles` beside the board file, then in `profiles` of board_folders()
/// @param board_path    of the printer's board file
/// @retval ErrorCode::kCannotOpen  no such file: the message lists the folders searched and the profiles found
[[nodiscard]] Expected<std::string> find_profile(const std::string& name_or_path, const std::string& board_path);

/// Names of the profiles beside a board file, sorted.
std::vector<std::string> profile_names(const std::string& board_path);

/// Checks that a file is named after what it describes: "mono2k.toml" has the name "mono2k". A path that does not end in
/// .toml, such as a pipe's, passes.
/// @param key  the key that holds the name, for the message: "[printer] name"
/// @retval ErrorCode::kBadSetting  names both
[[nodiscard]] Status check_file_name(const std::string& path, const char* key, const std::string& name);

}  // namespace plumbline::firmware::inline settings
