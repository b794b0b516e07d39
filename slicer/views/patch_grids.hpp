#pragma once
/// Proposes grids of views from the spectrum of a patch of the scan.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"
#include "slicer/views/patch_spectrum.hpp"
#include "slicer/views/view_grid.hpp"

namespace plumbline {

/// The points around a seed that belong to no view yet, and the grids that may run through them.
class PatchGrids {
 public:
  /// Upper bound of the arena bytes that create() takes, without alignment.
  static std::size_t bytes(std::uint32_t threads);
  /// @param spacing  of the scan's points, mm
  /// @param view_of  each point's view, kNoView where none is known; read at every take()
  static Expected<PatchGrids> create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                     float spacing, Arena& arena);

  /// Takes the points within `radius` (mm) of a seed point and computes their spectrum.
  /// @returns false if there are too few points; then there are no peaks
  bool take(std::uint32_t seed, float radius);

  /// Whether the patch has so many points that a larger one would show no more.
  bool is_full() const { return full_; }
  /// mm; less than asked for where the nearest points fill the patch.
  float radius() const { return radius_; }
  /// Relative to the seed.
  const LocalPoints& points() const { return points_; }
  std::size_t peaks() const { return peaks_.size(); }
  /// The grid whose two frequencies are peaks a and b, or nothing if they can't belong to one grid.
  std::optional<ViewGrid> grid(std::size_t a, std::size_t b) const;

 private:
  PatchGrids(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of, float spacing,
             PatchSpectrum spectrum)
      : cloud_(&cloud), tree_(&tree), view_of_(view_of), spacing_(spacing), spectrum_(spectrum) {}
  bool may_be_grid(const Vec3f& f, const Vec3f& g) const;

  const Cloud* cloud_;
  const KdTree3* tree_;
  std::span<const std::uint8_t> view_of_;
  float spacing_;
  PatchSpectrum spectrum_;
  std::span<Neighbour> candidates_;
  std::array<std::span<float>, 3> room_;  ///< for points_
  LocalPoints points_;
  Vec3f middle_ = Vec3f::Zero();   ///< position of the seed, mm
  Vec3f normal_ = Vec3f::UnitZ();  ///< mean normal of the patch
  std::span<const SpectrumPeak> peaks_;
  float radius_ = 0;
  bool full_ = false;
};

}  // namespace plumbline
