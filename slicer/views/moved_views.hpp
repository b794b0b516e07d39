#pragma once
/// The views of a scan with their current motions.

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/views/local_paraboloid.hpp"

namespace plumbline::inline slicer {

/// The views that a thread sums up for, so that their sums don't depend on the number of threads.
struct ViewShare {
  std::uint32_t thread, threads;
  /// Of the calling thread.
  static ViewShare of_thread() {
    return {static_cast<std::uint32_t>(omp_get_thread_num()), static_cast<std::uint32_t>(omp_get_num_threads())};
  }
  bool has(std::uint32_t view) const { return threads == 1 || view % threads == thread; }
};

/// Reads positions and normals from the cloud at every call.
class MovedViews {
 public:
  static std::size_t bytes(std::uint32_t views);
  /// @param cloud    with two views at least
  /// @param spacing  of its points
  static Expected<MovedViews> create(const Cloud& cloud, float spacing, Arena& arena);

  /// Views that move on their own. If a scan has more, views that follow each other move together: the equations grow with the square.
  static constexpr std::uint32_t kMost = 64;
  static std::uint32_t count(std::uint32_t views) { return std::min(views, kMost); }
  std::uint32_t count() const { return count(cloud_->views.count); }
  /// The view that a point moves with, or kNoView.
  std::uint8_t view_of(std::uint32_t point) const {
    const std::uint8_t view = cloud_->views.of[point];
    const std::uint32_t views = cloud_->views.count;
    return views <= kMost || view == kNoView ? view : static_cast<std::uint8_t>(view * kMost / views);
  }
  float spacing() const { return spacing_; }
  /// Where a point was seen, from the middle of the scan.
  Vec3d seen_position(std::uint32_t point) const { return cloud_->position[point].cast<double>() - middle_; }
  /// The same after its view's motion.
  Vec3d moved_position(std::uint32_t point) const {
    const Vec3d x = seen_position(point);
    const Vec6d& m = motions[view_of(point)];
    return x + m.head<3>() + m.tail<3>().cross(x) / extent_;
  }
  /// Unit vector from the scanner to a point. Where the scanner's place is unknown, it is taken to have looked against the view's mean normal.
  /// @returns none if the view has points on all sides
  std::optional<Vec3d> ray(std::uint32_t point) const;
  const Vec3d& middle() const { return middle_; }
  double extent() const { return extent_; }

  /// Motion of each view: translation, then rotation as length of arc at `extent` from the middle.
  std::span<Vec6d> motions;

 private:
  MovedViews(const Cloud& cloud, float spacing) : cloud_(&cloud), spacing_(spacing) {}

  const Cloud* cloud_;
  float spacing_;
  Vec3d middle_ = Vec3d::Zero();
  double extent_ = 0;  ///< half the longest side of the scan
  std::span<Vec3d> mean_normal_;
};

}  // namespace plumbline::inline slicer
