#include "slicer/plan/ray_admission.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slicer/core/numbers/mib.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/rays/ray_shooter.hpp"
#include "slicer/rrep/crossing_store.hpp"

namespace plumbline::inline slicer {
namespace {

/// Crossings that the surface will make: the area of each point's share of it, seen from above, in pixels.
struct SeenSurface {
  double entering = 0;
  double exiting = 0;

  explicit SeenSurface(const PlacedObject& object) {
    const Cloud& cloud = object.cloud;
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      const double radius = cloud.radius[i];
      const double slope = cloud.normal[i].unpack()[2];
      const int weight = object.is_joined ? cloud.normal[i].weight : 1;
      (slope > 0 ? exiting : entering) += radius * radius * std::abs(slope) * weight;
    }
    const double pixel_mm2 = static_cast<double>(object.grid.pitch_x_mm) * static_cast<double>(object.grid.pitch_y_mm);
    const double rays = std::numbers::pi / (cloud.support_points * pixel_mm2);
    entering *= rays;
    exiting *= rays;
  }
};

// The estimate is within 6 % of the crossings (scans of closed objects): the plan adds as much, a refusal leaves some more.
constexpr double kSureShare = 0.9;
constexpr double kPlannedShare = 1.06;

RayYield yield_of(const PlacedObject& object, double crossings) {
  return {std::min(crossings / 2, static_cast<double>(object.grid.columns) * object.grid.rows), crossings};
}

/// Assumes that the scan missed surface: every ray leaves the object as often as it enters.
MemoryPlan plan_of(const PlacedObject& object, const SeenSurface& seen) {
  const RayYield yield = yield_of(object, kPlannedShare * 2 * std::max(seen.entering, seen.exiting));
  return plan_memory(object.read_points, object.grid, object.threads,
                     {.views = object.cloud.views.count,
                      .confidence = object.confidence,
                      .grey = object.grey,
                      .ray_points = object.cloud.size,
                      .yield = yield});
}

}  // namespace

std::uint32_t most_ray_points(const PlacedObject& object, const Arena& arena) {
  const MemoryPlan plan = plan_of(object, SeenSurface(object));
  const std::size_t others = plan.of(Stage::kRays) - ray_points_bytes(object.cloud.size);
  return ray_points_in(arena.capacity() - std::min(arena.capacity(), others));
}

Status admit_rays(const PlacedObject& object, const Arena& arena, std::array<std::size_t, kStageCount>& planned_bytes) {
  const SeenSurface seen(object);
  const MemoryPlan plan = plan_of(object, seen);
  for (const Stage stage :
       {Stage::kWindingTree, Stage::kRayGrid, Stage::kRays, Stage::kRRep, Stage::kSupports, Stage::kLayers}) {
    planned_bytes[static_cast<std::size_t>(stage)] = plan.of(stage);
  }
  // What the points and the evidence take is known by now.
  const std::size_t kept = kept_bytes(object.read_points, object.grid.layers, object.confidence);
  planned_bytes[static_cast<std::size_t>(Stage::kRays)] += arena.used() - kept - ray_points_bytes(object.cloud.size);
  // A refusal counts only surface that the scan has seen.
  const RayYield sure = yield_of(object, kSureShare * (seen.entering + seen.exiting));
  const std::uint32_t rays = rays_for(object.grey);
  const std::size_t shooting = arena.used() + object.threads * ray_worker_bytes(tile_capacity(object.cloud.size)) +
                               rays * store_bytes(object.grid, sure);
  const std::size_t store = store_bytes(object.grid, sure), sorted = rrep_bytes(object.grid, sure);
  const std::size_t sorting =
      store + (rays - 1) * std::max(store, sorted) + sorted + CrossingStore::row_room_bytes(object.grid) + kept;
  const std::size_t printing = kept + rays * sorted + layers_stage_bytes(object.grid, 0, object.grey);
  const std::size_t need = std::max({shooting, sorting, printing});
  if (need <= arena.capacity()) return {};
  return telling(
      Told(ToldCode::kMemoryNeeded, {{Fact::kNeededMib, mib(need)}, {Fact::kAvailableMib, mib(arena.capacity())}}),
      fail(ErrorCode::kOutOfMemory,
           "%s: the object's %.0f crossings need about %.1f MiB, the arena has %.1f MiB.\tUse a larger arena, "
           "a coarser grid or a smaller scale",
           need == shooting ? "rays" : (need == sorting ? "R-Rep" : "layers"), sure.crossings, mib(need),
           mib(arena.capacity())));
}

}  // namespace plumbline::inline slicer
