#include "slicer/plan/mesh_plan.hpp"

#include <algorithm>
#include <limits>

#include "slicer/core/numbers/mib.hpp"
#include "slicer/dose/bleed.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/mesh/hit_resolver.hpp"
#include "slicer/reader/scan_reader.hpp"
#include "slicer/reader/triangles/vertex_list.hpp"
#include "slicer/supports/support_finder.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr double kHitsError = 0.05;  ///< of the estimate, at most: a refusal and a plan leave that much on either side
/// More than any arena holds, and so few that no sum of bytes overflows.
constexpr double kMostHits = static_cast<double>(std::numeric_limits<std::size_t>::max()) / 64;

}  // namespace

MeshNeed need_of(const MeshCounts& mesh, const Placement& placement) {
  const PrintGrid& grid = placement.grid;
  const double pixel_mm2 = static_cast<double>(grid.pitch_x_mm) * static_cast<double>(grid.pitch_y_mm);
  return {.most_vertices = mesh.most_vertices,
          .grid = grid,
          .hits = mesh.seen_area * placement.scale * placement.scale / pixel_mm2};
}

MemoryPlan plan_mesh(const MeshNeed& need, std::uint32_t threads) {
  const PrintGrid& grid = need.grid;
  MemoryPlan plan;
  const RayYield yield{need.hits / 2, need.hits};
  const std::size_t hits = Arena::rounded(static_cast<std::size_t>(std::min(need.hits, kMostHits)) * sizeof(PackedHit));
  const std::size_t reading = kReaderWorkspace + VertexList::bytes_needed(need.most_vertices) + need.copied_bytes;
  const std::uint32_t rays = rays_for(need.grey);
  const std::size_t store = store_bytes(grid, yield);
  const std::size_t rrep = rrep_bytes(grid, yield);
  const std::size_t sorted = rays * rrep;
  const std::uint32_t struts = most_struts(grid);
  const auto set = [&](Stage stage, std::size_t bytes) { plan.bytes[static_cast<std::size_t>(stage)] = bytes; };
  set(Stage::kRead, reading);
  // The mesh is read again for each ray of the pixels, beside the crossings of those before.
  set(Stage::kRayGrid, reading + need.shift_bytes + hits + (rays - 1) * store);
  set(Stage::kRays, need.shift_bytes + hits + resolve_bytes(threads, nullptr) + rays * store);
  // The search for empty layers streams the masks.
  set(Stage::kRRep,
      std::max(store + (rays - 1) * std::max(store, rrep) + std::max(store, rrep) + CrossingStore::row_room_bytes(grid),
               sorted + LayerStream::bytes_needed(grid)));
  set(Stage::kSupports,
      sorted + std::max(find_supports_bytes(grid), bleed_bytes(grid, static_cast<std::size_t>(yield.crossings))));
  set(Stage::kLayers, sorted + struts * sizeof(Strut) + layers_stage_bytes(grid, struts, need.grey));
  return plan;
}

Status admit_mesh(const MeshNeed& need, std::uint32_t threads, const Arena& arena,
                  std::array<std::size_t, kStageCount>& planned_bytes) {
  const auto scaled = [&](double share) {
    MeshNeed part = need;
    part.hits *= share;
    return part;
  };
  planned_bytes = plan_mesh(scaled(1 + kHitsError), threads).bytes;
  const MemoryPlan sure = plan_mesh(scaled(1 - kHitsError), threads);
  if (sure.peak() <= arena.available() + need.copied_bytes) return {};
  const auto stage = to_string(sure.widest());
  return telling(
      Told(ToldCode::kMemoryNeeded,
           {{Fact::kNeededMib, mib(sure.peak())}, {Fact::kAvailableMib, mib(arena.capacity())}}),
      fail(ErrorCode::kOutOfMemory,
           "the mesh does not fit into the arena of %.1f MiB: stage '%.*s' needs about %.1f MiB for %.0f crossings.\t"
           "Use a larger arena, a coarser grid or a smaller scale%s",
           mib(arena.capacity()), static_cast<int>(stage.size()), stage.data(), mib(sure.peak()), need.hits,
           need.shift_bytes > 0 ? ", or leave out the absolute correction" : ""));
}

}  // namespace plumbline::inline slicer
