#pragma once
/// The views of a scan with their current motions, and without their ripple.

#include <omp.h>

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/views/depth_image.hpp"
#include "slicer/views/grid_growth.hpp"
#include "slicer/views/local_paraboloid.hpp"
#include "slicer/views/ripple.hpp"
#include "slicer/views/view_grid.hpp"

namespace plumbline {

struct Views {
  /// View of each point. Points without one (kNoView) are not used and stay in place.
  std::span<const std::uint8_t> of;
  std::span<const ViewGrid> grids;  ///< of each view, where its points were seen; kMaxViews at most
  float spacing = 0;                ///< of the scan's points, mm
};

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
  static std::size_t bytes(std::size_t views);
  static Expected<MovedViews> create(const Cloud& cloud, const Views& views, Arena& arena);

  std::size_t size() const { return motions.size(); }
  std::uint8_t view_of(std::uint32_t point) const { return views_.of[point]; }
  float spacing() const { return views_.spacing; }
  /// Unit vector of the ray that a point of a view was seen on, away from the scanner.
  Vec3d ray(std::uint32_t point) const {
    return views_.grids[views_.of[point]].ray(cloud_->position[point]) * outward_[views_.of[point]];
  }
  /// Where a point was seen, mm from the middle of the scan.
  Vec3d seen_position(std::uint32_t point) const { return cloud_->position[point].cast<double>() - middle_; }
  /// The same without ripple and after its view's motion.
  /// @param ray  of the point
  Vec3d moved_position(std::uint32_t point, const Vec3d& ray) const;
  const Vec3d& middle() const { return middle_; }
  double extent() const { return extent_; }
  /// Sets the frame of an image that holds all points of a view, for each view.
  void set_image_frames(std::span<DepthFrame> frames) const;

  /// Motion of each view: translation in mm, then rotation in mm of arc at `extent` from the middle.
  std::span<Vec6d> motions;
  std::span<Ripple> ripples;  ///< of each view, a function of the seen position

 private:
  MovedViews(const Cloud& cloud, const Views& views) : cloud_(&cloud), views_(views) {}

  const Cloud* cloud_;
  Views views_;
  std::span<double> outward_;  ///< 1 or -1 for each view: ViewGrid::ray() has no sign of its own
  Vec3d middle_ = Vec3d::Zero();
  double extent_ = 0;  ///< half the longest side of the scan, mm
};

}  // namespace plumbline
