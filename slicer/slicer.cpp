#include "slicer/slicer.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "slicer/kd_tree.hpp"
#include "slicer/layer_features.hpp"
#include "slicer/memory_plan.hpp"
#include "slicer/normals.hpp"
#include "slicer/ray_grid.hpp"
#include "slicer/reader/scan_reader.hpp"
#include "slicer/rrep_edit.hpp"
#include "slicer/stage_scope.hpp"
#include "slicer/thinning.hpp"
#include "slicer/winding_number.hpp"

namespace plumbline {
namespace {

/// Thinning never merges points that a print could tell apart: its first cell is this share of the pixel pitch.
constexpr double kCellShare = 0.5;

/// Supports are cut to this share of epsilon, so that a search reaches no farther where the scan is thin.
constexpr float kMaxRadiusShare = 1.15F;
constexpr float kMaxRadiusSupport = 40;  ///< points: a larger support is cut to a larger share, in proportion

/// Pieces and bubbles below this many cubes of epsilon are specks: a stray's support has some six.
constexpr float kSpeck = 50;

/// As many of the lowest points may be strays below the rim of an open underside.
constexpr std::size_t kStrays = 12;

/// Islands and holes of a layer below this many squares of epsilon, and this many cubes in all, are small features.
constexpr float kFeature = 2;

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

/// Where most points are strays, what is left of them is a surface if it has this share of core points. A surface has 0.5
/// and more; what happens to face the same way among strays is mostly of mixed type: 0.1.
constexpr double kLeastCoreShare = 0.25;

bool is_surface(const ClusteringResult& clustering, std::uint32_t kept) {
  return kept > 0 && clustering.epsilon > 0 &&
         (clustering.coherent || clustering.core_points >= kLeastCoreShare * kept);
}

/// Drops the noise, keeps the order.
void drop_noise(Cloud& cloud) {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (cloud.normal[i].point_class == PointClass::kNoise) continue;
    cloud.position[kept] = cloud.position[i];
    cloud.normal[kept] = cloud.normal[i];
    cloud.radius[kept] = cloud.radius[i];
    ++kept;
  }
  cloud.size = kept;
}

/// One job, stage by stage; each method is one arrow of the data's way.
class Job {
 public:
  Job(ByteSource& source, const SliceSettings& settings, Arena& arena, ProgressSink* progress, SliceReport& report)
      : source_(source), settings_(settings), arena_(arena), progress_(progress), report_(report) {}

  Expected<RRep> run() {
    const std::size_t top = arena_.top_mark();
    const std::size_t bottom = arena_.bottom_mark();
    auto store = crossings();
    arena_.release_top(top);
    if (!store) {
      arena_.release_bottom(bottom);
      return tl::unexpected<Error>(store.error());
    }
    const StageScope stage(Stage::kRRep, arena_, progress_, report_.peak_bytes);
    report_.pieces = drop_specks(*store, speck_voxels(), arena_);
    auto rrep = CrossingStore::sort(*store, arena_);
    if (rrep) {
      finish(*rrep);
    } else {
      arena_.release_bottom(bottom);
    }
    return rrep;
  }

 private:
  /// Smaller than this the scan cannot tell a thing from a few strays.
  std::uint64_t speck_voxels() const {
    const PrintGrid& grid = report_.placement.grid;
    const float epsilon = report_.clustering.epsilon;
    return static_cast<std::uint64_t>(kSpeck * epsilon * epsilon * epsilon /
                                      (grid.pitch_x_mm * grid.pitch_y_mm * grid.layer_height_mm));
  }

