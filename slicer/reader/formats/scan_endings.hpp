#pragma once
/// Endings of scan file names, in lower case: who reads a scan and who offers it to a user agree on them.

#include <array>
#include <string_view>

namespace plumbline::inline slicer {

/// Columns of numbers without a signature, so the name's ending counts.
inline constexpr std::array<std::string_view, 6> kXyzEndings = {".xyz", ".xyzrgb", ".txt", ".pts", ".asc", ".csv"};

/// Formats with a signature or keywords of their own.
inline constexpr std::array<std::string_view, 10> kMarkedEndings = {".ply", ".pcd", ".obj", ".stl", ".off",
                                                                    ".3mf", ".las", ".ptx", ".e57", ".spz"};

/// Prints that are sliced already. The slicer does not read them. It says what a file with such an ending really is.
inline constexpr std::array<std::string_view, 6> kArchiveEndings = {".sl1", ".sl1s", ".zip",
                                                                    ".cws", ".uvj",  ".nanodlp"};

}  // namespace plumbline::inline slicer
