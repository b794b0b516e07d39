#pragma once
/// Files that plumbline does not read, but can name: prints for other printers, CAD models, other meshes and scans.

#include <cstdint>
#include <optional>
#include <string_view>

#include "slicer/core/words/told.hpp"

namespace plumbline::inline slicer {

struct ForeignKind {
  const char* what;    ///< "is sliced for another printer"
  const char* advice;  ///< "export it as .sl1"
  ToldCode code;       ///< told with the file's name
};

struct ForeignFormat {
  std::string_view endings;  ///< of names, in lower case, with blanks between them
  const char* program;       ///< that writes it, or the format's name
  const ForeignKind& kind;
};

/// @returns null: the name has none of the endings
const ForeignFormat* foreign_format(std::string_view name);

/// Names a format by its signature or its first lines.
/// @param head  the file's first bytes, some kB
/// @param size  of the whole file, if it is known
/// @returns null: none of those that have one
const ForeignFormat* foreign_content(std::string_view head, std::optional<std::uint64_t> size);

}  // namespace plumbline::inline slicer