  /// What only the layers as a whole can tell.
  void finish(RRep& rrep) {
    const PrintGrid& grid = rrep.grid;
    const float epsilon2 = report_.clustering.epsilon * report_.clustering.epsilon;
    FeatureLimits limits;
    limits.pixels = static_cast<std::uint32_t>(kFeature * epsilon2 / (grid.pitch_x_mm * grid.pitch_y_mm));
    limits.voxels = static_cast<std::uint64_t>(kFeature * epsilon2 * report_.clustering.epsilon /
                                               (grid.pitch_x_mm * grid.pitch_y_mm * grid.layer_height_mm));
    // Without room for it the print is as good as the scan: no reason to refuse it.
    if (const auto features = drop_small_features(rrep, limits, arena_)) report_.features = *features;
    report_.crossings = rrep.crossings();
    // The lowest point may be a stray. What is printed stands on the plate, so the first layer is the first with a pixel.
    const std::uint32_t below = trim_below(rrep);
    report_.placement.grid.layers = rrep.grid.layers;
    report_.placement.shift[2] -= static_cast<double>(below) * grid.layer_height_mm;
  }

  Expected<CrossingStore> crossings() {
    PLUMBLINE_TRY(admit());
    PLUMBLINE_TRY(read());
    PLUMBLINE_TRY(find_clusters());
    PLUMBLINE_TRY(place_object());
    build_winding_tree();
    return shoot();
  }

  Status admit() {
    std::optional<PrintGrid> grid;
    if (settings_.placement.printer) {
      grid = panel_grid(*settings_.placement.printer, settings_.placement.layer_height_mm);
    }
    auto plan = largest_plan(arena_.available(), std::nullopt, grid, settings_.threads);
    if (!plan) return tl::unexpected<Error>(plan.error());
    report_.planned_bytes = plan->bytes;
    report_.cloud_capacity = plan->points;
    return {};
  }

  Status read() {
    const StageScope stage(Stage::kRead, arena_, progress_, report_.peak_bytes);
    const std::uint32_t capacity = report_.cloud_capacity;
    auto nodes = arena_.take_top<WindingTree::Node>(WindingTree::nodes_needed(capacity), "winding");
    if (!nodes) return tl::unexpected<Error>(nodes.error());
    winding_nodes_ = *nodes;
    auto cloud = Cloud::create(capacity, arena_);
    if (!cloud) return tl::unexpected<Error>(cloud.error());
    cloud_ = *cloud;

    const ArenaScope scope(arena_);
    auto table = arena_.take_top<std::byte>(PointThinner::table_bytes(capacity), "read");
    if (!table) return tl::unexpected<Error>(table.error());
    auto workspace = arena_.take_top<std::byte>(kReaderWorkspace, "read");
    if (!workspace) return tl::unexpected<Error>(workspace.error());
    PointThinner thinner(cloud_, *table, rotation_matrix(settings_.placement.rotation_degrees),
                         first_cell(settings_.placement));
    thinner.on_progress(
        [](void* sink, double fraction) {
          return sink == nullptr || static_cast<ProgressSink*>(sink)->advance(Stage::kRead, fraction);
        },
        progress_);
    auto summary = read_scan(source_, thinner, *workspace);
    if (!summary) return tl::unexpected<Error>(summary.error());
    report_.scan = *summary;
    report_.averaged_points = thinner.points_averaged();
    report_.thinning_cell_mm = report_.averaged_points > 0 ? thinner.cell() : 0;
    report_.cloud_points = cloud_.size;
    offset_ = thinner.offset();
    return {};
  }

