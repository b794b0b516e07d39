#pragma once
/// How many bytes of the arena a mesh needs, known before its rays are shot.

#include "slicer/core/arena.hpp"
#include "slicer/mesh/mesh_counts.hpp"
#include "slicer/placement/placement.hpp"
#include "slicer/plan/memory_plan.hpp"

namespace plumbline::inline slicer {

/// What the first reading of a mesh has found.
struct MeshNeed {
  std::uint64_t most_vertices = 0;  ///< that a reading keeps
  PrintGrid grid;
  Grey grey = Grey::kOff;  ///< SliceSettings::grey
  double hits = 0;  ///< of rays and triangles, estimated from the triangles' areas: within 2 % for a large object
  /// Of the arena, for a copy of the file. They are given back after the second reading.
  std::size_t copied_bytes = 0;
  std::size_t shift_bytes = 0;  ///< OutlineShift::bytes_needed(), until the rays are shot; 0: outlines are not moved
};

/// @param mesh  as surveyed
MeshNeed need_of(const MeshCounts& mesh, const Placement& placement);

MemoryPlan plan_mesh(const MeshNeed& need, std::uint32_t threads);

/// Refuses a mesh that can't fit, before its rays are shot.
/// @param planned_bytes  by Stage; those of all stages after the reading are set
/// @retval ErrorCode::kOutOfMemory  stage, need, budget, and what to do
[[nodiscard]] Status admit_mesh(const MeshNeed& need, std::uint32_t threads, const Arena& arena,
                                std::array<std::size_t, kStageCount>& planned_bytes);

}  // namespace plumbline::inline slicer
