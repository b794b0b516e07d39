#include "slicer/rrep_building.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/stage_scope.hpp"
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

namespace plumbline {
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

class RayStages {
 public:
  RayStages(Cloud& cloud, const SliceSettings& settings, Arena& arena, ProgressSink* progress, SliceReport& report)
      : cloud_(cloud), settings_(settings), arena_(arena), progress_(progress), report_(report) {}

  Expected<CrossingStore> run() {
    PLUMBLINE_TRY(start_confidence());
    PLUMBLINE_TRY(join());
    PLUMBLINE_TRY(build_winding_tree());
    PLUMBLINE_TRY(build_flat_tree());
    PLUMBLINE_TRY(admit());
    return shoot();
  }

 private:
  const PrintGrid& grid() const { return report_.placement.grid; }
  float epsilon_mm() const { return report_.lengths.epsilon.value; }

  /// Joins points, more of them where the arena is short. The height of the base plane is measured first, since a joined point lies
  /// above its lowest one.
  Status join() {
    const StageScope stage(Stage::kWindingTree, arena_, progress_, report_.peak_bytes);
    base_height_ = report_.floor_mm ? *report_.floor_mm : base_plane(cloud_.positions(), grid().layer_height_mm);
    const std::uint32_t points = cloud_.size;
    join_points(cloud_, most_ray_points(placed(false), arena_));
    spread_ = std::sqrt(static_cast<float>(points) / static_cast<float>(cloud_.size));
    return cloud_.give_back(arena_, false);
  }

  Status build_winding_tree() {
    const StageScope stage(Stage::kWindingTree, arena_, progress_, report_.peak_bytes);
    const auto nodes = arena_.take_top<WindingTree::Node>(WindingTree::nodes_needed(cloud_.size), "winding number");
    PLUMBLINE_TRY(nodes);
    winding_ = WindingTree::build(cloud_, *nodes);
    if (settings_.base == BaseChoice::kNone) return {};
    report_.flat_underside = winding_.set_base(base_height_, epsilon_mm(), settings_.base == BaseChoice::kFlat);
    return {};
  }

  Status build_flat_tree() {
    const StageScope stage(Stage::kRayGrid, arena_, progress_, report_.peak_bytes);
    auto tree = KdTree2::build(cloud_.positions(), arena_, "ray grid", {progress_, Stage::kRayGrid});
    PLUMBLINE_TRY(tree);
    tree_ = *tree;
    report_.width_mm = grid_width(cloud_, *tree_) / spread_;
    if (!(report_.width_mm > kLeastWidth)) report_.width_mm = std::max(kLeastWidth, epsilon_mm());
    return list_wide_supports();
  }

  /// Lists the supports of sparse surface, which the search for a ray's points meets apart from the others.
  Status list_wide_supports() {
    const auto radii = cloud_.radius.first(cloud_.size);
    const auto is_wide = [&](float radius) { return widths_.is_wide(radius); };
    const auto count = [&] { return static_cast<std::uint32_t>(std::ranges::count_if(radii, is_wide)); };
    widths_.least = kLeastPixels * std::max(grid().pitch_x_mm, grid().pitch_y_mm);
    widths_.usual = std::max(widths_.least, usual_support(epsilon_mm(), cloud_.support_points));
    widths_.share = std::sqrt(kCleanSupport / cloud_.support_points);
    while (count() > most_wide_supports(cloud_.size)) widths_.usual *= kWider;
    const auto wide = arena_.take_top<std::uint32_t>(count(), "wide supports");
    PLUMBLINE_TRY(wide);
    std::size_t listed = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (!is_wide(radii[i])) continue;
      (*wide)[listed++] = i;
      widths_.widest = std::max(widths_.widest, widths_.of(radii[i]));
    }
    std::ranges::sort(*wide, {}, [&](std::uint32_t i) { return std::pair(cloud_.position[i][0], i); });
    widths_.wide = *wide;
    return {};
  }

  Status start_confidence() {
    if (!settings_.confidence) return {};
    auto map = ConfidenceMap::create(grid(), cloud_.bounds(), epsilon_mm(), arena_);
    PLUMBLINE_TRY(map);
    for (const Vec3f& p : cloud_.positions()) map->add_point(p);
    report_.confidence = *map;
    return {};
  }

  PlacedObject placed(bool is_joined) const {
    return {.cloud = cloud_,
            .read_points = report_.cloud_points,
            .grid = grid(),
            .confidence = settings_.confidence,
            .threads = settings_.threads,
            .is_joined = is_joined};
  }

  Status admit() { return admit_rays(placed(true), arena_, report_.planned_bytes); }

  bool is_height_field() const {
    return winding_.has_base() && report_.clustering.points.is_negligible(PointClass::kEntering);
  }

