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

/// A grid and how far it is known.
struct GrownGrid {
  ViewGrid grid;
  double radius = 0;     ///< round the grid's middle: as far as it was followed, mm
  double tolerance = 0;  ///< how far off the grid points of the view lie, pixels

  /// How far a point is off the grid, 1 for as far as one of the view may be, 2 for what is farther off or away.
  double off(const Vec3f& point) const;
};

/// What points are free to be of a new view. Those of other views are not seen: each view that was found leaves less noise
/// to the next.
class GridGrowth {
 public:
  /// Bytes of arena that create() takes at most, rounding of blocks apart.
  static std::size_t bytes();
  static Expected<GridGrowth> create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                     Arena& arena);

  /// Fits a grid to the points within a radius, with less and less play, then to more and more of the scan, as long as more
  /// points lie on it than would by chance.
  ///
  /// @param grid    right to a third of a pixel or so within `radius` of its middle
  /// @param radius  mm
  /// @returns nothing where it is no grid
  std::optional<GrownGrid> grow(ViewGrid grid, double radius);
  /// How many of every few free points lie on a grid.
  std::uint32_t count(const GrownGrid& grid) const;
  /// Every few-th point of the scan, 65,536 at most.
  std::span<const std::uint32_t> thin() const { return thin_; }

 private:
  GridGrowth(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of)
      : cloud_(&cloud), tree_(&tree), view_of_(view_of) {}
  void fit(ViewGrid& grid, std::span<const Vec3f> points, double width, int steps) const;
  double tolerance_of(ViewGrid& grid, double radius);
  std::span<const Vec3f> take_sample(const Vec3f& middle, double radius);

  const Cloud* cloud_;
  const KdTree3* tree_;
  std::span<const std::uint8_t> view_of_;
  std::span<std::uint32_t> thin_;
  std::span<Vec3f> sample_;
  double extent_ = 0;  ///< half the diagonal of the scan, mm
};

}  // namespace plumbline
