#pragma once
/// Follows the grid of a view from a patch over the scan.

#include <array>
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
};

/// Fits grids to the points that belong to no view yet. Each view that is found leaves fewer points that would lie on
/// the next grid by chance.
class GridGrowth {
 public:
  /// Upper bound of the arena bytes that create() takes, without alignment.
  static std::size_t bytes(std::uint32_t threads);
  /// @param view_of  each point's view, kNoView where none is known; read at every call
  static Expected<GridGrowth> create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                     Arena& arena);

  /// Fits a grid to the points within a radius, with an ever smaller tolerance, then to more and more of the scan, for
  /// as long as clearly more points lie on it than would by chance.
  ///
  /// @param grid    right to about a third of a pixel within `radius` of its middle
  /// @param radius  mm
  /// @param points  those within the radius; sampled from the cloud if there are none
  /// @returns nothing if the points lie on no such grid
  std::optional<GrownGrid> grow(ViewGrid grid, double radius, const LocalPoints& points = {});
  /// See ViewGridFit::expect_lens().
  void expect_lens(double radial) { fit_.expect_lens(radial); }

 private:
  GridGrowth(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of, double extent,
             std::span<float> room)
      : cloud_(&cloud), tree_(&tree), view_of_(view_of), extent_(extent), fit_(extent, room) {}
  bool fit(ViewGrid& grid, const LocalPoints& points, double radius) const;
  double tolerance_of(ViewGrid& grid, double radius);
  /// What one thread finds of a sample, in the order of the cloud: points whose index is a multiple of `stride`.
  struct Part {
    std::array<std::span<float>, 3> at;  ///< coordinates
    std::span<std::uint32_t> index;
    std::size_t size = 0;
    std::size_t taken = 0;  ///< points that are in the sample already
    std::uint32_t stride = 1;

    void thin();
    void take(Part& from, std::size_t end);
  };
  LocalPoints take_sample(const Vec3f& middle, double radius);
  const Part& collect(const Vec3f& middle, float radius, std::uint32_t stride);
  void collect_part(const Vec3f& middle, float radius, std::uint32_t thread, std::uint32_t threads);

  const Cloud* cloud_;
  const KdTree3* tree_;
  std::span<const std::uint8_t> view_of_;
  double extent_;  ///< half the diagonal of the scan, mm
  ViewGridFit fit_;
  std::span<Part> parts_;  ///< of each thread; the last one is the whole
};

}  // namespace plumbline
