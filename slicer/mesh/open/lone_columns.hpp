#pragma once
/// Columns of one pixel, which rays beside the open edges of a mesh leave.

#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline::inline slicer {

/// Bytes of arena that drop_lone_columns() takes.
std::size_t lone_columns_bytes(const PrintGrid& grid);

/// Removes solid intervals of kLeastColumnLayers or more of which none of the eight rays around has half: a single ray is no evidence of
/// solid.
/// @param arena  lone_columns_bytes() from the top, given back
/// @returns how many were removed
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<std::uint32_t> drop_lone_columns(CrossingStore& store, Arena& arena);

inline constexpr std::uint32_t kLeastColumnLayers = 20;  ///< lower ones are details, or too low to be seen

}  // namespace plumbline::inline slicer
