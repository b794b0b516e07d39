#include "slicer/views/moved_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

}  // namespace

std::size_t MovedViews::bytes(std::size_t views) { return views * (sizeof(Vec6d) + sizeof(Ripple) + sizeof(double)); }

Expected<MovedViews> MovedViews::create(const Cloud& cloud, const Views& views, Arena& arena) {
  MovedViews moved(cloud, views);
  auto motions = arena.take_top<Vec6d>(views.grids.size(), kStage);
  PLUMBLINE_TRY(motions);
  auto ripples = arena.take_top<Ripple>(views.grids.size(), kStage);
  PLUMBLINE_TRY(ripples);
  auto outward = arena.take_top<double>(views.grids.size(), kStage);
  PLUMBLINE_TRY(outward);
  moved.motions = *motions;
  moved.ripples = *ripples;
  moved.outward_ = *outward;
  std::fill(moved.motions.begin(), moved.motions.end(), Vec6d::Zero());
  std::fill(moved.ripples.begin(), moved.ripples.end(), Ripple{});
  std::fill(moved.outward_.begin(), moved.outward_.end(), 0);
  for (std::uint32_t i = 0; i < cloud.size; ++i) {
    if (views.of[i] == kNoView) continue;
    const Vec3d ray = views.grids[views.of[i]].ray(cloud.position[i]);
    moved.outward_[views.of[i]] -= ray.dot(cloud.normal[i].unpack().cast<double>());
  }
  for (double& x : moved.outward_) x = x < 0 ? -1 : 1;
  const Box3f bounds = cloud.bounds();
  moved.middle_ = bounds.centre().cast<double>();
  moved.extent_ = 0.5 * static_cast<double>(bounds.size().maxCoeff());
  return moved;
}

Vec3d MovedViews::moved_position(std::uint32_t point, const Vec3d& ray) const {
  Vec3d x = seen_position(point);
  const Ripple& ripple = ripples[view_of(point)];
  if (ripple.waves > 0) x -= ray * ripple.depth(x);
  const Vec6d& m = motions[view_of(point)];
  return x + m.head<3>() + m.tail<3>().cross(x) / extent_;
}

DepthFrame MovedViews::image_frame(std::uint8_t view) const {
  Vec3d sum = Vec3d::Zero();
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < cloud_->size; ++i) {
    if (view_of(i) != view) continue;
    sum += seen_position(i);
    ++count;
  }
  const Vec3d mean = sum / std::max(1U, count);
  const Vec3d axis = views_.grids[view].ray((mean + middle_).cast<float>());
  double radius2 = 0;
  for (std::uint32_t i = 0; i < cloud_->size; ++i) {
    if (view_of(i) != view) continue;
    const Vec3d d = seen_position(i) - mean;
    const double along = d.dot(axis);
    radius2 = std::max(radius2, d.squaredNorm() - along * along);
  }
  return {mean, axis, std::sqrt(radius2)};
}

}  // namespace plumbline
