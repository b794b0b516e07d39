#pragma once
/// Stacks of masks made of boxes, and their findings.

#include <cstdint>
#include <vector>

#include "slicer/checks/stack_checker.hpp"
#include "tests/slicer/support/arena_block.hpp"
#include "tests/slicer/support/pixels.hpp"
#include "tests/slicer/support/scan_cloud.hpp"
#include "tests/slicer/support/solid.hpp"

namespace plumbline::testing {

/// Limits that let nothing pass, so that every pixel counts. Nothing tears.
inline CheckLimits strict_limits() {
  CheckLimits limits;
  limits.peel.green_strength_mpa = limits.peel.plate_adhesion_mpa = 1e6;
  limits.drain_pixels = 1;
  limits.trap_pixels = 1;
  limits.suction_pixels = 1;
  limits.suction_height_mm = 0;
  limits.plate_suction_mm2 = 0;
  limits.overhang_reach = 1;
  limits.first_layer_mm2 = 0;
  limits.peel_mm2 = 1e9;
  limits.peel_jump_mm2 = 1e9;
  return limits;
}

inline PrintGrid grid_of(const std::vector<Pixels>& masks, float pitch_mm = 0.1F) {
  PrintGrid grid = cubic_grid(masks[0].columns(), static_cast<std::uint32_t>(masks.size()), pitch_mm);
  grid.rows = masks[0].rows();
  return grid;
}

inline StackFindings check(const std::vector<Pixels>& masks, const CheckLimits& limits, float pitch_mm = 0.1F) {
  const PrintGrid grid = grid_of(masks, pitch_mm);
  ArenaBlock arena(16 * kMiB);
  StackChecker checker = value_of(StackChecker::create(grid, limits, *arena));
  if (limits.overhangs == OverhangRule::kNeedSupport) {  // it has room for the longest bridge
    EXPECT_LE(arena->top_used(), StackChecker::bytes_needed(grid, limits.overhangs));
  } else {
    EXPECT_EQ(arena->top_used(), StackChecker::bytes_needed(grid));
  }
  for (const Pixels& mask : masks) checker.next(mask.image().view());
  return checker.finish();
}

/// The masks of a shape.
inline std::vector<Pixels> stack_of(std::uint32_t side, std::uint32_t layers, const Inside& inside) {
  std::vector<Pixels> masks(layers, Pixels(side, side));
  for (std::uint32_t k = 0; k < layers; ++k) {
    for (std::uint32_t r = 0; r < side; ++r) {
      for (std::uint32_t c = 0; c < side; ++c) masks[k].set(c, r, inside(c, r, k));
    }
  }
  return masks;
}

/// What is in `solid` and not in `hollow`.
inline Inside without(const Inside& solid, const Inside& hollow) {
  return [=](std::uint32_t c, std::uint32_t r, std::uint32_t k) { return solid(c, r, k) && !hollow(c, r, k); };
}

}  // namespace plumbline::testing
