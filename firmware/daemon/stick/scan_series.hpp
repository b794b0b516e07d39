#pragma once
/// Scans that are parts of one, as their names say: bun000.ply and bun045.ply, front.ply and back.ply.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::firmware {

/// What the names of a series have in common: the name with `#` for its last number and `@` for each side ("front", "back", "left", ... also
/// in German) that is a word of its own. "Bust_front_01.ply" becomes "bust_@_#.ply".
/// @returns nothing: the name has neither, or it is a mesh's or an archive's
std::string series_of(std::string_view name);

/// The series among the files of one folder: indices of two files or more, in the order of `names`.
/// @param names  file names without folders, sorted
std::vector<std::vector<std::size_t>> find_series(std::span<const std::string> names);

}  // namespace plumbline::firmware
