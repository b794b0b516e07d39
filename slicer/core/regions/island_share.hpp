#pragma once
/// UVtools' island rule, as far as it asks how much of a region lies above the layer below.

#include <cstdint>

namespace plumbline::inline slicer {

/// A region is an island if fewer of its pixels than a quarter are above white ones. With ten of them and a quarter of that share or more,
/// only if it also has an overhang.
struct IslandShare {
  std::uint32_t held_divisor = 4;  ///< 1 / RequiredPixelsToSupportMultiplier
  std::uint32_t held_pixels = 10;  ///< of the enhanced detection

  enum class Verdict : std::uint8_t { kHeld, kIslandIfOverhang, kIsland };
  /// @param held  of the region's `area` pixels, those above white ones
  Verdict judge(std::uint32_t area, std::uint32_t held) const {
    const std::uint64_t share = std::uint64_t{held} * held_divisor;
    if (held > 0 && share >= area) return Verdict::kHeld;
    return held < held_pixels || share * held_divisor < area ? Verdict::kIsland : Verdict::kIslandIfOverhang;
  }
};

}  // namespace plumbline::inline slicer
