#include "slicer/inspect.hpp"

#include <omp.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/core/median.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/normals/normals.hpp"
#include "slicer/plan/scan_admission.hpp"
#include "slicer/rays/ray_shooter.hpp"

namespace plumbline {
namespace {

/// Points that are measured, evenly spread over the tree's order: the medians of a larger cloud differ by about a percent.
constexpr std::uint32_t kSample = 8192;

/// Distance of `point` from the plane through `neighbours` in the sense of least squares.
double distance_from_plane(const Vec3f& point, std::span<const Neighbour> neighbours,
                           std::span<const Vec3f> positions) {
  const auto count = static_cast<double>(neighbours.size());
  Vec3d sum = Vec3d::Zero();  // from `point`, so that nothing large cancels
  for (const Neighbour& n : neighbours) sum += (positions[n.index] - point).cast<double>();
  const Vec3d mean = sum / count;
  Mat3d scatter = Mat3d::Zero();
  for (const Neighbour& n : neighbours) {
    const Vec3d d = (positions[n.index] - point).cast<double>() - mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3d> solver(scatter);
  return std::abs(solver.eigenvectors().col(0).dot(mean));
}

class Inspection {
 public:
  Inspection(ScanSources sources, const InspectSettings& settings, Arena& arena, ProgressSink* progress,
             InspectReport& report)
      : sources_(sources), settings_(settings), arena_(arena), progress_(progress), report_(report) {}

  Status run() {
    const ArenaScope scope(arena_);
    PLUMBLINE_TRY(read());
    auto tree = build_tree();
    PLUMBLINE_TRY(tree);
    PLUMBLINE_TRY(find_normals(*tree));
    const StageScope stage(Stage::kClustering, arena_, progress_, report_.peak_bytes);
    PLUMBLINE_TRY(go_on());
    auto epsilon = density_epsilon(cloud_, *tree, settings_.clustering, arena_);
    PLUMBLINE_TRY(epsilon);
    PLUMBLINE_TRY(measure(*tree));
    PLUMBLINE_TRY(go_on());
    auto result = cluster(cloud_, *tree, *epsilon, settings_.clustering, {}, arena_, {progress_, Stage::kClustering});
    PLUMBLINE_TRY(result);
    report_.clustering = *result;
    report_.bounds_with_noise = bounds();
    if (!settings_.keep_all && result->points.surface() > 0 && result->epsilon > 0) {
      const auto strays = mark_stray_pieces(cloud_, *result, arena_);
      PLUMBLINE_TRY(strays);
      report_.strays = *strays;
    }
    cloud_.drop_noise();
    report_.bounds = cloud_.size > 0 ? bounds() : report_.bounds_with_noise;
    return {};
  }

 private:
  Status go_on() const {
    if (progress_ == nullptr || progress_->advance(Stage::kClustering, 0)) return {};
    return fail(ErrorCode::kCancelled, "stopped while the scan was inspected");
  }

  /// As slice() does, but every point is kept while there is room: no cell is wanted, and the size of a pixel in scan
  /// units may be unknown.
  Status read() {
    const StageScope stage(Stage::kRead, arena_, progress_, report_.peak_bytes);
    const PlacementSettings& placement = settings_.placement;
    std::optional<PrintGrid> panel;
    if (placement.printer) panel = panel_grid(*placement.printer, placement.layer_height_mm);
    // A confidence map, as `plumbline slice` keeps it.
    auto admission = ScanAdmission::create(arena_.available(), panel, settings_.threads, true);
    PLUMBLINE_TRY(admission);
    const CloudReadSettings reading{.rotation = rotation_matrix(placement.rotation_degrees)};
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
    report_.thinning_cell = read->cell;
    return {};
  }

  Expected<KdTree3> build_tree() {
    const StageScope stage(Stage::kTrees, arena_, progress_, report_.peak_bytes);
    auto tree = KdTree3::build(cloud_.positions(), arena_, "trees", {progress_, Stage::kTrees});
    PLUMBLINE_TRY(tree);
    PLUMBLINE_TRY(cloud_.reorder(tree->order(), arena_));
    tree->adopt_order();
    return tree;
  }

  Status find_normals(const KdTree3& tree) {
    const StageScope stage(Stage::kNormals, arena_, progress_, report_.peak_bytes);
    const auto normals = complete_normals(cloud_, tree, arena_, {progress_, Stage::kNormals});
    PLUMBLINE_TRY(normals);
    report_.normals = *normals;
    return {};
  }

  Status measure(const KdTree3& tree) {
    const ArenaScope scope(arena_);
    const std::uint32_t samples = std::min(kSample, cloud_.size);
    auto spacing = arena_.take_top<float>(samples, "clustering");
    PLUMBLINE_TRY(spacing);
    auto roughness = arena_.take_top<float>(samples, "clustering");
    PLUMBLINE_TRY(roughness);
    const auto last = static_cast<int>(samples);
#pragma omp parallel for schedule(dynamic, 64)
    for (int s = 0; s < last; ++s) {
      const auto place = static_cast<std::size_t>(s);
      const auto i = static_cast<std::uint32_t>(std::uint64_t{place} * cloud_.size / samples);
      const Vec3f& point = cloud_.position[i];
      std::array<Neighbour, kPlaneNeighbours> found = {};
      const std::uint32_t count = tree.nearest(point, found, [i](std::uint32_t other) { return other != i; });
      (*spacing)[place] = count > 0 ? std::sqrt(found[0].distance2) : 0;
      (*roughness)[place] =
          count < 3 ? 0
                    : static_cast<float>(distance_from_plane(point, std::span(found).first(count), cloud_.positions()));
    }
    report_.spacing = static_cast<double>(median(*spacing));
    report_.roughness = static_cast<double>(median(*roughness));
    return {};
  }

  /// In rotated scan coordinates.
  Box3d bounds() const {
    Box3d box;
    for (const Vec3f& p : cloud_.positions()) box.extend(p.cast<double>() + offset_);
    return box;
  }

  ScanSources sources_;
  const InspectSettings& settings_;
  Arena& arena_;
  ProgressSink* progress_;
  InspectReport& report_;
  Cloud cloud_;
  Vec3d offset_ = Vec3d::Zero();  ///< rotated scan coordinates of the cloud's origin
};

}  // namespace

Status inspect(ScanSources sources, const InspectSettings& settings, Arena& arena, ProgressSink* progress,
               InspectReport& report) {
  InspectSettings checked = settings;
  checked.threads = std::clamp<std::uint32_t>(settings.threads, 1, RayShooter::kMaxThreads);
  omp_set_num_threads(static_cast<int>(checked.threads));
  return Inspection(sources, checked, arena, progress, report).run();
}

}  // namespace plumbline
