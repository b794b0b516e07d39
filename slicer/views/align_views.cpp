#include "slicer/views/align_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "slicer/core/median.hpp"
#include "slicer/views/find_views.hpp"
#include "slicer/views/local_form.hpp"
#include "slicer/views/registration.hpp"

namespace plumbline {
namespace {

constexpr std::uint32_t kFewestPoints = 32768;  ///< of a scan: a view has some thousand at least
constexpr std::uint32_t kSample = 256;          ///< places where the scan is measured
constexpr float kNoisy = 0.2F;                  ///< deviation of points from their surface over their spacing
constexpr double kFound = 0.6;                  ///< of the time

struct Roughness {
  float spacing = 0;    ///< side of a square as large as a point's share of the surface, mm
  float deviation = 0;  ///< of points from the surface round them, mm
};

/// Medians over the scan.
Roughness roughness(const Cloud& cloud, const KdTree3& tree) {
  std::array<float, kSample> spacings = {};
  std::array<float, kSample> deviations = {};
  std::uint32_t formed = 0;
  for (std::uint32_t k = 0; k < kSample; ++k) {
    const auto i = static_cast<std::uint32_t>(std::uint64_t{k} * cloud.size / kSample);
    std::array<Neighbour, LocalForm::kMostPoints> found = {};
    const std::uint32_t near = tree.nearest(cloud.position[i], found);
    std::array<Vec3d, LocalForm::kMostPoints> points;
    for (std::uint32_t n = 0; n < near; ++n) {
      points[n] = (cloud.position[found[n].index] - cloud.position[i]).cast<double>();
    }
    spacings[k] = std::sqrt(std::numbers::pi_v<float> * found[near - 1].distance2 / static_cast<float>(near));
    LocalForm form;
    if (form.fit(std::span(points).first(near))) deviations[formed++] = static_cast<float>(form.deviation);
  }
  if (formed == 0) return {};
  return {median(std::span<float>(spacings)), median(std::span(deviations).first(formed))};
}

}  // namespace

std::size_t align_views_bytes(std::uint32_t points) {
  if (points < kFewestPoints) return 0;
  return points + std::max(find_views_bytes(), register_views_bytes());
}

Expected<ViewAlignment> align_views(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress) {
  ViewAlignment alignment;
  if (cloud.size < kFewestPoints) return alignment;
  const Roughness rough = roughness(cloud, tree);
  if (!(rough.deviation > kNoisy * rough.spacing)) return alignment;
  const ArenaScope scope(arena);
  const auto view_of = arena.take_top<std::uint8_t>(cloud.size, "views");
  PLUMBLINE_TRY(view_of);
  const auto found = find_views(cloud, tree, rough.spacing, *view_of, arena, progress.part(0, kFound));
  PLUMBLINE_TRY(found);
  alignment.views = found->count;
  alignment.points = found->points;
  if (found->count < 2) return alignment;
  const auto registered =
      register_views(cloud, tree, {*view_of, std::span(found->grids).first(found->count), rough.spacing}, arena,
                     progress.part(kFound, 1));
  PLUMBLINE_TRY(registered);
  alignment.before = registered->before;
  alignment.after = registered->after;
  alignment.moved = registered->moved;
  alignment.ripple = registered->ripple;
  return alignment;
}

}  // namespace plumbline
