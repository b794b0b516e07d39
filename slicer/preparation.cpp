#include "slicer/preparation.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/cloud/even_spacing.hpp"
#include "slicer/cloud/filled_volume.hpp"
#include "slicer/cloud/outliers.hpp"
#include "slicer/cloud/proof_sample.hpp"
#include "slicer/core/resin/outline_move.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/core/words/plural.hpp"
#include "slicer/mesh_slicing.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/source_checks.hpp"
#include "slicer/surface/surface_points.hpp"
#include "slicer/ways_up.hpp"

namespace plumbline::inline slicer {
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

/// The tree of a scan's points at the top of the arena. Its end releases all that was taken there since its beginning.
class ScanTree {
 public:
  explicit ScanTree(Arena& arena) : arena_(arena), scope_(arena), mark_(arena.top_mark()) {}
  void release() { arena_.release_top(mark_); }
  /// Builds it anew, since points have moved, and puts the cloud into its order.
  Status build(Cloud& cloud, const StageProgress& progress) {
    release();
    auto tree = KdTree3::build(cloud.positions(), arena_, "trees", progress);
    PLUMBLINE_TRY(tree);
    cloud.reorder(tree->order());
    tree_ = *tree;
    return {};
  }
  const KdTree3& operator*() const { return *tree_; }