  Expected<CrossingStore> shoot() {
    const StageScope stage(Stage::kRays, arena_, progress_, report_.peak_bytes);
    RayField field;
    field.cloud = &cloud_;
    field.tree = &*tree_;
    field.winding = &winding_;
    field.grid = grid();
    field.width = report_.width_mm;
    field.widths = widths_;
    field.tile_capacity = tile_capacity(cloud_.capacity());
    field.height_field = is_height_field();
    const float tolerance = std::max(kLayerShare * grid().layer_height_mm, kNoiseShare * report_.lengths.noise.value);
    ConfidenceMap* const confidence = settings_.confidence ? &report_.confidence : nullptr;
    return shoot_all_rays(field, tolerance, confidence, settings_.threads, arena_, {progress_, Stage::kRays},
                          report_.rays);
  }

  Cloud& cloud_;
  const SliceSettings& settings_;
  Arena& arena_;
  ProgressSink* progress_;
  SliceReport& report_;
  SupportWidths widths_;
  float base_height_ = 0;  ///< mm
  float spread_ = 1;       ///< distance of joined points over that of the scan's
  WindingTree winding_;
  std::optional<KdTree2> tree_;
};

void drop_features(RRep& rrep, Arena& arena, SliceReport& report) {
  const FeatureLimits limits =
      feature_limits(report.support_points, report.lengths.epsilon, report.lengths.noise, rrep.grid);
  // Removing a feature can let the mask's opening cut off what it supported, so noisy scans get a second sweep.
  const int sweeps = widening(report.support_points) > 1 ? 2 : 1;
  for (int sweep = 0; sweep < sweeps && !report.features.totals; ++sweep) {
    // Without room for the search, small features stay, and the print is as good as the scan.
    if (const auto features = drop_small_features(rrep, limits, arena)) report.features += *features;
  }
}

/// An outlier can be the lowest or the highest point. The object is to stand on the plate, so the first layer is the first
/// with a pixel.
Status trim(RRep& rrep, Arena& arena, SliceReport& report) {
  const auto& totals = report.features.totals;
  if (totals) report.object_pixels = totals->pixels;
  const std::optional<EmptyLayers> known = totals ? std::optional(totals->empty) : std::nullopt;
  const auto trimmed = trim_empty_layers(rrep, arena, known);
  if (!trimmed && trimmed.error().code() == ErrorCode::kNoSurface) return tl::unexpected<Error>(trimmed.error());
  const EmptyLayers empty = trimmed.value_or(EmptyLayers{});
  report.crossings = rrep.crossings();
  report.placement.grid.layers = rrep.grid.layers;
  report.confidence.trim(empty.below, empty.above);
  report.placement.shift[2] -= static_cast<double>(empty.below) * rrep.grid.layer_height_mm;
  return {};
}

/// Plans the R-Rep anew, since the crossings are known now.
void plan_rrep(const CrossingStore& store, const Arena& arena, SliceReport& report) {
  const PrintGrid& grid = store.grid();
  const RayYield yield{static_cast<double>(report.rays.interested() -
                                           report.rays.decided[static_cast<std::size_t>(RayDecision::kOutside)]),
                       static_cast<double>(store.crossings())};
  report.planned_bytes[static_cast<std::size_t>(Stage::kRRep)] =
      arena.used() - store.bytes() + rrep_stage_bytes(grid, store.bytes(), yield);
}

}  // namespace

Expected<CrossingStore> shoot_rays(Cloud& cloud, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                                   SliceReport& report) {
  return RayStages(cloud, settings, arena, progress, report).run();
}

Expected<RRep> finish_rrep(CrossingStore& store, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                           SliceReport& report) {
  const StageScope stage(Stage::kRRep, arena, progress, report.peak_bytes);
  if (!report.mesh) {
    plan_rrep(store, arena, report);
    ComponentLimits limits = component_limits(report.lengths.epsilon, report.placement.grid);
    limits.drop_floating = !settings.keep_all;
    report.components = drop_small_components(store, limits, arena);
    report.proof = prove(store, std::exchange(report.sample, {}), kNoiseReach * report.lengths.noise.value);
  }
  auto rrep = CrossingStore::sort(store, arena);
  PLUMBLINE_TRY(rrep);
  rrep->is_exact = report.mesh.has_value();  // a mesh is printed as it is, however small its parts are
  if (report.mesh) {
    report.object_pixels = store.section_pixels();
  } else {
    drop_features(*rrep, arena, report);
  }
  PLUMBLINE_TRY(trim(*rrep, arena, report));
  const PrintGrid& grid = rrep->grid;
  report.extent = extent_of(*rrep);
  report.printed_mm = {(report.extent.right - report.extent.left) * static_cast<double>(grid.pitch_x_mm),
                       (report.extent.bottom - report.extent.top) * static_cast<double>(grid.pitch_y_mm),
                       grid.layers * static_cast<double>(grid.layer_height_mm)};
  if (!settings.placement.fit) report.asked_size = settings.placement.size;
  return rrep;
}

}  // namespace plumbline
