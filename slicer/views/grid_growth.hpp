#pragma once
/// Follows the grid of a view from a patch over the scan.

#include <cstdint>
#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/views/view_grid.hpp"

namespace plumbline {

inline constexpr std::uint8_t kNoView = 255;

/// A grid, and how far and how closely it fits.
struct GrownGrid {
  ViewGrid grid;
  double radius = 0;     ///< around the grid's middle within which it fits, mm
  double tolerance = 0;  ///< distance from the grid within which its view's points lie, pixels

  /// Distance of a point from the grid over `tolerance`: up to 1 for points of the view, 2 for all others.
  double relative_distance(const Vec3f& point) const;
  bool contains(const Vec3f& point) const { return relative_distance(point) <= 1; }
};

/// Fits grids to the points that belong to no view yet. Each view that is found leaves fewer points that would lie on
/// the next grid by chance.
class GridGrowth {
 public:
  /// Upper bound of the arena bytes that create() takes, without alignment.
  static std::size_t bytes();
  /// @param view_of  each point's view, kNoView where none is known; read at every call
  static Expected<GridGrowth> create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                     Arena& arena);

  /// Fits a grid to the points within a radius, with an ever smaller tolerance, then to more and more of the scan, for
  /// as long as clearly more points lie on it than would by chance.
  ///
  /// @param grid    right to about a third of a pixel within `radius` of its middle
  /// @param radius  mm
  /// @returns nothing if the points lie on no such grid
  std::optional<GrownGrid> grow(ViewGrid grid, double radius);
  /// The number of free points on a grid, out of thinned().
  std::uint32_t count(const GrownGrid& grid) const;
  /// Indices of every n-th point of the scan, 65,536 at most.
  std::span<const std::uint32_t> thinned() const { return thinned_; }

 private:
  GridGrowth(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of)
      : cloud_(&cloud), tree_(&tree), view_of_(view_of) {}
  void fit(ViewGrid& grid, std::span<const Vec3f> points, double width, int steps) const;
  double tolerance_of(ViewGrid& grid, double radius);
  std::span<const Vec3f> take_sample(const Vec3f& middle, double radius);

  const Cloud* cloud_;
  const KdTree3* tree_;
  std::span<const std::uint8_t> view_of_;
  std::span<std::uint32_t> thinned_;
  std::span<Vec3f> sample_;
  double extent_ = 0;  ///< half the diagonal of the scan, mm
};

}  // namespace plumbline
