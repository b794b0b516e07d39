#include "slicer/preparation.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/cloud/even_spacing.hpp"
#include "slicer/cloud/filled_volume.hpp"
#include "slicer/cloud/outliers.hpp"
#include "slicer/cloud/proof_sample.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/core/words/plural.hpp"
#include "slicer/mesh_slicing.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/source_checks.hpp"
#include "slicer/surface/surface_points.hpp"

namespace plumbline {
namespace {

/// The first cell of the thinning is this share of the pixel pitch or of the layer height, the smaller of the two, so that
/// no points are merged that a print could resolve.
constexpr double kCellShare = 0.5;

/// Fewest points whose neighbours are averaged. A third as many means can look like a surface even if the points lie at random.
constexpr std::uint32_t kFewestAveraged = 6000;

/// First cell of the thinning in scan units; 0 while the size of a scan unit on the print is unknown.
double first_cell(const PlacementSettings& p) {
  if (p.fit || p.size || p.units == Units::kAuto) return 0;
  return kCellShare * std::min(p.finest_pitch_mm(), static_cast<double>(p.layer_height_mm)) /
         (millimetres_per(p.units) * p.scale);
}

void rotate(PreparedScan& scan, const Mat3d& rotation) {
  for (std::uint32_t i = 0; i < scan.cloud.size; ++i) {
    Vec3f& p = scan.cloud.position[i];
    p = (rotation * p.cast<double>()).cast<float>();
    PackedNormal& n = scan.cloud.normal[i];
    const bool classified = n.point_class != PointClass::kNoise;
    n.set((rotation * n.unpack().cast<double>()).cast<float>());
    if (classified) n.point_class = orientation_of(n);
  }
  for (Vec3f& p : scan.cloud.views.scanner.first(scan.cloud.views.count))
    p = (rotation * p.cast<double>()).cast<float>();
  for (Vec3f& p : scan.sample) p = (rotation * p.cast<double>()).cast<float>();
  scan.offset = rotation * scan.offset;
  scan.turned = rotation * scan.turned;
}

/// One job, stage by stage.
class Preparation {
 public:
  Preparation(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
              PreparationReport& report)
      : sources_(sources), settings_(settings), arena_(arena), progress_(progress), report_(report) {}

  Expected<PreparedScan> run(Measurement measure, Admission admit) {
    PLUMBLINE_TRY(read());
    PLUMBLINE_TRY(admit(scan_));
    const ArenaScope trees(arena_);
    before_tree_ = arena_.top_mark();
    PLUMBLINE_TRY(settle());
    PLUMBLINE_TRY(measure_surface(measure));
    // Each time at most half of the points are left, so this ends, and takes about half as long again.
    while (blurred_ && may_average()) {
      average();
      PLUMBLINE_TRY(build_tree());
      PLUMBLINE_TRY(measure_surface(kNoMeasurement));
    }
    return scan_;
  }

  Status run_normals(NormalsLook look) {
    PLUMBLINE_TRY(read());
    PLUMBLINE_TRY(check_extent(scan_.bounds(), sources_));
    const ArenaScope trees(arena_);
    before_tree_ = arena_.top_mark();
    PLUMBLINE_TRY(settle());
    PLUMBLINE_TRY(find_normals(false));
    if (!may_average()) {
      const StageScope stage(Stage::kClustering, arena_, progress_, report_.peak_bytes);
      PLUMBLINE_TRY(cluster(FloorChoice{FloorChoice::Kind::kKeep}));
      PLUMBLINE_TRY(check_has_surface(scan_, sources_, report_, settings_.placement));
    }
    const auto samples = sample_surface(scan_.cloud, arena_);
    PLUMBLINE_TRY(samples);
    scan_.has_surface = !samples->patches.empty() && scan_.cloud.spans_area();
    look_for_volume();
    PLUMBLINE_TRY(check_has_surface(scan_, sources_, report_, settings_.placement));
    return look(scan_, *samples);
  }

