#pragma once
/// The part that a simulated printer has made: a stack of layers, and its picture.

#include <cstdint>
#include <string>

#include "firmware/machine/back_end.hpp"
#include "firmware/print/print_session.hpp"
#include "slicer/core/arena.hpp"

namespace plumbline {

/// Writes what was cured as `plumbline slice` writes what is to be printed: layers, preview.png, manifest.json where the scan
/// was sliced by this session; and comparison.png, what was to be printed beside it. For the desktop: takes memory from the heap.
/// @param folder   as JobDirectory takes it
/// @param arena    its free part is used for the picture
/// @retval the errors of JobDirectory and PngEncoder
[[nodiscard]] Status write_printed_part(const std::string& folder, const Witness& witness, const PrintSession& session,
                                        Arena& arena);

}  // namespace plumbline
