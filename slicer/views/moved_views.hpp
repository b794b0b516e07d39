#pragma once
/// The views of a scan, each where it has been moved to and without its ripple.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/vec.hpp"
#include "slicer/views/depth_image.hpp"
#include "slicer/views/grid_growth.hpp"
#include "slicer/views/local_form.hpp"
#include "slicer/views/ripple.hpp"
#include "slicer/views/view_grid.hpp"

namespace plumbline {

struct Views {
  std::span<const std::uint8_t> of;  ///< a point's view; what has none (kNoView) stays where it is and is not asked
  std::span<const ViewGrid> grids;   ///< of each view, where its points were seen; kMostViews at most
  float spacing = 0;                 ///< of the scan's points, mm
};

/// Takes positions and normals from the cloud whenever it is asked.
class MovedViews {
 public:
  static std::size_t bytes(std::size_t views);
  static Expected<MovedViews> create(const Cloud& cloud, const Views& views, Arena& arena);

  std::size_t size() const { return motions.size(); }
  std::uint8_t view_of(std::uint32_t point) const { return views_.of[point]; }
  float spacing() const { return views_.spacing; }
  /// Of the ray of a point that is of a view, away from the scanner, of length 1.
  Vec3d ray(std::uint32_t point) const {
    return views_.grids[views_.of[point]].ray(cloud_->position[point]) * outward_[views_.of[point]];
  }
  /// Where a point was seen, mm from the middle of the scan.
  Vec3d seen(std::uint32_t point) const { return cloud_->position[point].cast<double>() - middle_; }
  /// Where it is without ripple and after its view's motion, mm from the middle of the scan.
  Vec3d moved(std::uint32_t point) const;
  const Vec3d& middle() const { return middle_; }
  double extent() const { return extent_; }
  DepthFrame frame(std::uint8_t view) const;

  std::span<Vec6d>
      motions;  ///< of each view: mm along the axes, then turned about them, mm at `extent` from the middle
  std::span<Ripple> ripples;  ///< of each view, over where points were seen

 private:
  MovedViews(const Cloud& cloud, const Views& views) : cloud_(&cloud), views_(views) {}

  const Cloud* cloud_;
  Views views_;
  std::span<double> outward_;  ///< 1 or -1: the grid's own ray may be either way
  Vec3d middle_ = Vec3d::Zero();
  double extent_ = 0;  ///< half the longest side of the scan, mm
};

}  // namespace plumbline
