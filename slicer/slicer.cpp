#include "slicer/slicer.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/layers/feature_limits.hpp"
#include "slicer/layers/layer_features.hpp"
#include "slicer/layers/rrep_edit.hpp"
#include "slicer/normals/normals.hpp"
#include "slicer/placement/base_plane.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/plan/ray_admission.hpp"
#include "slicer/plan/scan_admission.hpp"
#include "slicer/rays/ray_grid.hpp"
#include "slicer/surface/surface_points.hpp"

namespace plumbline {
namespace {

/// Thinning never merges points that a print could tell apart: its first cell is this share of the pixel pitch.
constexpr double kCellShare = 0.5;

/// Supports are cut to this share of epsilon, so that a search reaches no farther where the scan is thin.
constexpr float kMaxRadiusShare = 1.15F;
constexpr float kMaxRadiusSupport = 40;  ///< points: a larger support is cut to a larger share, in proportion

/// First cell of the thinning in scan units; 0 where the size of a scan unit on the print is not known yet.
double first_cell(const PlacementSettings& p) {
  if (p.fit || p.units == Units::kAuto) return 0;
  const double pitch = p.printer ? std::min(p.printer->pitch_x_mm, p.printer->pitch_y_mm) : p.pixel_pitch_mm;
  return kCellShare * std::min(pitch, static_cast<double>(p.layer_height_mm)) / (millimetres_per(p.units) * p.scale);
}

/// Uniform queries of a repair are no denser than this share of epsilon, a quarter of the points' spacing: a surface has no
/// detail finer than that. It bounds the work: the farther apart the points, the more rays see each and the fewer queries a
/// ray makes.
constexpr float kRepairShare = 1.0F / 16;

constexpr double kAligned = 0.85;  ///< of the time for views; a new tree takes the rest

constexpr float kSectionEpsilons = 2;  ///< from section to section above the base plane

}  // namespace

const char* to_string(BaseChoice choice) {
  switch (choice) {
    case BaseChoice::kAuto: return "auto";
    case BaseChoice::kNone: return "none";
    case BaseChoice::kFlat: return "flat";
  }
  return "unknown";
}

namespace {

/// One job, stage by stage; each method is one arrow of the data's way.
class Job {
 public:
  Job(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress, SliceReport& report)
      : sources_(sources), settings_(settings), arena_(arena), progress_(progress), report_(report) {}

  Expected<RRep> run() {
    const std::size_t top = arena_.top_mark();
    const std::size_t bottom = arena_.bottom_mark();
    auto store = crossings();
    arena_.release_top(top);
    if (!store) {
      report_.confidence = {};
      arena_.release_bottom(bottom);
      return tl::unexpected<Error>(store.error());
    }
    const StageScope stage(Stage::kRRep, arena_, progress_, report_.peak_bytes);
    ComponentLimits limits = component_limits(report_.clustering, report_.placement.grid);
    limits.drop_floating = !settings_.keep_all;
    report_.components = drop_small_components(*store, limits, arena_);
    auto rrep = CrossingStore::sort(*store, arena_);
    if (rrep) {
      finish(*rrep);
    } else {
      report_.confidence = {};
      arena_.release_bottom(bottom);
    }
    return rrep;
  }

 private:
  /// What only the layers as a whole can tell.
  void finish(RRep& rrep) {
    const PrintGrid& grid = rrep.grid;
    const FeatureLimits limits = feature_limits(report_.clustering, settings_.clustering, grid);
    const bool noisy = widening(report_.clustering, settings_.clustering) > 1;
    // Removing a feature can let the mask's opening cut off what it supported, so noisy scans get a second sweep.
    for (int sweep = 0; sweep < (noisy ? 2 : 1) && !report_.features.totals; ++sweep) {
      // Without room for it the print is as good as the scan: no reason to refuse it.
      if (const auto features = drop_small_features(rrep, limits, arena_)) report_.features += *features;
    }
    // The lowest point may be a stray, and so may the highest. What is printed stands on the plate, so the first layer is the
    // first with a pixel.
    const auto& totals = report_.features.totals;
    const std::optional<EmptyLayers> known = totals ? std::optional(totals->empty) : std::nullopt;
    const EmptyLayers empty = trim_empty_layers(rrep, arena_, known).value_or(EmptyLayers{});
    report_.crossings = rrep.crossings();
    report_.placement.grid.layers = rrep.grid.layers;
    report_.confidence.trim(empty.below, empty.above);
    report_.placement.shift[2] -= static_cast<double>(empty.below) * grid.layer_height_mm;
  }

  Expected<CrossingStore> crossings() {
    PLUMBLINE_TRY(read());
    PLUMBLINE_TRY(find_surface());
    PLUMBLINE_TRY(place_object());
    PLUMBLINE_TRY(build_winding_tree());
    return shoot();
  }

