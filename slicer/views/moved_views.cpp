#include "slicer/views/moved_views.hpp"

#include <algorithm>
#include <array>

namespace plumbline::inline slicer {
namespace {

/// Least length of the mean normal of a view that was seen from one place; that of half a ball is .5, of a merged scan near 0.
constexpr double kOneSide = 0.4;

}  // namespace

std::size_t MovedViews::bytes(std::uint32_t views) { return views * (sizeof(Vec6d) + sizeof(Vec3d)); }

std::optional<Vec3d> MovedViews::ray(std::uint32_t point) const {
  if (const auto known = cloud_->views.ray(cloud_->views.of[point], cloud_->position[point])) return known;
  const Vec3d& normal = mean_normal_[view_of(point)];
  return normal.isZero() ? std::nullopt : std::optional<Vec3d>(-normal);
}

Expected<MovedViews> MovedViews::create(const Cloud& cloud, float spacing, Arena& arena) {
  MovedViews moved(cloud, spacing);
  PLUMBLINE_TRY(arena.take_top(moved.motions, moved.count(), "views"));
  std::fill(moved.motions.begin(), moved.motions.end(), Vec6d::Zero());
  PLUMBLINE_TRY(arena.take_top(moved.mean_normal_, moved.count(), "views"));
  std::fill(moved.mean_normal_.begin(), moved.mean_normal_.end(), Vec3d::Zero());
  std::array<std::uint32_t, kMost> points = {};
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (moved.view_of(i) == kNoView || !cloud.normal[i].known()) continue;
    moved.mean_normal_[moved.view_of(i)] += cloud.normal[i].unpack().cast<double>();
    ++points[moved.view_of(i)];
  }
  for (std::uint32_t v = 0; v < moved.count(); ++v) {
    Vec3d& mean = moved.mean_normal_[v];
    mean = mean.norm() > kOneSide * points[v] ? mean.normalized() : Vec3d::Zero();
  }
  const Box3f bounds = cloud.bounds();
  moved.middle_ = bounds.centre().cast<double>();
  moved.extent_ = 0.5 * static_cast<double>(bounds.size().maxCoeff());
  return moved;
}

}  // namespace plumbline::inline slicer
