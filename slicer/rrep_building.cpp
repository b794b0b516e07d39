#include "slicer/rrep_building.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "slicer/cloud/kd_tree.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/layers/feature_limits.hpp"
#include "slicer/layers/rrep_edit.hpp"
#include "slicer/placement/base_plane.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/plan/ray_admission.hpp"
#include "slicer/rays/grid_width.hpp"
#include "slicer/rays/ray_shooter.hpp"
#include "slicer/surface/clustering.hpp"
#include "slicer/surface/joined_points.hpp"

namespace plumbline::inline slicer {
namespace {

// Difference between a ray and the polynomial that may stand for it: this share of a layer, or of the noise if that is more.
constexpr float kLayerShare = 1.0F / 50;
constexpr float kNoiseShare = 1.0F / 10;

/// Of the scan's noise: farther than so many from the surface, hardly a point lies by chance.
constexpr float kNoiseReach = 4;

/// Pixels. A ray that passes closer to a silhouette must see it, or the block of rays that shares its levels decides for it.
constexpr float kLeastPixels = 1.25F;

/// Factor by which the usual support grows until few are wider.
constexpr float kWider = 1.25F;

/// mm; below it the grid width w is 0 but for rounding: there are too few practical points for one.
constexpr float kLeastWidth = 1e-4F;

/// Joins points, more of them where the arena is short, and makes them dipoles.
/// @param most  points that the rays have room for
Expected<WindingTree> build_winding_tree(PlacedScan& scan, std::uint32_t most, BaseChoice base,
                                         const StageContext& job) {
  const StageScope stage(Stage::kWindingTree, job);
  Cloud& cloud = scan.cloud;
  // A joined point lies above its lowest one, so this comes first.
  const float base_mm = scan.floor ? *scan.floor : base_plane(cloud.positions(), scan.placement.grid.layer_height_mm);
  join_points(cloud, most);
  PLUMBLINE_TRY(cloud.give_back(job.arena, false));
  const auto nodes = job.arena.take_top<WindingTree::Node>(WindingTree::nodes_needed(cloud.size), "winding number");
  PLUMBLINE_TRY(nodes);
  WindingTree winding = WindingTree::build(cloud, *nodes);
  if (base != BaseChoice::kNone) winding.set_base(base_mm, scan.lengths.epsilon.value, base == BaseChoice::kFlat);
  return winding;
}

/// Lists the supports of sparse surface, which the search for a ray's points meets apart from the others.
Expected<SupportWidths> list_wide_supports(const PlacedScan& scan, Arena& arena) {
  const Cloud& cloud = scan.cloud;
  const PrintGrid& grid = scan.placement.grid;
  SupportWidths widths;
  const auto radii = cloud.radius.first(cloud.size);
  const auto is_wide = [&](float radius) { return widths.is_wide(radius); };
  const auto count = [&] { return static_cast<std::uint32_t>(std::ranges::count_if(radii, is_wide)); };
  widths.least = kLeastPixels * std::max(grid.pitch_x_mm, grid.pitch_y_mm);
  widths.usual = std::max(widths.least, usual_support(scan.lengths.epsilon.value, cloud.support_points));
  widths.share = std::sqrt(kCleanSupport / cloud.support_points);
  while (count() > most_wide_supports(cloud.size)) widths.usual *= kWider;
  const auto wide = arena.take_top<std::uint32_t>(count(), "wide supports");
  PLUMBLINE_TRY(wide);
  std::size_t listed = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (!is_wide(radii[i])) continue;
    (*wide)[listed++] = i;
    widths.widest = std::max(widths.widest, widths.of(radii[i]));
  }
  std::ranges::sort(*wide, {}, [&](std::uint32_t i) { return std::pair(cloud.position[i][0], i); });
  widths.wide = *wide;
  return widths;
}

/// Share of the time of all rays of a pixel that the first one takes.
constexpr double kFirstRay = 0.5;

/// Sorts the crossings of all rays of a pixel.
Expected<RRep> sort_all(ShotObject& shot, Arena& arena) {
  if (!shot.has_others) return CrossingStore::sort(shot.store, arena);
  const ArenaScope scope(arena);
  // The newest block at the bottom goes first, and that at the top is sorted first: the R-Rep of ray 0 becomes the newest at the bottom.
  PLUMBLINE_TRY(shot.store.move_to_top(arena));
  std::array<std::size_t, kRaysAround> marks = {};
  for (std::size_t i = marks.size(); i-- > 0;) {
    marks[i] = arena.top_mark();
    PLUMBLINE_TRY(shot.others[i].move_to_top(arena));
  }
  const auto others = arena.take_bottom<RRep>(marks.size(), "R-Rep");
  PLUMBLINE_TRY(others);
  for (std::uint32_t i = 0; i < marks.size(); ++i) {
    auto rrep = CrossingStore::sort(shot.others[i], arena);
    PLUMBLINE_TRY(rrep);
    rrep->grid = with_ray(rrep->grid, i + 1);
    rrep->is_exact = shot.is_mesh;
    (*others)[i] = *rrep;
    arena.release_top(marks[i]);
  }
  auto rrep = CrossingStore::sort(shot.store, arena);
  PLUMBLINE_TRY(rrep);
  rrep->others = others->data();
  return rrep;
}

FeatureCounts drop_features(RRep& rrep, const ShotObject& shot, Arena& arena) {
  const FeatureLimits limits = feature_limits(shot.support_points, shot.lengths.epsilon, shot.lengths.noise, rrep.grid);
  // Removing a feature can let the mask's opening cut off what it supported, so noisy scans get a second sweep.
  const int sweeps = widening(shot.support_points) > 1 ? 2 : 1;
  FeatureCounts counts;
  for (int sweep = 0; sweep < sweeps && !counts.totals; ++sweep) {
    // Without room for the search, small features stay, and the print is as good as the scan.
    if (const auto features = drop_small_features(rrep, limits, arena)) counts += *features;
  }
  return counts;
}

}  // namespace

