#pragma once
/// Takes away what correct_bleed() leaves of a sharp edge where nothing holds it.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/rrep/rrep.hpp"

namespace plumbline::inline slicer {

/// How many layers less than below a thick part an entering crossing was raised, in the last bits of its height while it is corrected.
/// @param most  ones in these bits: kMostLess, or kMostLessThin where layers may be thin
constexpr std::uint32_t marked_less(std::uint32_t packed, std::uint32_t layers, std::uint32_t most) {
  return (packed & ~most) | std::min(layers, most);
}
inline constexpr std::uint32_t kMostLess = 7, kMostLessThin = 15;

/// Thin parts are raised less than thick ones, so beside a sharp edge a strip of them may hang on nothing until the layers of the body come.
/// Bottom up, if a piece of new pixels has none beside it that the layer below has too, those that were raised less move up a layer, until
/// they are raised as much as thick parts, meet the body, or end. A piece that would end as a whole stays: it is a sheet of its own.
/// @param most_less  of marked_less()
/// @param rrep       each entering crossing is marked_less(); they may move up and vanish together with their exits. Its memory stays where it is
/// @returns how many pixels of all masks together were taken away
/// @retval ErrorCode::kOutOfMemory  no room for floating_edges_bytes() at the top of the arena; rrep is unchanged
[[nodiscard]] Expected<std::uint64_t> drop_floating_edges(RRep& rrep, std::uint32_t most_less, Arena& arena);

/// The most that drop_floating_edges() takes.
std::size_t floating_edges_bytes(const PrintGrid& grid);

}  // namespace plumbline::inline slicer
