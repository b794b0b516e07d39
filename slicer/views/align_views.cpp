#include "slicer/views/align_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "slicer/core/numbers/median.hpp"
#include "slicer/views/find_views.hpp"
#include "slicer/views/local_paraboloid.hpp"

namespace plumbline {
namespace {

/// Points of a scan. The search needs patches of some thousand points, and several of them.
constexpr std::uint32_t kMinPoints = 32768;
constexpr std::uint32_t kSample = 256;  ///< places at which noise and spacing are measured; their medians are used
/// Noise over spacing. Below it, misaligned views are not the scan's largest error, and the search would only take
/// time.
constexpr float kMinNoise = 0.2F;
constexpr double kFound = 0.6;  ///< progress when the views are found, 0 to 1

struct ScanNoise {
  float spacing = 0;  ///< side of a square of one point's share of the surface, mm
  float noise = 0;    ///< standard deviation of points off the surface, mm
};

/// Measures the medians over the scan.
ScanNoise measure_noise(const Cloud& cloud, const KdTree3& tree) {
  std::array<float, kSample> spacings = {};
  std::array<float, kSample> noises = {};
  std::uint32_t fitted = 0;
  for (std::uint32_t k = 0; k < kSample; ++k) {
    const std::uint32_t i = cloud.sampled(k, kSample);
    std::array<Neighbour, LocalParaboloid::kMaxPoints> found = {};
    const std::uint32_t near = tree.nearest(cloud.position[i], found);
    std::array<Vec3d, LocalParaboloid::kMaxPoints> points;
    for (std::uint32_t n = 0; n < near; ++n) {
      points[n] = (cloud.position[found[n].index] - cloud.position[i]).cast<double>();
    }
    spacings[k] = std::sqrt(std::numbers::pi_v<float> * found[near - 1].distance2 / static_cast<float>(near));
    LocalParaboloid surface;
    if (surface.fit(std::span(points).first(near))) noises[fitted++] = static_cast<float>(surface.deviation);
  }
  if (fitted == 0) return {};
  return {median(std::span<float>(spacings)), median(std::span(noises).first(fitted))};
}

}  // namespace

std::size_t align_views_bytes(std::uint32_t points, std::uint32_t threads) {
  if (points < kMinPoints) return 0;
  return align_views_bytes({.searched = true, .views = kMaxViews}, points, threads);
}

std::size_t align_views_bytes(const ViewCounts& found, std::uint32_t points, std::uint32_t threads) {
  if (!found.searched) return 0;
  return points + std::max(find_views_bytes(threads), found.views < 2 ? 0 : register_views_bytes(found.views, threads));
}

Expected<ViewAlignment> align_views(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress) {
  ViewAlignment alignment;
  if (cloud.size < kMinPoints) return alignment;
  const ScanNoise scan = measure_noise(cloud, tree);
  if (!(scan.noise > kMinNoise * scan.spacing)) return alignment;
  alignment.searched = true;
  const ArenaScope scope(arena);
  const auto view_of = arena.take_top<std::uint8_t>(cloud.size, "views");
  PLUMBLINE_TRY(view_of);
  const auto found = find_views(cloud, tree, scan.spacing, *view_of, arena, progress.part(0, kFound));
  PLUMBLINE_TRY(found);
  alignment.views = found->count;
  alignment.points = found->points;
  if (found->count < 2) return alignment;
  const auto registered =
      register_views(cloud, tree, {*view_of, std::span(found->grids).first(found->count), scan.spacing}, arena,
                     progress.part(kFound, 1));
  PLUMBLINE_TRY(registered);
  static_cast<Registration&>(alignment) = *registered;
  return alignment;
}

}  // namespace plumbline
