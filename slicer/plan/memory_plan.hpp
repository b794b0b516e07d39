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

/// How much the ray stage leaves behind.
struct RayYield {
  double rays = 0;       ///< that hit the object
  double crossings = 0;  ///< of all of them
};

/// Bytes of crossings as they come: a count a ray, two bytes a crossing, a directory of tiles.
std::size_t store_bytes(const PrintGrid& grid, const RayYield& yield);
/// Bytes of the R-Rep: four a crossing and as many a layer.
std::size_t rrep_bytes(const PrintGrid& grid, const RayYield& yield);

/// Fewer points than this make no surface worth a print; a job that has room for fewer is refused.
inline constexpr std::uint32_t kFewestPoints = 1000;
/// More are thinned to this many, however large the arena.
inline constexpr std::uint32_t kMostPoints = 16'000'000;

/// Points of one tile of rays that a worker has room for.
std::uint32_t tile_capacity(std::uint32_t points);

/// What is known beside the points and the grid.
struct PlanEvidence {
  std::uint64_t reader_bytes = 0;  ///< ScanHeader::reader_bytes, the largest of the scan's files
  std::uint64_t kept_bytes = 0;    ///< heads of files that wait for their turn
  bool confidence = false;         ///< SliceSettings::confidence
  /// What the rays will make. Without them, those of an object that covers half of the grid: before a scan is read nothing
  /// tells how large its object is, and a board's memory has to do for what its panel can show. A smaller object leaves
  /// room unused; a larger one is refused when it has been placed, before its rays are shot, by its own figures.
  std::optional<RayYield> yield = std::nullopt;
};

/// @param grid  of the printer; without one, the stages that depend on the grid are planned when the extent is known
MemoryPlan plan_memory(std::uint32_t points, const std::optional<PrintGrid>& grid, std::uint32_t threads,
                       const PlanEvidence& evidence = {});

/// The most points whose plan fits into `arena_bytes`.
/// @param declared  points the scan says it has; no more are planned for
/// @returns kFewestPoints to kMostPoints
/// @retval ErrorCode::kOutOfMemory  not even kFewestPoints fit: need and budget
[[nodiscard]] Expected<MemoryPlan> largest_plan(std::size_t arena_bytes, std::optional<std::uint64_t> declared,
                                                const std::optional<PrintGrid>& grid, std::uint32_t threads,
                                                const PlanEvidence& evidence = {});

}  // namespace plumbline