  Status read() {
    const StageScope stage(Stage::kRead, arena_, progress_, report_.peak_bytes);
    const PlacementSettings& placement = settings_.placement;
    std::optional<PrintGrid> panel;
    if (placement.printer) panel = panel_grid(*placement.printer, placement.layer_height_mm);
    auto admission = ScanAdmission::create(arena_.available(), panel, settings_.threads, settings_.confidence);
    PLUMBLINE_TRY(admission);
    const CloudReadSettings reading{rotation_matrix(placement.rotation_degrees), first_cell(placement)};
    const auto admit = [&](const ScanAnnouncement& announced) { return admission->admit(announced); };
    const auto read = read_cloud(sources_, reading, admit, arena_, progress_);
    PLUMBLINE_TRY(read);
    cloud_ = read->cloud;
    offset_ = read->offset;
    report_.scans = read->scans;
    report_.scan = sum_of(read->scans);
    report_.cloud_capacity = admission->room();
    report_.cloud_points = cloud_.size;
    report_.averaged_points = read->averaged;
    report_.thinning_cell_mm = read->cell;
    report_.planned_bytes = admission->plan().bytes;
    return {};
  }

  /// And puts the cloud into its order.
  Expected<KdTree3> build_tree(const StageProgress& progress) {
    auto tree = KdTree3::build(cloud_.positions(), arena_, "trees", progress);
    PLUMBLINE_TRY(tree);
    PLUMBLINE_TRY(cloud_.reorder(tree->order(), arena_));
    tree->adopt_order();
    return tree;
  }

  Status find_surface() {
    const ArenaScope scope(arena_);
    const std::size_t before_tree = arena_.top_mark();
    std::optional<KdTree3> tree;
    bool found = false;
    {
      const StageScope stage(Stage::kTrees, arena_, progress_, report_.peak_bytes);
      auto built = build_tree({progress_, Stage::kTrees});
      PLUMBLINE_TRY(built);
      tree = *built;
    }
    {
      const StageScope stage(Stage::kNormals, arena_, progress_, report_.peak_bytes);
      const auto normals = complete_normals(cloud_, *tree, arena_, {progress_, Stage::kNormals});
      PLUMBLINE_TRY(normals);
      report_.normals = *normals;
    }
    {
      const StageScope stage(Stage::kViews, arena_, progress_, report_.peak_bytes);
      const StageProgress progress{progress_, Stage::kViews};
      const auto views = align_views(cloud_, *tree, arena_, progress.part(0, kAligned));
      PLUMBLINE_TRY(views);
      report_.views = *views;
      if (views->moved > 0) {
        arena_.release_top(before_tree);
        auto built = build_tree(progress.part(kAligned, 1));
        PLUMBLINE_TRY(built);
        tree = *built;
      }
    }
    {
      const StageScope stage(Stage::kClustering, arena_, progress_, report_.peak_bytes);
      const bool estimated = report_.normals.estimated > report_.cloud_points / 2;
      const SurfaceSettings settings{settings_.clustering, estimated ? NormalSource::kPoints : NormalSource::kScanner,
                                     settings_.keep_all};
      const auto surface = find_surface_points(cloud_, *tree, settings, arena_, {progress_, Stage::kClustering});
      PLUMBLINE_TRY(surface);
      report_.clustering = surface->clustering;
      report_.strays = surface->strays;
      report_.bore_walls = surface->bore_walls;
      found = surface->found();
    }
    if (!found) {
      const ScanTitle title = title_of(sources_);
      if (report_.cloud_points < report_.scan.points / 2) {
        return fail(ErrorCode::kNoSurface,
                    "%s: its %llu points were thinned to the %u that the arena has room for, and those are no surface. "
                    "Use a larger arena (--arena-mib), or check the normals of the scan",
                    title.c_str(), static_cast<unsigned long long>(report_.scan.points), report_.cloud_points);
      }
      return fail(ErrorCode::kNoSurface,
                  "%s: its %u points are no surface: most have too few neighbours that face the same way. Check the "
                  "normals of the scan, or scan it denser",
                  title.c_str(), report_.cloud_points);
    }
    return {};
  }

  /// Only now is the extent of the object known without its strays.
  Status place_object() {
    const Box3f local = cloud_.bounds();
    Box3d bounds;
    bounds.extend(local.low.cast<double>() + offset_);
    bounds.extend(local.high.cast<double>() + offset_);
    report_.units = settings_.placement.units;
    if (report_.units == Units::kAuto) {
      report_.units = guess_units(bounds.size().maxCoeff());
      report_.units_guessed = true;
    }
    auto placed = place(bounds, millimetres_per(report_.units), settings_.placement);
    if (!placed) return tl::unexpected<Error>(placed.error());
    report_.placement = *placed;
    const double scale = placed->scale;
    const Vec3d shift = offset_ * scale + placed->shift;
    for (Vec3f& p : cloud_.position.first(cloud_.size)) p = (p.cast<double>() * scale + shift).cast<float>();
    for (float& r : cloud_.radius.first(cloud_.size)) r *= static_cast<float>(scale);
    report_.clustering.epsilon *= static_cast<float>(scale);
    report_.clustering.noise *= static_cast<float>(scale);
    report_.views.before *= static_cast<float>(scale);
    report_.views.after *= static_cast<float>(scale);
    report_.views.moved *= static_cast<float>(scale);
    report_.views.ripple *= static_cast<float>(scale);
    report_.bore_walls.area *= static_cast<float>(scale * scale);
    report_.thinning_cell_mm *= scale;
    return {};
  }