Expected<ShotObject> shoot_rays(PlacedScan scan, const SliceSettings& settings, const StageContext& job) {
  Arena& arena = job.arena;
  const Cloud& cloud = scan.cloud;
  const PrintGrid& grid = scan.placement.grid;
  ShotObject shot{.placement = scan.placement,
                  .lengths = scan.lengths,
                  .support_points = cloud.support_points,
                  .sample = scan.sample};
  if (settings.confidence) {
    auto map = ConfidenceMap::create(grid, cloud.bounds(), scan.lengths.epsilon.value, arena);
    PLUMBLINE_TRY(map);
    for (const Vec3f& p : cloud.positions()) map->add_point(p);
    shot.confidence = *map;
  }
  PlacedObject object{.cloud = cloud,
                      .read_points = scan.read_points,
                      .grid = grid,
                      .grey = settings.grey,
                      .confidence = settings.confidence,
                      .threads = settings.threads,
                      .is_joined = false};
  const std::uint32_t points = cloud.size;
  const auto winding = build_winding_tree(scan, most_ray_points(object, arena), settings.base, job);
  PLUMBLINE_TRY(winding);
  object.is_joined = true;
  shot.flat_underside = winding->has_base();
  std::optional<KdTree2> tree;
  SupportWidths widths;
  {
    const StageScope stage(Stage::kRayGrid, job);
    auto built = KdTree2::build(cloud.positions(), arena, "ray grid", {job.progress, Stage::kRayGrid});
    PLUMBLINE_TRY(built);
    tree = *built;
    // Joined points are farther apart than those of the scan.
    const float spread = std::sqrt(static_cast<float>(points) / static_cast<float>(cloud.size));
    shot.width_mm = grid_width(cloud, *tree) / spread;
    if (!(shot.width_mm > kLeastWidth)) shot.width_mm = std::max(kLeastWidth, scan.lengths.epsilon.value);
    const auto listed = list_wide_supports(scan, arena);
    PLUMBLINE_TRY(listed);
    widths = *listed;
  }
  PLUMBLINE_TRY(admit_rays(object, arena, job.memory.planned_bytes));
  const StageScope stage(Stage::kRays, job);
  RayField field{.cloud = &cloud,
                 .tree = &*tree,
                 .winding = &*winding,
                 .grid = grid,
                 .width = shot.width_mm,
                 .widths = widths,
                 .tile_capacity = tile_capacity(cloud.capacity()),
                 .height_field = winding->has_base() && scan.classes.is_negligible(PointClass::kEntering)};
  const float tolerance = std::max(kLayerShare * grid.layer_height_mm, kNoiseShare * scan.lengths.noise.value);
  const StageProgress progress{job.progress, Stage::kRays};
  shot.has_others = rays_for(settings.grey) > 1;
  {
    const ArenaScope workers(arena);
    const auto store =
        shoot_all_rays(field, tolerance, settings.confidence ? &shot.confidence : nullptr, settings.threads, arena,
                       progress.part(0, shot.has_others ? kFirstRay : 1), shot.rays);
    PLUMBLINE_TRY(store);
    shot.store = *store;
  }
  if (!shot.has_others) return shot;
  for (std::uint32_t i = 0; i < shot.others.size(); ++i) {
    field.grid = with_ray(grid, i + 1);
    const auto done = [](std::uint32_t rays) { return kFirstRay + (1 - kFirstRay) * rays / kRaysAround; };
    const auto store =
        shoot_other_rays(field, shot.store, settings.threads, arena, progress.part(done(i), done(i + 1)));
    PLUMBLINE_TRY(store);
    shot.others[i] = *store;
  }
  CrossingStore::put_last(shot.store, shot.others, arena);
  return shot;
}

