#pragma once
/// The moving-least-squares surface along one ray (thesis III-3, DESIGN 3, stage 6d).

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/vec.hpp"

namespace plumbline {

/// The points whose support a ray at (x, y) meets, as columns sorted by depth. Every point of the surface that any value
/// on the ray needs lies within its support radius of the ray in the plane, so one search serves the whole ray.
///
/// The columns are padded: kLanes entries past `size` with distance2 = 1, inverse_radius2 = 2 (no weight anywhere).
struct RayPoints {
  static constexpr std::uint32_t kLanes = 4;

  float* depth = nullptr;            ///< z of the point, mm, ascending
  float* distance2 = nullptr;        ///< squared distance of the point from the ray in the plane, mm^2
  float* plane = nullptr;            ///< <n, (x, y, 0) - p>, mm: the tangent plane's distance at depth 0
  float* slope = nullptr;            ///< n_z: its change with depth
  float* inverse_radius2 = nullptr;  ///< 1 / h^2, mm^-2
  float* normal_x = nullptr;
  float* normal_y = nullptr;
  float* offset_x = nullptr;  ///< x of the ray less that of the point, mm
  float* offset_y = nullptr;
  std::uint32_t size = 0;
  float reach = 0;  ///< largest h, mm: no point farther in depth has weight

  /// Bytes of arena that columns for `capacity` points take.
  static std::size_t bytes_needed(std::uint32_t capacity);
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<RayPoints> create(std::uint32_t capacity, Arena& arena, const char* stage);

  /// Adds a point with normal `n` at depth z; (dx, dy) is the ray less the point in the plane, mm. The
  /// reach is its caller's to keep.
  void add(float dx, float dy, float z, const Vec3f& n, float inverse_h2) {
    depth[size] = z;
    distance2[size] = dx * dx + dy * dy;
    plane[size] = n[0] * dx + n[1] * dy - n[2] * z;
    slope[size] = n[2];
    inverse_radius2[size] = inverse_h2;
    normal_x[size] = n[0];
    normal_y[size] = n[1];
    offset_x[size] = dx;
    offset_y[size] = dy;
    ++size;
  }
  /// Pads the columns: call it after the last add().
  void close();
};

/// A range of RayPoints, found once for depths close to one another.
struct RayWindow {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};

/// All points of weight at a depth in [low, high].
RayWindow window(const RayPoints& points, float low, float high);

struct MlsValue {
  float distance = 0;  ///< mm, positive outside; 0 where weight is 0
  float weight = 0;    ///< sum of w_i; 0: no point's support reaches here
};

/// Signed distance to the surface through the points around, to second order:
///
///   f(x) = 1/2 [ sum_i v_i <n_i, x - p_i> / V  +  <sum_i v_i n_i, sum_i v_i (x - p_i)> / V^2 ],   V = sum_i v_i
///   v_i(x) = w_i(x) a_i(x)
///   w_i(x) = (1 - |x - p_i|^2 / h_i^2)^2 inside h_i, 0 outside
///   a_i(x) = max(0, 8 <n_i, m> - 7)^2 + 0.02,   m = sum_i w_i n_i / |sum_i w_i n_i|
///   a_i(x) = 1 where the points agree, |sum_i w_i n_i| >= 0.997 sum_i w_i, or where |f| is above a quarter of the reach then
///
/// The first half is the mean distance to the points' tangent planes (Kolluri 2005, eq. 2), which on a curved surface lies
/// outside of it by curvature * E[t^2] / 2, t being the distance of the points along the surface. The second half is the
/// distance to the mean plane (Adamson and Alexa 2003), which lies inside by as much. Their mean has no error of that
/// order, so that supports may be wide enough to average the noise of a scan without rounding what it shows.
///
/// Where a support reaches round an edge, points count the less the more their normals differ from the mean m, and 29
/// degrees from it nearly nothing (Oeztireli, Guennebaud and Gross 2009, without their iteration). The small rest decides
/// where all differ from their mean, as on the two sides of a thin wall.
///
/// The weight is a polynomial of compact support: no exp, no root, the same bits everywhere. Four partial sums are kept
/// and added in a fixed order, so vector units may be used where there are any.
MlsValue mls_value(const RayPoints& points, RayWindow window, float depth);

/// How the points lie round a place of the surface.
struct MlsFrame {
  Vec3f normal = Vec3f::Zero();  ///< weighted mean of theirs, unit length; zero where there is no weight
  float off_centre = 0;  ///< |sum_i w_i (x - p_i)| / sum_i w_i over the largest support: 0 amid them, 1 beyond all
};
MlsFrame mls_frame(const RayPoints& points, RayWindow window, float depth);

}  // namespace plumbline