  Status build_winding_tree() {
    const StageScope stage(Stage::kWindingTree, arena_, progress_, report_.peak_bytes);
    const auto nodes = arena_.take_top<WindingTree::Node>(WindingTree::nodes_needed(cloud_.size), "winding number");
    PLUMBLINE_TRY(nodes);
    winding_ = WindingTree::build(cloud_, report_.clustering.support_points, *nodes);
    if (settings_.base == BaseChoice::kNone) return {};
    const float height = base_plane(cloud_.positions(), report_.placement.grid.layer_height_mm);
    report_.flat_underside =
        winding_.set_base(height, kSectionEpsilons * report_.clustering.epsilon, settings_.base == BaseChoice::kFlat);
    return {};
  }

  bool is_height_field() const {
    return winding_.has_base() && report_.clustering.points.is_negligible(PointClass::kEntering);
  }

  Expected<CrossingStore> shoot() {
    const PrintGrid& grid = report_.placement.grid;
    std::optional<KdTree2> tree;
    BitImage interested;
    {
      const StageScope stage(Stage::kRayGrid, arena_, progress_, report_.peak_bytes);
      auto built = KdTree2::build(cloud_.positions(), arena_, "ray grid", {progress_, Stage::kRayGrid});
      if (!built) return tl::unexpected<Error>(built.error());
      tree = *built;
      report_.width_mm = grid_width(cloud_, *tree, {});
      // Too few practical points for a width of their own: a thing of vertical walls only.
      if (!(report_.width_mm > 1e-4F)) report_.width_mm = std::max(1e-4F, report_.clustering.epsilon);
      auto words = arena_.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "ray grid");
      if (!words) return tl::unexpected<Error>(words.error());
      interested = BitImage(*words, grid.columns, grid.rows);
      PLUMBLINE_TRY(find_interested_rays(cloud_, grid, report_.width_mm, interested, arena_));
    }
    if (settings_.confidence) {
      auto map = ConfidenceMap::create(grid, cloud_.bounds(), report_.clustering.epsilon, arena_);
      PLUMBLINE_TRY(map);
      for (const Vec3f& p : cloud_.position.first(cloud_.seen())) map->add_point(p);
      report_.confidence = *map;
    }
    const PlacedObject object{cloud_,
                              report_.cloud_points,
                              report_.clustering.support_points,
                              grid,
                              interested,
                              settings_.confidence,
                              settings_.threads};
    PLUMBLINE_TRY(admit_rays(object, arena_, report_.planned_bytes));
    const StageScope stage(Stage::kRays, arena_, progress_, report_.peak_bytes);
    RayField field;
    field.cloud = &cloud_;
    field.tree = &*tree;
    field.winding = &winding_;
    field.interested = interested;
    field.confidence = settings_.confidence ? &report_.confidence : nullptr;
    field.grid = grid;
    field.max_radius = kMaxRadiusShare * report_.clustering.epsilon *
                       std::sqrt(std::max(1.0F, report_.clustering.support_points / kMaxRadiusSupport));
    field.tile_capacity = tile_capacity(cloud_.capacity());
    field.settings.intersections.width = report_.width_mm;
    field.settings.repair_spacing = std::max(grid.layer_height_mm, kRepairShare * report_.clustering.epsilon);
    field.settings.height_field = is_height_field();
    auto shooter = RayShooter::create(field, settings_.threads, arena_);
    if (!shooter) return tl::unexpected<Error>(shooter.error());
    auto store = CrossingStore::create(grid, arena_);
    if (!store) return store;
    auto rays = shooter->shoot(*store, progress_);
    if (!rays) return tl::unexpected<Error>(rays.error());
    report_.rays = *rays;
    store->close(arena_);
    arena_.reset_peak();  // the store had taken all that was left; what it used is what the stage needed
    return store;
  }

  ScanSources sources_;
  const SliceSettings& settings_;
  Arena& arena_;
  ProgressSink* progress_;
  SliceReport& report_;

  Cloud cloud_;
  Vec3d offset_ = Vec3d::Zero();  ///< rotated scan coordinates of the cloud's origin
  WindingTree winding_;
};

}  // namespace

Expected<RRep> slice(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                     SliceReport& report) {
  SliceSettings checked = settings;
  checked.threads = std::clamp<std::uint32_t>(settings.threads, 1, RayShooter::kMaxThreads);
  omp_set_num_threads(static_cast<int>(checked.threads));
  return Job(sources, checked, arena, progress, report).run();
}

}  // namespace plumbline
