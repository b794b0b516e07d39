#include "slicer/surface/surface_points.hpp"

#include <algorithm>
#include <bitset>

#include "slicer/cloud/proof_sample.hpp"
#include "slicer/surface/flying_points.hpp"
#include "slicer/surface/sparse_surface.hpp"
#include "slicer/surface/surface_class.hpp"

namespace plumbline::inline slicer {
namespace {

/// Where most points are outliers, or all are means, the rest is a surface if it has this share of core points. A surface has 0.5 or more,
/// a figure's fingers among outliers 0.37. Outliers that happen to face the same way are mostly of mixed type: 0.1, in a ball 0.26; so are
/// means of random points, which lie like a lattice, 0.28, and the struts of one, 0.25.
constexpr double kLeastCoreShare = 0.3;

// Noise wider than neighbourhoods: points fill these, so their height over the planes of the others is that of a filled ball, .15 to .2
// epsilon, and more points than outliers explain have too few neighbours that face their way. Scans that are not averaged have a surface
// of which either holds, but not both: dirty ones .1 epsilon and 95 %, surfaces among as many outliers .11 and 49 %, `baron` .17 and all. Figures: slicer/EXPERIMENTS.md.
constexpr float kThickNoise = 0.14F;  ///< of epsilon
constexpr double kSheetShare = 0.95;  ///< of a scan's points, on the surface
constexpr double kMeansShare = 0.97;  ///< of means of points: they have fewer outliers

/// Whether neighbours are to be averaged, or, where they have been, there is still no surface.
bool is_blurred(const ClusteringResult& found, const SurfaceSettings& settings) {
  const double all = found.points.all();
  const double kept = found.points.surface();
  const bool is_sheet = (found.coherent || !settings.averaged) && found.core_points >= kLeastCoreShare * kept;
  if (!is_sheet) return settings.averaged;
  const double share = settings.averaged ? kMeansShare : kSheetShare;
  return settings.may_average && kept < share * all && found.noise > kThickNoise * found.epsilon;
}

Status refine(Cloud& cloud, const KdTree3& tree, const SurfaceSettings& settings, const ClusteringResult& clustering,
              Arena& arena, const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto refined = arena.take_top<PackedNormal>(cloud.size, "normals");
  PLUMBLINE_TRY(refined);
  PLUMBLINE_TRY(refine_normals(cloud, tree, clustering, settings.normals, *refined, progress));
  std::copy(refined->begin(), refined->end(), cloud.normal.begin());
  return {};
}

template <class Visit>
void for_each_kept(const Cloud& cloud, Visit visit) {
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (cloud.is_surface(i)) visit(i);
  }
}

std::optional<FloorPlane> floor_of(const Cloud& cloud, const SurfaceSettings& settings,
                                   const ClusteringResult& clustering) {
  const FloorChoice& choice = settings.floor;
  switch (choice.kind) {
    case FloorChoice::Kind::kKeep: return std::nullopt;
    case FloorChoice::Kind::kAuto:
      return find_floor(cloud, clustering.epsilon, clustering.noise, settings.normals == NormalSource::kScanner);
    case FloorChoice::Kind::kHeight: break;
  }
  FloorPlane plane;
  plane.offset = static_cast<float>(choice.height);
  return plane;
}

/// Turns everything over if what stands on the floor faces inwards. A floor larger than its object has most of the flux by which
/// estimated normals got their side, so it may have turned the object inside out.
///
///   sum_i <a_i n_i, p_i - o> = 3 V    (divergence theorem, o on the floor, V the volume between object and floor)
///
/// o lies below the object's middle, where what was not seen of it matters least.
void face_outwards(Cloud& cloud, const FloorPlane& floor) {
  Vec3d middle = Vec3d::Zero();
  Vec3d sum = Vec3d::Zero();
  double flux = 0;
  double area = 0;
  for_each_kept(cloud, [&](std::uint32_t i) {
    const double share = static_cast<double>(cloud.radius[i]) * static_cast<double>(cloud.radius[i]);
    const Vec3d vector = share * cloud.normal[i].unpack().cast<double>();
    const Vec3d p = cloud.position[i].cast<double>();
    flux += vector.dot(p);
    sum += vector;
    middle += share * p;
    area += share;
  });
  if (!(area > 0)) return;
  middle /= area;
  const Vec3d up = floor.normal.cast<double>();
  const Vec3d foot = middle - (up.dot(middle) - static_cast<double>(floor.offset)) * up;
  if (flux - sum.dot(foot) >= 0) return;
  for_each_kept(cloud, [&](std::uint32_t i) {
    cloud.normal[i].turn_over();
    cloud.normal[i].point_class = orientation_of(cloud.normal[i]);
  });
}

/// Looks for a floor and marks it and what is below it as noise.
void cut_floor(Cloud& cloud, const SurfaceSettings& settings, SurfacePoints& surface) {
  surface.floor = floor_of(cloud, settings, surface.clustering);
  if (!surface.floor) return;
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    PackedNormal& normal = cloud.normal[i];
    if (!cloud.is_surface(i) || !surface.floor->cuts(cloud.position[i])) continue;
    normal.point_class = PointClass::kNoise;
    ++surface.floor_points;
    surface.floor_box.extend(cloud.position[i]);
  }
  if (settings.normals == NormalSource::kPoints) face_outwards(cloud, *surface.floor);
}