Expected<RRep> finish_rrep(ShotObject& shot, const SliceSettings& settings, const StageContext& job,
                           SliceReport& report) {
  const StageScope stage(Stage::kRRep, job);
  Arena& arena = job.arena;
  report.flat_underside = shot.flat_underside;
  report.width_mm = shot.width_mm;
  report.rays = shot.rays;
  if (!settings.placement.fit) report.asked_size = settings.placement.size;
  report.turned_since = report.turned || settings.placement.rotation_degrees != Vec3d::Zero();
  if (!shot.is_mesh) {
    const std::uint64_t outside = shot.rays.decided[static_cast<std::size_t>(RayDecision::kOutside)];
    const RayYield yield{static_cast<double>(shot.rays.interested() - outside),
                         static_cast<double>(shot.store.crossings())};
    const std::uint32_t rays = shot.has_others ? (1 + kRaysAround) : 1;
    std::size_t others = 0;
    if (shot.has_others)
      for (const CrossingStore& store : shot.others) others += store.bytes();
    job.memory.planned(Stage::kRRep) = arena.used() - shot.store.bytes() - others +
                                       rrep_stage_bytes(shot.store.grid(), shot.store.bytes(), yield, rays);
    ComponentLimits limits = component_limits(shot.lengths.epsilon, shot.placement.grid);
    limits.drop_floating = !settings.keep_all;
    report.components = drop_small_components(shot.store, limits, arena);
    // The sample lies where the scan has it, not where its outlines were moved to. Beyond a pixel prove() would not find these.
    const PrintGrid& grid = shot.placement.grid;
    const auto moved = static_cast<float>(std::abs(settings.absolute_correction_mm));
    if (moved <= std::min(grid.pitch_x_mm, grid.pitch_y_mm)) {
      report.proof = prove(shot.store, shot.sample, kNoiseReach * shot.lengths.noise.value + moved);
    }
  }
  auto rrep = sort_all(shot, arena);
  PLUMBLINE_TRY(rrep);
  rrep->is_exact = shot.is_mesh;
  std::optional<EmptyLayers> known;
  if (shot.is_mesh) {
    report.object_pixels = shot.store.section_pixels();
  } else {
    report.features = drop_features(*rrep, shot, arena);
    if (const auto& totals = report.features.totals) {
      report.object_pixels = totals->pixels;
      known = totals->empty;
    }
  }
  // An outlier can be the lowest or the highest point. The object is to stand on the plate, so the first layer is the first with a pixel.
  const auto trimmed = trim_empty_layers(*rrep, arena, known);
  if (!trimmed && trimmed.error().code() == ErrorCode::kNoSurface) return tl::unexpected<Error>(trimmed.error());
  const EmptyLayers empty = trimmed.value_or(EmptyLayers{});
  for (RRep& other : rrep->other_rays()) cut_layers(other, empty);
  shot.confidence.trim(empty.below, empty.above);
  const PrintGrid& grid = rrep->grid;
  shot.placement.grid.layers = grid.layers;
  shot.placement.shift[2] -= static_cast<double>(empty.below) * grid.layer_height_mm;
  report.placement = shot.placement;
  report.confidence = shot.confidence;
  report.crossings = rrep->crossings();
  report.extent = extent_of(*rrep);
  report.printed_mm = {(report.extent.right - report.extent.left) * static_cast<double>(grid.pitch_x_mm),
                       (report.extent.bottom - report.extent.top) * static_cast<double>(grid.pitch_y_mm),
                       grid.layers * static_cast<double>(grid.layer_height_mm)};
  return rrep;
}

}  // namespace plumbline::inline slicer