  Status find_clusters() {
    const ArenaScope scope(arena_);
    std::optional<KdTree3> tree;
    {
      const StageScope stage(Stage::kTrees, arena_, progress_, report_.peak_bytes);
      auto built = KdTree3::build(cloud_.positions(), arena_, "trees");
      if (!built) return tl::unexpected<Error>(built.error());
      tree = *built;
      PLUMBLINE_TRY(cloud_.reorder(tree->order(), arena_));
      tree->adopt_order();
    }
    const auto normals = cloud_.normal.first(cloud_.size);
    if (std::any_of(normals.begin(), normals.end(), [](const PackedNormal& n) { return !n.known(); })) {
      const StageScope stage(Stage::kNormals, arena_, progress_, report_.peak_bytes);
      auto estimated = estimate_normals(cloud_, *tree, arena_);
      if (!estimated) return tl::unexpected<Error>(estimated.error());
      report_.normals_estimated = *estimated;
    }
    {
      const StageScope stage(Stage::kClustering, arena_, progress_, report_.peak_bytes);
      auto epsilon = density_epsilon(cloud_, *tree, settings_.clustering, arena_);
      if (!epsilon) return tl::unexpected<Error>(epsilon.error());
      auto result = cluster(cloud_, *tree, *epsilon, settings_.clustering, {}, arena_);
      if (!result) return tl::unexpected<Error>(result.error());
      report_.clustering = *result;
    }
    drop_noise(cloud_);
    if (!is_surface(report_.clustering, cloud_.size)) {
      return fail(ErrorCode::kNoSurface,
                  "%.*s: its %u points are no surface: most have too few neighbours that face the same way. Check the "
                  "normals of the scan, or scan it denser",
                  static_cast<int>(source_.name().size()), source_.name().data(), report_.cloud_points);
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
    report_.thinning_cell_mm *= scale;
    return {};
  }

  void build_winding_tree() {
    const StageScope stage(Stage::kWindingTree, arena_, progress_, report_.peak_bytes);
    winding_ = WindingTree::build(cloud_, report_.clustering.support_points,
                                  winding_nodes_.first(WindingTree::nodes_needed(cloud_.size)));
    report_.open_underside = winding_.set_base(lowest_rim());
  }

  /// Height of the lowest point that is not one of a few strays, mm.
  float lowest_rim() const {
    std::array<float, kStrays + 1> lowest;  // NOLINT(cppcoreguidelines-pro-type-member-init): a heap, the highest first
    std::size_t count = 0;
    for (const Vec3f& p : cloud_.positions()) {
      if (count == lowest.size() && p[2] >= lowest[0]) continue;
      if (count == lowest.size()) std::pop_heap(lowest.begin(), lowest.begin() + count--);
      lowest[count++] = p[2];
      std::push_heap(lowest.begin(), lowest.begin() + count);
    }
    return lowest[0];
  }

  Expected<CrossingStore> shoot() {
    const PrintGrid& grid = report_.placement.grid;
    std::optional<KdTree2> tree;
    BitImage interested;
    {
      const StageScope stage(Stage::kRayGrid, arena_, progress_, report_.peak_bytes);
      auto built = KdTree2::build(cloud_.positions(), arena_, "ray grid");
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
    const StageScope stage(Stage::kRays, arena_, progress_, report_.peak_bytes);
    RayField field;
    field.cloud = &cloud_;
    field.tree = &*tree;
    field.winding = &winding_;
    field.interested = interested;
    field.grid = grid;
    field.max_radius = kMaxRadiusShare * report_.clustering.epsilon *
                       std::sqrt(std::max(1.0F, report_.clustering.support_points / kMaxRadiusSupport));
    field.tile_capacity = tile_capacity(report_.cloud_capacity);
    field.settings.intersections.width = report_.width_mm;
    field.settings.repair_spacing = std::max(grid.layer_height_mm, kRepairShare * report_.clustering.epsilon);
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

  ByteSource& source_;
  const SliceSettings& settings_;
  Arena& arena_;
  ProgressSink* progress_;
  SliceReport& report_;

  Cloud cloud_;
  Vec3d offset_ = Vec3d::Zero();  ///< rotated scan coordinates of the cloud's origin
  std::span<WindingTree::Node> winding_nodes_;
  WindingTree winding_;
};

}  // namespace

Expected<RRep> slice(ByteSource& source, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                     SliceReport& report) {
  SliceSettings checked = settings;
  checked.threads = std::clamp<std::uint32_t>(settings.threads, 1, RayShooter::kMaxThreads);
  omp_set_num_threads(static_cast<int>(checked.threads));
  return Job(source, checked, arena, progress, report).run();
}

}  // namespace plumbline
