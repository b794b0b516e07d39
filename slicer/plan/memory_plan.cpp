#include "slicer/plan/memory_plan.hpp"

#include <algorithm>
#include <limits>

#include "slicer/checks/stack_checker.hpp"
#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/cloud/outliers.hpp"
#include "slicer/cloud/proof_sample.hpp"
#include "slicer/cloud/thinning.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/mib.hpp"
#include "slicer/dose/bleed.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/layers/layer_features.hpp"
#include "slicer/normals/normals.hpp"
#include "slicer/orientation/surface_samples.hpp"
#include "slicer/rays/ray_shooter.hpp"
#include "slicer/reader/scan_reader.hpp"
#include "slicer/rrep/components.hpp"
#include "slicer/rrep/confidence.hpp"
#include "slicer/supports/drawing/grey_masks.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/support_finder.hpp"
#include "slicer/surface/clustering.hpp"
#include "slicer/surface/stray_pieces.hpp"
#include "slicer/views/registration.hpp"

namespace plumbline::inline slicer {
namespace {

/// Bytes for the alignment of a stage's blocks: each may lose up to one alignment, and a stage takes fewer than 64.
constexpr std::size_t kSlack = 64 * Arena::kAlignment;

/// Share of the grid's rays that an object is assumed to cover before its size is known. A larger share leaves less
/// room for points; with a smaller one, more objects are refused after they have been read.
constexpr double kCoveredShare = 0.5;
/// Assumed crossings of each of these rays. Figures and animals have 2.3 to 3.
constexpr double kCrossingsPerRay = 3;
/// Those that every object has: it is entered and left. Where no thinning makes room, a job is refused only if these don't fit.
constexpr double kFewestCrossingsPerRay = 2;

/// Larger than any budget, with 32 bits too, and small enough that sums of a few of them do not overflow.
constexpr std::size_t kTooMuch = std::numeric_limits<std::size_t>::max() / 8;

std::size_t bounded(double bytes) {
  return bytes < static_cast<double>(kTooMuch) ? static_cast<std::size_t>(bytes) : kTooMuch;
}

/// @param rays_a_pixel  with several, the object is assumed to cover half as much: their crossings can't be spared
RayYield expected_yield(const PrintGrid& grid, double crossings_per_ray, std::uint32_t rays_a_pixel) {
  const double rays = kCoveredShare * grid.columns * grid.rows / (rays_a_pixel > 1 ? 2 : 1);
  return {rays, crossings_per_ray * rays};
}

}  // namespace

std::size_t store_bytes(const PrintGrid& grid, const RayYield& yield) {
  const std::size_t tiles = std::size_t{(grid.columns + 7) / 8} * ((grid.rows + 7) / 8);
  return 4 * tiles + bounded(yield.rays + 2 * yield.crossings);
}

std::size_t rrep_bytes(const PrintGrid& grid, const RayYield& yield) {
  return bounded(4 * yield.crossings) + 4 * (std::size_t{grid.layers} + 1);
}

std::size_t rrep_stage_bytes(const PrintGrid& grid, std::size_t store, const RayYield& yield, std::uint32_t rays) {
  const std::size_t sorted = rrep_bytes(grid, yield);
  // The store is first moved to the top of the arena, so for a moment there are two of it. Of several, those that are sorted give theirs back.
  const std::size_t sorting = std::max(store, sorted) + CrossingStore::row_room_bytes(grid);
  const std::size_t others = (rays - 1) * std::max(store, sorted);
  return kSlack +
         std::max({store + others + sorting, rays * store + components_bytes(grid, yield.rays, yield.crossings),
                   rays * sorted + layer_features_bytes(grid)});
}

std::size_t views_stage_bytes(std::uint32_t views) { return kSlack + register_views_bytes(views); }

std::size_t layers_stage_bytes(const PrintGrid& grid, std::size_t struts, Grey grey) {
  return kSlack + MaskStream::bytes_needed(grid, struts) + GreyMasks::bytes_needed(grid, struts, grey) +
         StackChecker::bytes_needed(grid, struts > 0 ? OverhangRule::kNone : OverhangRule::kNeedSupport);
}

std::size_t MemoryPlan::peak() const { return *std::max_element(bytes.begin(), bytes.end()); }

Stage MemoryPlan::widest() const {
  return static_cast<Stage>(std::max_element(bytes.begin(), bytes.end()) - bytes.begin());
}

std::uint32_t tile_capacity(std::uint32_t points) { return std::min<std::uint32_t>(points, 32768); }

std::size_t ray_points_bytes(std::uint32_t points) {
  return (Cloud::kBytesPerPoint + KdTree2::kBytesPerPoint) * std::size_t{points} + WindingTree::bytes_needed(points) +
         sizeof(std::uint32_t) * most_wide_supports(points);
}

std::uint32_t ray_points_in(std::size_t bytes) {
  // In whole leaves of the winding number tree, the last of which takes less.
  constexpr std::uint32_t kMany = 1024;
  constexpr std::uint32_t kLeaf = 8;
  const std::size_t leaves = bytes / (ray_points_bytes(kMany) * kLeaf / kMany);
  return static_cast<std::uint32_t>(std::min<std::size_t>(leaves * kLeaf, 2 * kMostPoints));
}

std::size_t kept_bytes(std::uint32_t points, std::uint32_t layers, bool confidence) {
  return proof_bytes(points) + (confidence ? ConfidenceMap::bytes_needed(layers) : 0);
}

MemoryPlan plan_memory(std::uint32_t points, const std::optional<PrintGrid>& grid, std::uint32_t threads,
                       const PlanEvidence& evidence) {
  MemoryPlan plan;
  plan.points = points;
  const auto set = [&](Stage stage, std::size_t bytes) {
    plan.bytes[static_cast<std::size_t>(stage)] = bytes + kSlack;
  };
  const std::size_t cloud = Cloud::kBytesPerSeenPoint * std::size_t{points};
  const std::size_t tree = KdTree3::kBytesPerPoint * std::size_t{points};
  const auto reader =
      static_cast<std::size_t>(std::min<std::uint64_t>(evidence.reader_bytes, kTooMuch) + evidence.kept_bytes);
  set(Stage::kRead, cloud + PointThinner::table_bytes(points) + kReaderWorkspace + reader);
  set(Stage::kNormals, cloud + tree + std::max(normals_bytes(points), sample_surface_bytes(points)));
  set(Stage::kTrees, cloud + tree + outliers_bytes(points));
  set(Stage::kViews, cloud + tree + register_views_bytes(evidence.views));
  set(Stage::kClustering,
      cloud + tree + proof_bytes(points) +
          std::max({clustering_bytes(points), sizeof(PackedNormal) * std::size_t{points}, stray_pieces_bytes(points)}));
  std::size_t store = 0;  // of all rays
  const std::uint32_t rays = rays_for(evidence.grey);
  // Without a grid the number of layers is unknown, but the cells take most of the map.
  const std::size_t kept = kept_bytes(points, grid ? grid->layers : 0, evidence.confidence);
  if (grid) {
    // While rays are shot, points share the arena with the crossings, so more of these mean fewer points. Afterwards all points
    // are gone, and what the crossings need can't be spared.
    store = rays * store_bytes(*grid, evidence.yield.value_or(expected_yield(*grid, kCrossingsPerRay, rays)));
    const RayYield yield = evidence.yield.value_or(expected_yield(*grid, kFewestCrossingsPerRay, rays));
    const std::size_t sorted = rays * rrep_bytes(*grid, yield);
    set(Stage::kRRep, kept + rrep_stage_bytes(*grid, store_bytes(*grid, yield), yield, rays));
    const std::uint32_t struts = most_struts(*grid);
    set(Stage::kSupports,
        kept + sorted +
            std::max(find_supports_bytes(*grid), bleed_bytes(*grid, static_cast<std::size_t>(yield.crossings))));
    set(Stage::kLayers, kept + sorted + struts * sizeof(Strut) + layers_stage_bytes(*grid, struts, evidence.grey));
  }
  const std::size_t workers = threads * ray_worker_bytes(tile_capacity(evidence.ray_points.value_or(points)));
  const std::size_t shooting = kSlack + kept + store + workers;
  const std::uint32_t ray_points = evidence.ray_points.value_or(
      std::clamp(ray_points_in(evidence.arena_bytes - std::min(evidence.arena_bytes, shooting)),
                 static_cast<std::uint32_t>(kLeastJoined * points), points));
  set(Stage::kWindingTree,
      kept + std::max(cloud, Cloud::kBytesPerPoint * std::size_t{ray_points} + WindingTree::bytes_needed(ray_points)));
  set(Stage::kRayGrid, kept + ray_points_bytes(ray_points));
  set(Stage::kRays, kept + ray_points_bytes(ray_points) + store + workers);
  return plan;
}

Expected<MemoryPlan> largest_plan(std::size_t arena_bytes, std::optional<std::uint64_t> declared,
                                  const std::optional<PrintGrid>& grid, std::uint32_t threads, PlanEvidence evidence) {
  evidence.arena_bytes = arena_bytes;
  const auto most =
      static_cast<std::uint32_t>(std::clamp<std::uint64_t>(declared.value_or(kMostPoints), kFewestPoints, kMostPoints));
  MemoryPlan plan = plan_memory(kFewestPoints, grid, threads, evidence);
  if (plan.peak() > arena_bytes) {
    if (evidence.reader_bytes > 0 && plan_memory(kFewestPoints, grid, threads).peak() <= arena_bytes) {
      return telling(
          Told(ToldCode::kMemoryNeeded,
               {{Fact::kNeededMib, mib(evidence.reader_bytes)}, {Fact::kAvailableMib, mib(arena_bytes)}}),
          fail(
              ErrorCode::kOutOfMemory,
              "the job does not fit into the arena of %.1f MiB: this compressed scan stores its columns one after "
              "another, and keeping them takes %.1f MiB while it is read.\tSave it without compression (PCD as binary, "
              "splats as PLY), or use a larger arena",
              mib(arena_bytes), mib(evidence.reader_bytes)));
    }
    return telling(
        Told(ToldCode::kMemoryNeeded, {{Fact::kNeededMib, mib(plan.peak())}, {Fact::kAvailableMib, mib(arena_bytes)}}),
        fail(ErrorCode::kOutOfMemory,
             "the job does not fit into the arena of %.1f MiB: stage '%.*s' needs %.1f MiB even for a scan "
             "thinned to %u points.\tUse a larger arena, fewer threads or a smaller panel",
             mib(arena_bytes), static_cast<int>(to_string(plan.widest()).size()), to_string(plan.widest()).data(),
             mib(plan.peak()), kFewestPoints));
  }
  std::uint32_t low = kFewestPoints;
  std::uint32_t high = most;
  while (low < high) {
    const std::uint32_t middle = low + (high - low + 1) / 2;
    if (plan_memory(middle, grid, threads, evidence).peak() <= arena_bytes) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return plan_memory(low, grid, threads, evidence);
}

}  // namespace plumbline::inline slicer