 private:
  Status read() {
    const StageScope stage(Stage::kRead, arena_, progress_, report_.peak_bytes);
    const PlacementSettings& placement = settings_.placement;
    std::optional<PrintGrid> panel;
    if (placement.printer) panel = panel_grid(*placement.printer, placement.layer_height_mm);
    const std::uint32_t threads = settings_.threads;
    const std::size_t budget = arena_.available();
    PlanEvidence evidence{.confidence = settings_.confidence, .arena_bytes = budget};
    PLUMBLINE_TRY(largest_plan(budget, std::nullopt, panel, threads, evidence));
    std::size_t reading_bytes = 0;
    const CloudReadSettings reading{rotation_matrix(placement.rotation_degrees), first_cell(placement),
                                    first_cell(placement.with_units(Units::kMillimetres))};
    const auto admit = [&](const ScanAnnouncement& announced) -> Expected<std::uint32_t> {
      PLUMBLINE_TRY(check_units(sources_, placement.units, announced.some_in_mm, announced.some_in_any_unit));
      evidence.reader_bytes = announced.reader_bytes;
      evidence.kept_bytes = announced.kept_bytes;
      evidence.views = announced.most_views;
      const auto largest = largest_plan(budget, std::nullopt, panel, threads, evidence);
      PLUMBLINE_TRY(largest);
      report_.cloud_capacity = largest->points;
      const auto plan = largest_plan(budget, announced.points, panel, threads, evidence);
      PLUMBLINE_TRY(plan);
      reading_bytes = plan->of(Stage::kRead);
      return plan->points;
    };
    const auto read = read_cloud(sources_, reading, admit, arena_, progress_);
    PLUMBLINE_TRY(read);
    scan_.cloud = read->cloud;
    scan_.offset = read->offset;
    report_.scans = read->scans;
    report_.scan = sum_of(read->scans);
    PLUMBLINE_TRY(check_units(sources_, placement.units, report_));
    report_.cloud_points = read->cloud.size;
    report_.averaged_points = read->averaged;
    const CloudViews& views = read->cloud.views;
    if (!views.are_runs) report_.stated_views.count = views.count;
    report_.lengths.thinning_cell = {static_cast<float>(read->cell)};
    report_.planned_bytes = plan_memory(read->cloud.size, panel, threads, evidence).bytes;
    report_.planned_bytes[static_cast<std::size_t>(Stage::kRead)] = reading_bytes;
    return {};
  }

  Status build_tree() {
    const StageScope stage(Stage::kTrees, arena_, progress_, report_.peak_bytes);
    return build_tree({progress_, Stage::kTrees});
  }

  /// Removes outliers, and replaces what lies in lines by points as far apart as the lines need.
  Status settle() {
    const StageScope stage(Stage::kTrees, arena_, progress_, report_.peak_bytes);
    const StageProgress progress{progress_, Stage::kTrees};
    PLUMBLINE_TRY(build_tree(progress.part(0, 0.6)));
    const auto outliers = drop_outliers(scan_.cloud, *tree_, arena_, progress.part(0.6, 0.8));
    PLUMBLINE_TRY(outliers);
    report_.outliers = *outliers;
    if (*outliers > 0) PLUMBLINE_TRY(rebuild_tree(progress.part(0.8, 0.9)));
    report_.evened_points = even_out_lines(scan_.cloud, *tree_);
    return report_.evened_points > 0 ? rebuild_tree(progress.part(0.9, 1)) : Status();
  }

  /// The stages that follow.
  Status measure_surface(Measurement measure) {
    PLUMBLINE_TRY(find_normals(true));
    PLUMBLINE_TRY(align());
    return find_surface(measure);
  }

  bool may_average() const { return scan_.cloud.size >= kFewestAveraged; }

  /// Replaces neighbours by their mean: points that are noisier than their neighbourhoods are wide have no tangent planes.
  void average() {
    if (progress_ != nullptr) progress_->averages(scan_.cloud.size);
    arena_.release_top(before_tree_);
    const double before = scan_.cloud.size;
    scan_.cloud.average_neighbours();
    of_each_mean_ = before / scan_.cloud.size;
    ++report_.averagings;
    report_.upright.reset();
    if (!report_.turned) return;
    rotate(scan_, scan_.turned.transpose());  // by normals that meant nothing
    scan_.turned = Mat3d::Identity();
    report_.turned.reset();
  }

