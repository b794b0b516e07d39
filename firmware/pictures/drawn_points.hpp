#pragma once
/// The points of a scan as the pictures draw them: a closed surface without flying points.

#include <cstdint>
#include <span>

#include "firmware/pictures/preview/preview_shading.hpp"
#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"

namespace plumbline::firmware::inline pictures {

/// What a view shows, rotated and seen along +y, unit of the cloud: x to the right, z up.
struct ViewBox {
  double left = 0, right = 0, low = 0, high = 0;

  double width() const { return right - left; }
  double height() const { return high - low; }
};

/// A depth map and as many samples of scratch.
struct MapMemory {
  DepthMap map;
  std::span<float> scratch;
};

class DrawnPoints {
 public:
  /// Chooses the points: of every so many one, and only those with others around them.
  /// @param cloud  not empty
  /// @param most   of the cloud's points that are looked at; up to 68 bytes of the arena each
  /// @param arena  4 bytes a point stay at its top
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<DrawnPoints> create(const Cloud& cloud, std::uint32_t most, Arena& arena);

  /// Around the largest piece of the object.
  ViewBox box(const Mat3d& rotation) const;

  /// Samples of a map a unit of the cloud at which a view fills it.
  static double scale(const ViewBox& box, const DepthMap& map);

  /// Draws the points as discs that overlap, then closes what holes are left and smooths the surface.
  /// @param box        of this rotation; its middle is the map's
  /// @param is_second  whether a point with this rotated normal is of the second material
  void draw(const Mat3d& rotation, const ViewBox& box, double scale, const MapMemory& memory,
            FunctionRef<bool(const Vec3d& normal)> is_second) const;

 private:
  const Cloud* cloud_ = nullptr;
  std::span<std::uint32_t> points_;
  Box3f object_;        ///< of its largest piece
  double spacing_ = 0;  ///< distance of the points from each other, unit of the cloud
};

}  // namespace plumbline::firmware::inline pictures
