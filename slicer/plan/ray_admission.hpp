#pragma once
/// Whether the crossings of a placed object fit into the arena, decided before its rays are shot.

#include <array>
#include <cstddef>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

/// What is known once an object has been placed.
struct PlacedObject {
  const Cloud& cloud;             ///< mm
  std::uint32_t read_points = 0;  ///< points of the cloud after reading, for which its room was taken
  PrintGrid grid;
  Grey grey = Grey::kOff;   ///< SliceSettings::grey
  bool confidence = false;  ///< SliceSettings::confidence
  std::uint32_t threads = 1;
  bool is_joined = true;  ///< join_points() has run
};

/// Points for which the rays stage has room, before they are joined, with the crossings that their surface will make.
/// @param object  whose cloud was the last that the arena's top was taken for, and whose map of evidence has been made
std::uint32_t most_ray_points(const PlacedObject& object, const Arena& arena);

/// Refuses a job whose crossings can't fit, before minutes are spent on its rays. The number of crossings is estimated from
/// the area of the surface seen from above: within 6 % on scans of closed objects.
/// @param planned_bytes  by Stage; the ray grid's and those of all stages after it are set
/// @retval ErrorCode::kOutOfMemory  the crossings of what the scan has seen don't fit. A job that might fit goes on
[[nodiscard]] Status admit_rays(const PlacedObject& object, const Arena& arena,
                                std::array<std::size_t, kStageCount>& planned_bytes);

}  // namespace plumbline::inline slicer