  /// Builds the tree and puts the cloud into its order.
  Status build_tree(const StageProgress& progress) {
    auto tree = KdTree3::build(scan_.cloud.positions(), arena_, "trees", progress);
    PLUMBLINE_TRY(tree);
    scan_.cloud.reorder(tree->order());
    tree_ = *tree;
    return {};
  }

  Status rebuild_tree(const StageProgress& progress) {
    arena_.release_top(before_tree_);
    return build_tree(progress);
  }

  /// @param upright  also look which way up it lies
  Status find_normals(bool upright) {
    const StageScope stage(Stage::kNormals, arena_, progress_, report_.peak_bytes);
    const auto sides = report_.scan.header.has_unsigned_normals ? NormalSides::kUnknown : NormalSides::kKnown;
    const auto normals = complete_normals(scan_.cloud, *tree_, arena_, {progress_, Stage::kNormals}, sides);
    PLUMBLINE_TRY(normals);
    report_.normals = *normals;
    report_.stated_views.scanners = scan_.cloud.views.scanners();
    return upright ? find_upright() : Status();
  }

  /// Turns the scan the best way up, if that is asked for. Else tells if it plainly lies wrong, unless somebody has turned it.
  Status find_upright() {
    if (settings_.orient) return turn();
    if (settings_.placement.rotation_degrees != Vec3d::Zero()) return {};
    const ArenaScope scope(arena_);
    const auto samples = sample_surface(scan_.cloud, arena_);
    PLUMBLINE_TRY(samples);
    report_.upright = better_upright(*samples);
    if (report_.upright && progress_ != nullptr) {
      progress_->lies_wrong(report_.upright->degrees[0], report_.upright->degrees[1]);
    }
    return {};
  }

  Status turn() {
    const auto best = best_way_up(scan_.cloud, arena_, {progress_, Stage::kNormals});
    PLUMBLINE_TRY(best);
    report_.turned = *best;
    rotate(scan_, rotation_matrix({best->degrees[0], best->degrees[1], 0}));
    return rebuild_tree({progress_, Stage::kNormals});
  }

  Status align() {
    const StageScope stage(Stage::kViews, arena_, progress_, report_.peak_bytes);
    const StageProgress progress{progress_, Stage::kViews};
    const auto views = register_views(scan_.cloud, *tree_, arena_, progress.part(0, 0.85));
    PLUMBLINE_TRY(views);
    // Until here there was room for the most views. Now it is known how many there are.
    if (report_.averagings == 0) {
      report_.planned_bytes[static_cast<std::size_t>(Stage::kViews)] = arena_.used() + views_stage_bytes(views->views);
    }
    report_.lengths.views_before = {views->before};
    report_.lengths.views_after = {views->after};
    report_.lengths.views_moved = {views->moved};
    return views->moved > 0 ? rebuild_tree(progress.part(0.85, 1)) : Status();
  }

  Status find_surface(Measurement measure) {
    const StageScope stage(Stage::kClustering, arena_, progress_, report_.peak_bytes);
    PLUMBLINE_TRY(measure(scan_, *tree_));
    FloorChoice floor = settings_.floor;
    floor.height -= scan_.offset[2];
    if (sample_room_.empty()) PLUMBLINE_TRY(arena_.take_bottom(sample_room_, proof_points(scan_.cloud.size), "proof"));
    scan_.sample = sample_room_.first(std::min<std::size_t>(sample_room_.size(), proof_points(scan_.cloud.size)));
    const auto surface = cluster(floor);
    PLUMBLINE_TRY(surface);
    Cloud& cloud = scan_.cloud;
    if (blurred_) {
      if (may_average()) return {};
      cloud.drop_noise();
      report_.averagings = 0;
    }
    report_.clustering = surface->clustering;
    report_.support_points = cloud.support_points;
    report_.strays = surface->strays;
    report_.flying_points = surface->flying_points;
    if (surface->floor_points > 0) level(*surface);
    report_.lengths.epsilon = {surface->clustering.epsilon};
    report_.lengths.noise = {surface->clustering.noise};
    if (report_.averagings > 0) {
      // As long as noise is wider than the groups, means are as noisy as points: only the last averaging has made it less.
      report_.lengths.averaged_noise = {surface->clustering.noise * static_cast<float>(std::sqrt(of_each_mean_))};
    }
    return {};
  }