/// Points of the scan, against which the R-Rep is proven. What clustering takes for noise is among them, since it may be wrong there. What is
/// left out on purpose, and told, is not: a floor, stray pieces, flying points.
class ProofSample {
 public:
  /// Call it when clustering has found what is noise.
  /// @param room  for the points; as many as it has room for are taken
  ProofSample(const Cloud& cloud, std::span<Vec3f> room) : cloud_(cloud), room_(room) {
    for (std::uint32_t k = 0; k < count(); ++k) was_surface_[k] = cloud.is_surface(cloud.sampled(k, count()));
  }

  /// Call it when everything that is left out has been marked as noise.
  /// @returns how many points there are in the room
  std::uint32_t keep(const std::optional<FloorPlane>& floor) {
    std::uint32_t kept = 0;
    for (std::uint32_t k = 0; k < count(); ++k) {
      const std::uint32_t i = cloud_.sampled(k, count());
      const Vec3f& p = cloud_.position[i];
      const bool left_out = was_surface_[k] ? !cloud_.is_surface(i) : floor && floor->cuts(p);
      if (!left_out) room_[kept++] = p;
    }
    return kept;
  }

 private:
  std::uint32_t count() const { return static_cast<std::uint32_t>(room_.size()); }

  const Cloud& cloud_;
  std::span<Vec3f> room_;
  std::bitset<kMostProofPoints> was_surface_;
};

}  // namespace

bool SurfacePoints::found() const {
  const std::uint32_t kept = clustering.points.surface();
  return kept > 0 && clustering.epsilon > 0 &&
         (clustering.coherent || clustering.core_points >= kLeastCoreShare * kept);
}

Expected<SurfacePoints> find_surface_points(Cloud& cloud, const KdTree3& tree, const SurfaceSettings& settings,
                                            Arena& arena, const StageProgress& progress) {
  const auto epsilon = density_epsilon(cloud, tree, arena);
  PLUMBLINE_TRY(epsilon);
  const auto clustered = cluster(cloud, tree, *epsilon, arena, progress.part(0, 0.7));
  PLUMBLINE_TRY(clustered);
  SurfacePoints surface;
  surface.clustering = *clustered;
  ClusteringResult& clustering = surface.clustering;
  const auto count_points = [&] { clustering.points = count_classes(cloud.normal.first(cloud.size)); };
  const auto is_found = [&] {
    count_points();
    return surface.found();
  };
  if (clustering.coherent) {
    PLUMBLINE_TRY(refine(cloud, tree, settings, clustering, arena, progress.part(0.7, 0.96)));
    PLUMBLINE_TRY(rescue_sparse_surface(cloud, tree, *epsilon, progress.part(0.96, 1)));
  }
  surface.blurred = !is_found() || is_blurred(clustering, settings);
  if (surface.blurred) return surface;
  ProofSample sample(cloud, settings.sample);
  // Beside a large floor a small object looks like a stray piece, and beside stray pieces a floor may not look like one.
  if (is_found()) cut_floor(cloud, settings, surface);
  if (!settings.keep_strays && is_found()) {
    const auto strays = mark_stray_pieces(cloud, clustering, arena);
    PLUMBLINE_TRY(strays);
    surface.strays = *strays;
    if (strays->pieces > 0 && !surface.floor) cut_floor(cloud, settings, surface);
  }
  if (is_found()) {
    const auto flying = mark_flying_points(cloud, tree, clustering, arena);
    PLUMBLINE_TRY(flying);
    surface.flying_points = *flying;
  }
  count_points();
  PLUMBLINE_TRY(level_wide_supports(cloud, tree, *epsilon, arena));
  surface.sampled = sample.keep(surface.floor);
  cloud.drop_noise();
  return surface;
}

}  // namespace plumbline::inline slicer
