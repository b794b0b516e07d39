#pragma once
/// How many points of a scan are kept to prove its R-Rep against.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Points that are asked. Their shares are then right to .5 %.
inline constexpr std::uint32_t kMostProofPoints = 10'000;

/// How many points of a scan are asked: of few points, one in four.
constexpr std::uint32_t proof_points(std::uint32_t cloud_points) {
  return std::min(kMostProofPoints, cloud_points / 4);
}

/// Bytes of arena for the sample of a cloud.
constexpr std::size_t proof_bytes(std::uint32_t cloud_points) {
  return Arena::rounded(proof_points(cloud_points) * sizeof(Vec3f));
}

}  // namespace plumbline::inline slicer