  /// Keeps the points of the surface, and tells whether there is one.
  /// @param floor  its height in coordinates of the cloud
  Expected<SurfacePoints> cluster(const FloorChoice& floor) {
    const bool estimated = report_.normals.estimated > scan_.cloud.size / 2;
    const SurfaceSettings settings{.normals = estimated ? NormalSource::kPoints : NormalSource::kScanner,
                                   .keep_strays = settings_.keep_all,
                                   .averaged = report_.averagings > 0,
                                   .may_average = may_average(),
                                   .floor = floor,
                                   .sample = scan_.sample};
    auto surface = find_surface_points(scan_.cloud, *tree_, settings, arena_, {progress_, Stage::kClustering});
    PLUMBLINE_TRY(surface);
    scan_.sample = scan_.sample.first(surface->sampled);
    blurred_ = surface->blurred;
    scan_.has_surface = !blurred_ && surface->found() && scan_.cloud.spans_area();
    look_for_volume();
    return surface;
  }

  /// Where there is no surface, tells whether the scan's points, before any are averaged, fill a volume.
  void look_for_volume() {
    if (!scan_.has_surface && !spread_) spread_ = point_spread(scan_.cloud, *tree_);
    report_.fills_volume = !scan_.has_surface && spread_->fills_volume();
  }

  /// Turns the scan until the floor that was cut off is level.
  void level(const SurfacePoints& surface) {
    const Vec3d up = surface.floor->normal.cast<double>();
    const Vec3d middle = scan_.cloud.size > 0 ? Vec3d(scan_.cloud.bounds().centre().cast<double>()) : Vec3d::Zero();
    const double across = up[0] * middle[0] + up[1] * middle[1];
    report_.floor.points = surface.floor_points;
    report_.floor.height = (static_cast<double>(surface.floor->offset) - across) / up[2] + scan_.offset[2];
    report_.floor.size = surface.floor_box.size().cast<double>();
    report_.floor.tilt = std::sqrt(surface.floor->normal[0] * surface.floor->normal[0] +
                                   surface.floor->normal[1] * surface.floor->normal[1]);
    scan_.floor = surface.floor->offset;
    if (report_.floor.tilt > 0) rotate(scan_, levelling(up));
  }