 private:
  Arena& arena_;
  ArenaScope scope_;
  std::size_t mark_;
  std::optional<KdTree3> tree_;
};

bool may_average(const Cloud& cloud) { return cloud.size >= kFewestAveraged; }

/// Removes outliers, and replaces what lies in lines by points as far apart as the lines need.
Expected<SettledCounts> settle(Cloud& cloud, ScanTree& tree, const StageContext& job) {
  const StageScope stage(Stage::kTrees, job);
  const StageProgress progress{job.progress, Stage::kTrees};
  PLUMBLINE_TRY(tree.build(cloud, progress.part(0, 0.6)));
  const auto outliers = drop_outliers(cloud, *tree, job.arena, progress.part(0.6, 0.8));
  PLUMBLINE_TRY(outliers);
  if (*outliers > 0) PLUMBLINE_TRY(tree.build(cloud, progress.part(0.8, 0.9)));
  const std::uint32_t evened = even_out_lines(cloud, *tree);
  if (evened > 0) PLUMBLINE_TRY(tree.build(cloud, progress.part(0.9, 1)));
  return SettledCounts{*outliers, evened};
}

/// Completes the normals.
/// @param orient  also turn the scan the best way up, if that is asked for. Else tell if it plainly lies wrong, unless somebody has turned it
Expected<FoundNormals> find_normals(PreparedScan& scan, ScanTree& tree, const SliceSettings& settings, bool orient,
                                    const StageContext& job) {
  const StageScope stage(Stage::kNormals, job);
  const StageProgress progress{job.progress, Stage::kNormals};
  const auto sides = scan.counts.scan.header.has_unsigned_normals ? NormalSides::kUnknown : NormalSides::kKnown;
  const auto counts = complete_normals(scan.cloud, *tree, job.arena, progress, sides);
  PLUMBLINE_TRY(counts);
  FoundNormals found{*counts, {}, {}};
  if (orient && settings.orient) {
    SliceSettings turning = settings;
    turning.placement = heed_header(settings.placement, scan.counts.scan.header);
    const auto best = best_way_up(scan.cloud, turning, job.arena, progress);
    PLUMBLINE_TRY(best);
    found.turned = *best;
    rotate(scan, rotation_matrix({best->degrees[0], best->degrees[1], 0}));
    PLUMBLINE_TRY(tree.build(scan.cloud, progress));
  } else if (orient && settings.placement.rotation_degrees == Vec3d::Zero()) {
    const ArenaScope scope(job.arena);
    const auto samples = sample_surface(scan.cloud, job.arena);
    PLUMBLINE_TRY(samples);
    found.upright = better_upright(*samples);
    if (const auto& way = found.upright; way && job.progress != nullptr) {
      job.progress->lies_wrong(way->degrees[0], way->degrees[1]);
    }
  }
  return found;
}

/// Moves the views so that they agree.
Expected<Registration> align(Cloud& cloud, ScanTree& tree, const StageContext& job) {
  const StageScope stage(Stage::kViews, job);
  const StageProgress progress{job.progress, Stage::kViews};
  const auto views = register_views(cloud, *tree, job.arena, progress.part(0, 0.85));
  PLUMBLINE_TRY(views);
  if (views->moved > 0) PLUMBLINE_TRY(tree.build(cloud, progress.part(0.85, 1)));
  return views;
}

/// Where there is no surface, finds out whether the scan's points fill a volume.
void look_for_volume(PreparedScan& scan, const KdTree3& tree) {
  if (!scan.has_surface && !scan.fills_volume) scan.fills_volume = point_spread(scan.cloud, tree).fills_volume();
}

/// Keeps the points of the surface, and sets whether there is one.
Expected<SurfacePoints> find_surface(PreparedScan& scan, const KdTree3& tree, const SurfaceSettings& settings,
                                     const StageContext& job) {
  const auto surface = find_surface_points(scan.cloud, tree, settings, job.arena, {job.progress, Stage::kClustering});
  PLUMBLINE_TRY(surface);
  scan.sample = settings.sample.first(surface->sampled);
  scan.has_surface = !surface->blurred && surface->found() && scan.cloud.spans_area();
  look_for_volume(scan, tree);
  return surface;
}

/// Where the normals of most points come from.
NormalSource source_of(const NormalCounts& normals, const Cloud& cloud) {
  return normals.estimated > cloud.size / 2 ? NormalSource::kPoints : NormalSource::kScanner;
}

/// Replaces neighbours by their mean: points that are noisier than their neighbourhoods are wide have no tangent planes.
/// @returns points of each mean
double average(PreparedScan& scan, ProgressSink* progress) {
  const std::uint32_t before = scan.cloud.size;
  if (progress != nullptr) progress->averages(before);
  scan.cloud.average_neighbours();
  if (scan.turned != Mat3d::Identity()) rotate(scan, scan.turned.transpose());  // by normals that meant nothing
  scan.turned = Mat3d::Identity();
  return static_cast<double>(before) / scan.cloud.size;
}

/// Turns the scan until the floor that was cut off is level.
FloorCut level(PreparedScan& scan, const SurfacePoints& surface) {
  if (!surface.floor || surface.floor_points == 0) return {};
  const FloorPlane& floor = *surface.floor;
  const Vec3d up = floor.normal.cast<double>();
  const Vec3d middle = scan.cloud.size > 0 ? Vec3d(scan.cloud.bounds().centre().cast<double>()) : Vec3d::Zero();
  const double across = up[0] * middle[0] + up[1] * middle[1];
  const FloorCut cut{.points = surface.floor_points,
                     .height = (static_cast<double>(floor.offset) - across) / up[2] + scan.offset[2],
                     .size = surface.floor_box.size().cast<double>(),
                     .tilt = std::sqrt(floor.normal[0] * floor.normal[0] + floor.normal[1] * floor.normal[1])};
  scan.floor = floor.offset;
  if (cut.tilt > 0) rotate(scan, levelling(up));
  return cut;
}

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

Box3d ReadScan::bounds() const {
  Box3f local = cloud.bounds();
  if (floor) local.low[2] = std::min(*floor, local.high[2]);
  return in_scan(local);
}

Box3d ReadScan::in_scan(const Box3f& local) const {
  Box3d box;
  box.extend(local.low.cast<double>() + offset);
  box.extend(local.high.cast<double>() + offset);
  return box;
}

std::optional<Vec3d> extent_as_it_came(const PreparedScan& scan, const SliceSettings& settings,
                                       const std::optional<Orientation>& turned) {
  const Vec3d degrees = turned ? Vec3d(turned->degrees[0], turned->degrees[1], 0) : settings.placement.rotation_degrees;
  if (degrees == Vec3d::Zero() || scan.cloud.size == 0) return std::nullopt;
  const Mat3d back = rotation_matrix(degrees).transpose();
  Box3d box;
  const auto extend = [&](const Vec3f& p) { box.extend(Vec3d(back * p.cast<double>())); };
  const auto positions = scan.cloud.positions();
  std::ranges::for_each(positions, extend);
  if (scan.floor) {
    Vec3f foot = *std::ranges::min_element(positions, {}, [](const Vec3f& p) { return p[2]; });
    foot[2] = std::min(foot[2], *scan.floor);
    extend(foot);
  }
  return box.size();
}

Expected<ReadScan> read_points(ScanSources sources, const SliceSettings& settings, const StageContext& job,
                               PreparationReport& report) {
  const StageScope stage(Stage::kRead, job);
  const PlacementSettings& placement = settings.placement;
  std::optional<PrintGrid> panel;
  if (placement.printer) panel = panel_grid(*placement.printer, placement.layer_height_mm);
  const std::uint32_t threads = settings.threads;
  const std::size_t budget = job.arena.available();
  PlanEvidence evidence{.confidence = settings.confidence, .grey = settings.grey, .arena_bytes = budget};
  PLUMBLINE_TRY(largest_plan(budget, std::nullopt, panel, threads, evidence));
  ReadScan scan;
  std::size_t reading_bytes = 0;
  const CloudReadSettings reading{rotation_matrix(placement.rotation_degrees), first_cell(placement),
                                  first_cell(placement.with_units(Units::kMillimetres))};
  const auto admit = [&](const ScanAnnouncement& announced) -> Expected<std::uint32_t> {
    PLUMBLINE_TRY(check_units(sources, placement.units, announced.some_in_mm, announced.some_in_any_unit));
    evidence.reader_bytes = announced.reader_bytes;
    evidence.kept_bytes = announced.kept_bytes;
    evidence.views = announced.most_views;
    const auto largest = largest_plan(budget, std::nullopt, panel, threads, evidence);
    PLUMBLINE_TRY(largest);
    scan.counts.cloud_capacity = largest->points;
    const auto plan = largest_plan(budget, announced.points, panel, threads, evidence);
    PLUMBLINE_TRY(plan);
    reading_bytes = plan->of(Stage::kRead);
    return plan->points;
  };
  const auto read = read_cloud(sources, reading, admit, job.arena, job.progress);
  PLUMBLINE_TRY(read);
  const auto ignored = check_units(sources, placement.units, read->scans);
  PLUMBLINE_TRY(ignored);
  scan.cloud = read->cloud;
  scan.offset = read->offset;
  scan.lengths.thinning_cell = {static_cast<float>(read->cell)};
  scan.counts.scan = sum_of(read->scans);
  scan.counts.scans = read->scans;
  scan.counts.ignored_units = *ignored;
  scan.counts.cloud_points = read->cloud.size;
  scan.counts.averaged_points = read->averaged;
  job.memory.planned_bytes = plan_memory(read->cloud.size, panel, threads, evidence).bytes;
  job.memory.planned(Stage::kRead) = reading_bytes;
  static_cast<ReadCounts&>(report) = scan.counts;
  if (!scan.cloud.views.are_runs) report.stated_views.count = scan.cloud.views.count;
  return scan;
}

Expected<PreparedScan> prepare(const ReadScan& read, const SliceSettings& settings, const StageContext& job,
                               PreparationReport& report, Measurement measure) {
  PreparedScan scan{read};
  Cloud& cloud = scan.cloud;
  ScanTree tree(job.arena);
  const auto settled = settle(cloud, tree, job);
  PLUMBLINE_TRY(settled);
  static_cast<SettledCounts&>(report) = *settled;
  std::span<Vec3f> sample;  // room for PreparedScan::sample
  std::uint32_t averagings = 0;
  double of_each_mean = 1;  // points, when neighbours were averaged last
  // Each time at most half of the points are left, so this ends, and takes about half as long again.
  while (true) {
    const auto normals = find_normals(scan, tree, settings, true, job);
    PLUMBLINE_TRY(normals);
    static_cast<FoundNormals&>(report) = *normals;
    report.stated_views.scanners = cloud.views.scanners();
    const auto views = align(cloud, tree, job);
    PLUMBLINE_TRY(views);
    // Until here there was room for the most views. Now it is known how many there are.
    if (averagings == 0) job.memory.planned(Stage::kViews) = job.arena.used() + views_stage_bytes(views->views);
    scan.lengths.views_before = {views->before};
    scan.lengths.views_after = {views->after};
    scan.lengths.views_moved = {views->moved};
    const auto surface = [&]() -> Expected<SurfacePoints> {
      const StageScope stage(Stage::kClustering, job);
      if (averagings == 0) {
        PLUMBLINE_TRY(measure(scan, *tree));
        PLUMBLINE_TRY(job.arena.take_bottom(sample, proof_points(cloud.size), "proof"));
      }
      const std::size_t sampled = std::min<std::size_t>(sample.size(), proof_points(cloud.size));
      return find_surface(scan, *tree,
                          {.normals = source_of(normals->normals, cloud),
                           .keep_strays = settings.keep_all,
                           .averaged = averagings > 0,
                           .may_average = may_average(cloud),
                           .floor = {settings.floor.kind, settings.floor.height - scan.offset[2]},
                           .sample = sample.first(sampled)},
                          job);
    }();
    PLUMBLINE_TRY(surface);
    if (surface->blurred && may_average(cloud)) {
      tree.release();
      of_each_mean = average(scan, job.progress);
      report.averagings = ++averagings;
      const StageScope stage(Stage::kTrees, job);
      PLUMBLINE_TRY(tree.build(cloud, {job.progress, Stage::kTrees}));
      continue;
    }
    if (surface->blurred) {
      cloud.drop_noise();
      report.averagings = averagings = 0;
    }
    scan.surface = {surface->clustering, level(scan, *surface), surface->flying_points, surface->strays};
    static_cast<SurfaceCounts&>(report) = scan.surface;
    scan.lengths.epsilon = {surface->clustering.epsilon};
    scan.lengths.noise = {surface->clustering.noise};
    if (averagings > 0) {
      // As long as noise is wider than the groups, means are as noisy as points: only the last averaging has made it less.
      scan.lengths.averaged_noise = {surface->clustering.noise * static_cast<float>(std::sqrt(of_each_mean))};
    }
    return scan;
  }
}

Status prepare_normals(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                       PreparationReport& report, NormalsLook look) {
  const StageContext job{arena, progress, report};
  const auto of_mesh = [&](MeshFiles& files, const SurveyedMesh& mesh, ScanSources given) -> Status {
    note(mesh, report);
    const auto cloud = mesh_cloud(files, mesh.survey, job);
    files.drop_copy(arena);
    PLUMBLINE_TRY(cloud);
    PreparedScan prepared;
    prepared.cloud = *cloud;
    prepared.offset = mesh.survey.bounds.low;
    const auto samples = sample_surface(prepared.cloud, arena);
    PLUMBLINE_TRY(samples);
    if (samples->patches.empty()) {
      return telling(
          Told(ToldCode::kNoTriangles),
          fail(ErrorCode::kNoSurface,
               "%s: its %llu triangle%s no area: the corners of each lie on a line.\tExport it again, as the "
               "surface of an object",
               title_of(given).c_str(), static_cast<unsigned long long>(mesh.survey.triangles),
               mesh.survey.triangles == 1 ? " has" : "s have"));
    }
    return look(prepared, *samples);
  };
  const auto of_scan = [&](ScanSources given) -> Status {
    const auto read = read_points(given, settings, job, report);
    PLUMBLINE_TRY(read);
    PLUMBLINE_TRY(check_extent(read->bounds(), given));
    PreparedScan scan{*read};
    ScanTree tree(arena);
    const auto settled = settle(scan.cloud, tree, job);
    PLUMBLINE_TRY(settled);
    static_cast<SettledCounts&>(report) = *settled;
    const auto normals = find_normals(scan, tree, settings, false, job);
    PLUMBLINE_TRY(normals);
    static_cast<FoundNormals&>(report) = *normals;
    if (!may_average(scan.cloud)) {
      const StageScope stage(Stage::kClustering, job);
      const SurfaceSettings wanted{.normals = source_of(normals->normals, scan.cloud),
                                   .keep_strays = settings.keep_all,
                                   .floor = FloorChoice{FloorChoice::Kind::kKeep}};
      PLUMBLINE_TRY(find_surface(scan, *tree, wanted, job));
      PLUMBLINE_TRY(check_has_surface(scan, given, settings.placement));
    }
    const auto samples = sample_surface(scan.cloud, arena);
    PLUMBLINE_TRY(samples);
    scan.has_surface = !samples->patches.empty() && scan.cloud.spans_area();
    look_for_volume(scan, *tree);
    PLUMBLINE_TRY(check_has_surface(scan, given, settings.placement));
    return look(scan, *samples);
  };
  return read_mesh_or_scan(sources, settings, job, of_mesh, of_scan);
}

Status check_surface(const PreparedScan& scan, ScanSources sources, const PlacementSettings& settings) {
  if (scan.cloud.size > 0) PLUMBLINE_TRY(check_no_speck(scan.bounds(), sources, settings, scan.counts.scan.header));
  const FloorCut& floor = scan.surface.floor;
  if (floor.points > 0 && scan.cloud.size == 0) {
    return telling(Told(ToldCode::kBelowFloor, {{Fact::kFloor, floor.height}}),
                   fail(ErrorCode::kNoSurface,
                        "%s: all of the scan is below the floor, at height %.5g.\tUse a lower floor, or keep it",
                        title_of(sources).c_str(), floor.height));
  }
  return check_has_surface(scan, sources, settings);
}

Status check_has_surface(const PreparedScan& scan, ScanSources sources, const PlacementSettings& settings) {
  if (scan.has_surface) return {};
  const ScanTitle title = title_of(sources);
  const ReadCounts& read = scan.counts;
  const auto points = static_cast<unsigned long long>(read.scan.points);
  if (*scan.fills_volume) {
    return telling(Told(ToldCode::kVolumeFilled, {{Fact::kPoints, points}}),
                   fail(ErrorCode::kNoSurface,
                        "%s: its %llu points fill the object, as from CT, and are not on its surface.\tExport its "
                        "surface, as a mesh or as points",
                        title.c_str(), points));
  }
  // Cells that have grown from the first size show that the arena was too small. Else the points lie closer than pixels.
  const double first = first_cell(heed_header(settings, read.scan.header));
  const bool grown = static_cast<double>(scan.lengths.thinning_cell.value) > 1.01 * first;
  if (grown && read.cloud_capacity < points && read.cloud_points < points) {
    return telling(
        Told(ToldCode::kSurfaceNotFound, {{Fact::kPoints, read.cloud_points}}),
        fail(ErrorCode::kNoSurface,
             "%s: no surface found in %u point%s, to which %llu were thinned because the arena has no room for more.\t"
             "Use a larger arena, or check the normals of the scan",
             title.c_str(), read.cloud_points, plural_s(read.cloud_points), points));
  }
  return telling(
      Told(ToldCode::kSurfaceNotFound, {{Fact::kPoints, points}}),
      fail(ErrorCode::kNoSurface,
           "%s: no surface found in %llu point%s: most have too few neighbours that face the same way.\tCheck the "
           "normals of the scan, or scan more densely",
           title.c_str(), points, plural_s(points)));
}

PlacedScan move_to_print(const Placement& placement, const PreparedScan& scan, double outline_mm) {
  const double scale = placement.scale;
  const Vec3d shift = scan.offset * scale + placement.shift;
  PlacedScan placed{.cloud = scan.cloud,
                    .placement = placement,
                    .lengths = in_mm(scan.lengths, ScanScale(scale)),
                    .sample = scan.sample,
                    .classes = scan.surface.clustering.points,
                    .read_points = scan.counts.cloud_points};
  placed.placement.rotation = scan.turned * placement.rotation;
  if (scan.floor) placed.floor = static_cast<float>(static_cast<double>(*scan.floor) * scale + shift[2]);
  const auto move = [&](Vec3f& p) { p = (p.cast<double>() * scale + shift).cast<float>(); };
  std::ranges::for_each(scan.cloud.position.first(scan.cloud.size), move);
  std::ranges::for_each(scan.sample, move);
  if (const auto by = static_cast<float>(outline_mm); std::abs(by) > 0) {
    for (std::uint32_t i = 0; i < scan.cloud.size; ++i) {
      scan.cloud.position[i] += outline_move(scan.cloud.normal[i].unpack(), by);
    }
  }
  for (float& r : scan.cloud.radius.first(scan.cloud.size)) r *= static_cast<float>(scale);
  return placed;
}

}  // namespace plumbline::inline slicer
