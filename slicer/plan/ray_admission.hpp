#pragma once
/// Whether what the rays of a placed object make will fit into the arena, said before they are shot.

#include <array>
#include <cstddef>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// What is known when an object has been placed.
struct PlacedObject {
  const Cloud& cloud;             ///< mm
  std::uint32_t read_points = 0;  ///< that the cloud's room was made for
  float support_points = 0;
  PrintGrid grid;
  ConstBitImage interested;  ///< the rays that will be shot
  bool confidence = false;   ///< SliceSettings::confidence
  std::uint32_t threads = 1;
};

/// The extent of the object is known, and with it what its crossings take: a job that has no room for them ends here, not
/// when the arena is full of rays. On scans of closed objects the surface tells their number within 6 %.
/// @param planned_bytes  by Stage; those of the rays and of what follows them are set
/// @retval ErrorCode::kOutOfMemory  what the scan has seen does not fit; a job that might fit is let go on
[[nodiscard]] Status admit_rays(const PlacedObject& object, const Arena& arena,
                                std::array<std::size_t, kStageCount>& planned_bytes);

}  // namespace plumbline