  ScanSources sources_;
  const SliceSettings& settings_;
  Arena& arena_;
  ProgressSink* progress_;
  PreparationReport& report_;
  PreparedScan scan_;
  std::optional<KdTree3> tree_;
  std::optional<PointSpread> spread_;  ///< see look_for_volume()
  std::span<Vec3f> sample_room_;       ///< of PreparedScan::sample
  std::size_t before_tree_ = 0;
  bool blurred_ = false;     ///< SurfacePoints::blurred
  double of_each_mean_ = 1;  ///< points, when neighbours were averaged last
};

}  // namespace

ScanLengths<Millimetre> in_mm(const ScanLengths<ScanUnit>& lengths, ScanScale scale) {
  return {.thinning_cell = scale(lengths.thinning_cell),
          .epsilon = scale(lengths.epsilon),
          .noise = scale(lengths.noise),
          .views_before = scale(lengths.views_before),
          .views_after = scale(lengths.views_after),
          .views_moved = scale(lengths.views_moved),
          .averaged_noise = scale(lengths.averaged_noise)};
}

Box3d PreparedScan::bounds() const {
  Box3f local = cloud.bounds();
  if (floor) local.low[2] = std::min(*floor, local.high[2]);
  return in_scan(local);
}

Box3d PreparedScan::in_scan(const Box3f& local) const {
  Box3d box;
  box.extend(local.low.cast<double>() + offset);
  box.extend(local.high.cast<double>() + offset);
  return box;
}

Expected<PreparedScan> prepare(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                               PreparationReport& report, Measurement measure, Admission admit) {
  return Preparation(sources, settings, arena, progress, report).run(measure, admit);
}

Status prepare_normals(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                       PreparationReport& report, NormalsLook look) {
  const auto of_mesh = [&](MeshFiles& files, const MeshSurvey& survey, ScanSources) -> Status {
    const auto cloud = mesh_cloud(files, survey, arena, progress, report);
    files.drop_copy(arena);
    PLUMBLINE_TRY(cloud);
    PreparedScan prepared;
    prepared.cloud = *cloud;
    prepared.offset = survey.bounds.low;
    const auto samples = sample_surface(prepared.cloud, arena);
    PLUMBLINE_TRY(samples);
    return look(prepared, *samples);
  };
  const auto of_scan = [&](ScanSources given) {
    return Preparation(given, settings, arena, progress, report).run_normals(look);
  };
  return read_mesh_or_scan(sources, settings, arena, progress, report, of_mesh, of_scan);
}

Status check_surface(const PreparedScan& scan, ScanSources sources, const PreparationReport& found,
                     const PlacementSettings& settings) {
  if (scan.cloud.size > 0) {
    PLUMBLINE_TRY(check_no_speck(scan.bounds(), sources, settings, found.scan.header.is_in_mm));
  }
  if (found.floor.points > 0 && scan.cloud.size == 0) {
    return telling(Told(ToldCode::kBelowFloor, {{Fact::kFloor, found.floor.height}}),
                   fail(ErrorCode::kNoSurface,
                        "%s: all of the scan is below the floor, at height %.5g.\tUse a lower floor, or keep it",
                        title_of(sources).c_str(), found.floor.height));
  }
  return check_has_surface(scan, sources, found, settings);
}

Status check_has_surface(const PreparedScan& scan, ScanSources sources, const PreparationReport& found,
                         const PlacementSettings& settings) {
  if (scan.has_surface) return {};
  const ScanTitle title = title_of(sources);
  const auto points = static_cast<unsigned long long>(found.scan.points);
  if (found.fills_volume) {
    return telling(Told(ToldCode::kVolumeFilled, {{Fact::kPoints, points}}),
                   fail(ErrorCode::kNoSurface,
                        "%s: its %llu points fill the object, as from CT, and are not on its surface.\tExport its "
                        "surface, as a mesh or as points",
                        title.c_str(), points));
  }
  // Cells that have grown from the first size show that the arena was too small. Else the points lie closer than pixels.
  const bool grown = static_cast<double>(found.lengths.thinning_cell.value) > 1.01 * first_cell(settings);
  if (grown && found.cloud_capacity < points && found.cloud_points < points) {
    return telling(
        Told(ToldCode::kSurfaceNotFound, {{Fact::kPoints, found.cloud_points}}),
        fail(ErrorCode::kNoSurface,
             "%s: no surface found in %u point%s, to which %llu were thinned because the arena has no room for more.\t"
             "Use a larger arena, or check the normals of the scan",
             title.c_str(), found.cloud_points, plural_s(found.cloud_points), points));
  }
  return telling(
      Told(ToldCode::kSurfaceNotFound, {{Fact::kPoints, points}}),
      fail(ErrorCode::kNoSurface,
           "%s: no surface found in %llu point%s: most have too few neighbours that face the same way.\tCheck the "
           "normals of the scan, or scan more densely",
           title.c_str(), points, plural_s(points)));
}

void move_to_print(const Placement& placement, PreparedScan& scan, const PreparationReport& found,
                   SliceReport& report) {
  const double scale = placement.scale;
  const Vec3d shift = scan.offset * scale + placement.shift;
  Cloud& cloud = scan.cloud;
  const auto move = [&](Vec3f& p) { p = (p.cast<double>() * scale + shift).cast<float>(); };
  std::ranges::for_each(cloud.position.first(cloud.size), move);
  std::ranges::for_each(scan.sample, move);
  report.sample = scan.sample;
  for (float& r : cloud.radius.first(cloud.size)) r *= static_cast<float>(scale);
  report.placement = placement;
  report.placement.rotation = scan.turned * placement.rotation;
  if (scan.floor) report.floor_mm = static_cast<float>(static_cast<double>(*scan.floor) * scale + shift[2]);
  report.lengths = in_mm(found.lengths, ScanScale(scale));
}

}  // namespace plumbline
