#pragma once
/// How many bytes each stage needs, said before it starts (DESIGN section 2).

#include <array>
#include <cstdint>
#include <optional>

#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline {

/// Bytes of the arena in use while a stage runs, everything alive counted.
struct MemoryPlan {
  std::uint32_t points = 0;                         ///< that the plan is for
  std::array<std::size_t, kStageCount> bytes = {};  ///< by Stage
  std::size_t peak() const;
  Stage widest() const;  ///< the stage with the peak
};

/// Fewer points than this make no surface worth a print; a job that has room for fewer is refused.
inline constexpr std::uint32_t kFewestPoints = 1000;
/// More are thinned to this many, however large the arena.
inline constexpr std::uint32_t kMostPoints = 16'000'000;

/// Points of one tile of rays that a worker has room for.
std::uint32_t tile_capacity(std::uint32_t points);

/// @param grid  of the printer; without one, the stages that depend on the grid are planned when the extent is known
MemoryPlan plan_memory(std::uint32_t points, const std::optional<PrintGrid>& grid, std::uint32_t threads);

/// The most points whose plan fits into `arena_bytes`.
/// @param declared  points the scan says it has; no more are planned for
/// @returns kFewestPoints to kMostPoints
/// @retval ErrorCode::kOutOfMemory  not even kFewestPoints fit: need and budget
[[nodiscard]] Expected<MemoryPlan> largest_plan(std::size_t arena_bytes, std::optional<std::uint64_t> declared,
                                                const std::optional<PrintGrid>& grid, std::uint32_t threads);

}  // namespace plumbline
