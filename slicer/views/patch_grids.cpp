#include "slicer/views/patch_grids.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "slicer/cloud/nearest_in_box.hpp"
#include "slicer/core/numbers/lanes.hpp"
#include "slicer/views/grid_growth.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

/// Points of a patch. The power of a view's peak grows with them (a view that has 500 of 4096 points stands 60 times
/// above chance), and so do the time and the curvature that a patch spans.
constexpr std::uint32_t kMaxPoints = 4096;
constexpr std::uint32_t kFullPatch = 2560;  ///< points; with fewer and no grid found, a larger patch is tried too
constexpr std::uint32_t kMinPoints = 512;   ///< with fewer, a view's peak does not stand out
/// Room for points within the radius before the nearest kMaxPoints are selected: a patch may be cut by several sheets.
constexpr std::uint32_t kMaxCandidates = 4 * kMaxPoints;

// Two peaks may be the frequencies of one grid if they are about perpendicular and about equal, since pixels are nearly
// square and a patch seen obliquely stretches them; and if their sum and difference, which a grid has too, show power.
constexpr float kMinSine2 = 0.5F;       ///< squared sine of the angle between them: 45 to 135 degrees
constexpr float kMinRatio2 = 0.4F;      ///< squared ratio of their lengths: 0.63 and more
constexpr float kMinIncidence = 0.15F;  ///< cosine of the ray to the patch's normal: a ray within 81 degrees of it
constexpr float kMinSumPower = 10;      ///< SpectrumPeak::power; 1 is chance

}  // namespace

std::size_t PatchGrids::bytes(std::uint32_t threads) {
  return PatchSpectrum::bytes(threads) + kMaxCandidates * sizeof(Neighbour) + 3 * kMaxPoints * sizeof(float);
}

Expected<PatchGrids> PatchGrids::create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                        float spacing, Arena& arena) {
  auto spectrum = PatchSpectrum::create(arena);
  PLUMBLINE_TRY(spectrum);
  PatchGrids patch(cloud, tree, view_of, spacing, *spectrum);
  PLUMBLINE_TRY(arena.take_top(patch.candidates_, kMaxCandidates, kStage));
  auto room = arena.take_top<float>(3 * kMaxPoints, kStage);
  PLUMBLINE_TRY(room);
  for (std::size_t axis = 0; axis < 3; ++axis) patch.room_[axis] = room->subspan(axis * kMaxPoints, kMaxPoints);
  return patch;
}

bool PatchGrids::take(std::uint32_t seed, float radius) {
  peaks_ = {};
  middle_ = cloud_->position[seed];
  radius_ = radius;
  const auto is_free = [&](std::uint32_t i) { return view_of_[i] == kNoView && cloud_->normal[i].weight == 1; };
  std::size_t count = find_within(cloud_->positions(), *tree_, middle_, radius, candidates_, is_free);
  full_ = count >= kFullPatch;
  if (count < kMinPoints) return false;
  if (count > kMaxPoints) {
    std::nth_element(candidates_.begin(), candidates_.begin() + kMaxPoints,
                     candidates_.begin() + static_cast<std::ptrdiff_t>(count));
    radius_ = std::sqrt(candidates_[kMaxPoints].distance2);
    count = kMaxPoints;
  }
  count -= count % kLanes;
  Vec3f normal = Vec3f::Zero();
  const Vec3f facing = cloud_->normal[seed].unpack();
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3f from = cloud_->position[candidates_[k].index] - middle_;
    for (std::size_t axis = 0; axis < 3; ++axis) room_[axis][k] = from[static_cast<Eigen::Index>(axis)];
    const Vec3f n = cloud_->normal[candidates_[k].index].unpack();
    normal += n.dot(facing) < 0 ? Vec3f(-n) : n;
  }
  normal_ = normal / std::sqrt(normal.dot(normal));
  points_ = {room_[0].first(count), room_[1].first(count), room_[2].first(count)};
  peaks_ = spectrum_.peaks(points_, normal_, radius_, spacing_);
  return true;
}

bool PatchGrids::may_be_grid(const Vec3f& f, const Vec3f& g) const {
  const Vec3f ray = f.cross(g);
  const float ray2 = ray.dot(ray);
  const float f2 = f.dot(f);
  const float g2 = g.dot(g);
  if (ray2 < kMinSine2 * f2 * g2 || f2 < kMinRatio2 * g2 || g2 < kMinRatio2 * f2) return false;
  if (std::abs(ray.dot(normal_)) < kMinIncidence * std::sqrt(ray2)) return false;
  return power_at(points_, f + g) >= kMinSumPower && power_at(points_, f - g) >= kMinSumPower;
}

/// The camera is taken to be so far away that its rays are parallel; GridGrowth adds the perspective.
std::optional<ViewGrid> PatchGrids::grid(std::size_t a, std::size_t b) const {
  Vec3f f = peaks_[a].frequency;
  Vec3f g = peaks_[b].frequency;
  if (!may_be_grid(f, g)) return std::nullopt;
  // Rows and columns are the two shortest frequencies of those that a grid has.
  if (f.dot(f) > g.dot(g)) std::swap(f, g);
  g -= std::round(f.dot(g) / f.dot(f)) * f;
  const Vec3f half_sum = (f + g) / 2;
  const Vec3f half_difference = (f - g) / 2;
  if (std::min(power_at(points_, half_sum), power_at(points_, half_difference)) >= kMinSumPower) {
    f = half_sum;
    g = half_difference;
  }
  ViewGrid grid;
  grid.middle = middle_;
  grid.map.setZero();
  grid.map.segment<3>(0) = f.cast<double>();
  grid.map.segment<3>(4) = g.cast<double>();
  grid.map[3] = -static_cast<double>(angle_in_turns(coefficient(points_, f)));
  grid.map[7] = -static_cast<double>(angle_in_turns(coefficient(points_, g)));
  return grid;
}

}  // namespace plumbline
