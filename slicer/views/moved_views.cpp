#include "slicer/views/moved_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/views/find_views.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

}  // namespace

std::size_t MovedViews::bytes(std::size_t views) { return views * (sizeof(Vec6d) + sizeof(Ripple) + sizeof(double)); }

Expected<MovedViews> MovedViews::create(const Cloud& cloud, const Views& views, Arena& arena) {
  MovedViews moved(cloud, views);
  PLUMBLINE_TRY(arena.take_top(moved.motions, views.grids.size(), kStage));
  PLUMBLINE_TRY(arena.take_top(moved.ripples, views.grids.size(), kStage));
  PLUMBLINE_TRY(arena.take_top(moved.outward_, views.grids.size(), kStage));
  std::fill(moved.motions.begin(), moved.motions.end(), Vec6d::Zero());
  std::fill(moved.ripples.begin(), moved.ripples.end(), Ripple{});
  std::fill(moved.outward_.begin(), moved.outward_.end(), 0);
#pragma omp parallel
  {
    // Each thread sums up for views of its own, always in the order of the points.
    const ViewShare share = ViewShare::of_thread();
    for (std::uint32_t i = 0; i < cloud.size; ++i) {
      if (views.of[i] == kNoView || !share.has(views.of[i])) continue;
      const Vec3d ray = views.grids[views.of[i]].ray(cloud.position[i]);
      moved.outward_[views.of[i]] -= ray.dot(cloud.normal[i].unpack().cast<double>());
    }
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

void MovedViews::set_image_frames(std::span<DepthFrame> frames) const {
#pragma omp parallel
  {
    // Each thread sums up for views of its own, always in the order of the points.
    const ViewShare share = ViewShare::of_thread();
    const auto for_each = [&](auto use) {
      for (std::uint32_t i = 0; i < cloud_->size; ++i) {
        const std::uint8_t view = view_of(i);
        if (view != kNoView && share.has(view)) use(view, seen_position(i));
      }
    };
    std::array<Vec3d, kMaxViews> mean;
    std::array<Vec3d, kMaxViews> axis;
    std::array<std::uint32_t, kMaxViews> counts = {};
    std::array<double, kMaxViews> radius2 = {};
    mean.fill(Vec3d::Zero());
    for_each([&](std::uint8_t view, const Vec3d& x) {
      mean[view] += x;
      ++counts[view];
    });
    for (std::uint32_t v = 0; v < frames.size(); ++v) {
      mean[v] /= std::max(1U, counts[v]);
      axis[v] = views_.grids[v].ray((mean[v] + middle_).cast<float>());
    }
    for_each([&](std::uint8_t view, const Vec3d& x) {
      const Vec3d d = x - mean[view];
      const double along = d.dot(axis[view]);
      radius2[view] = std::max(radius2[view], d.squaredNorm() - along * along);
    });
    for (std::uint32_t v = 0; v < frames.size(); ++v) {
      if (share.has(v)) frames[v] = {mean[v], axis[v], std::sqrt(radius2[v])};
    }
  }
}

}  // namespace plumbline
