#pragma once
/// The moving-least-squares surface along one ray (thesis III-3).

#include <array>
#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// The points within whose support radius a ray at (x, y) passes, as columns sorted by depth. No other point has weight
/// anywhere on the ray, so one search in the plane serves the whole ray.
///
/// The columns are padded with kLanes (core/numbers/lanes.hpp) entries that have no weight anywhere: distance2 = 1, inverse_radius2 = 2.
struct RayPoints {
  float* depth = nullptr;            ///< z of the point, mm, ascending
  float* distance2 = nullptr;        ///< squared distance of the point from the ray, in the plane, mm^2
  float* plane = nullptr;            ///< <n, (x, y, 0) - p>, mm: distance to the tangent plane at depth 0
  float* slope = nullptr;            ///< n_z: change of that distance with depth
  float* inverse_radius2 = nullptr;  ///< 1 / h^2, mm^-2; h is the support radius
  float* normal_x = nullptr;
  float* normal_y = nullptr;
  float* offset_x = nullptr;  ///< x of the ray minus x of the point, mm
  float* offset_y = nullptr;
  float* mass = nullptr;  ///< points of the scan that it stands for
  std::uint32_t size = 0;
  float reach = 0;  ///< largest h, mm: no point farther away in depth has weight

  static constexpr auto columns() {
    using Points = RayPoints;
    return std::array{&Points::depth,           &Points::distance2, &Points::plane,    &Points::slope,
                      &Points::inverse_radius2, &Points::normal_x,  &Points::normal_y, &Points::offset_x,
                      &Points::offset_y,        &Points::mass};
  }

  /// Bytes of arena for `capacity` points.
  static std::size_t bytes_needed(std::uint32_t capacity);
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<RayPoints> create(std::uint32_t capacity, Arena& arena, const char* stage);

  /// Adds a point with normal `n` at depth z; (dx, dy) is the ray minus the point in the plane, mm. The caller updates
  /// `reach`.
  void add(float dx, float dy, float z, const Vec3f& n, float inverse_h2, float points = 1) {
    depth[size] = z;
    distance2[size] = dx * dx + dy * dy;
    plane[size] = n[0] * dx + n[1] * dy - n[2] * z;
    slope[size] = n[2];
    inverse_radius2[size] = inverse_h2;
    normal_x[size] = n[0];
    normal_y[size] = n[1];
    offset_x[size] = dx;
    offset_y[size] = dy;
    mass[size] = points;
    ++size;
  }
  /// Sets entry j to entry t of `from`.
  void copy(std::uint32_t j, const RayPoints& from, std::uint32_t t) {
    for (const auto column : columns()) (this->*column)[j] = (from.*column)[t];
  }
  /// Pads the columns. Call it after the last add().
  void close();
  /// `count` points from `first` on. What follows them stands for the padding: the caller knows that it has no weight.
  RayPoints part(std::ptrdiff_t first, std::uint32_t count) const;
};

/// A range of RayPoints, found once for depths that are close together.
struct RayWindow {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};

/// All points that have weight at some depth in [low, high].
/// @param hint  a window of lower depths, from which the search begins; queries that ascend take no time to search
RayWindow window(const RayPoints& points, float low, float high, RayWindow hint = {});

struct MlsValue {
  float distance = 0;     ///< mm, positive outside; 0 where weight is 0
  float weight = 0;       ///< sum of w_i; 0: outside all support radii
  float slope = 0;        ///< change of the distance with depth, nearly: z of the mean normal
  float off_centre2 = 0;  ///< square of off_centre()
};

/// Signed distance to the surface through the neighbouring points, to second order:
///
///   f(x) = 1/2 [ sum_i v_i <n_i, x - p_i> / V  +  <sum_i v_i n_i, sum_i v_i (x - p_i)> / V^2 ],   V = sum_i v_i
///   v_i(x) = w_i(x) a_i(x) m_i,   m_i is the number of points that were joined to point i
///   w_i(x) = (1 - |x - p_i|^2 / h_i^2)^2 inside h_i, 0 outside
///   a_i(x) = max(0, 8 <n_i, m> - 7)^2 + 0.02 if <n_i, m> > 0, else 0,   m = sum_i w_i n_i / |sum_i w_i n_i|
///   a_i(x) = 1 if the normals agree, |sum_i w_i n_i| >= 0.997 sum_i w_i, or if |f| with a_i = 1 exceeds a quarter of the reach
///
/// The first term is the mean distance to the points' tangent planes (Kolluri 2005, eq. 2). On a curved surface its zero lies
/// outside by curvature * E[t^2] / 2, t being the distance of the points along the surface. The second term is the distance
/// to the mean plane (Adamson and Alexa 2003), whose zero lies inside by as much. Their mean cancels the error of that order,
/// so support radii can be wide enough to average noise without rounding curvature.
///
/// Near an edge, a_i lowers the weight of points whose normals differ from the mean m, nearly to nothing at 29 degrees
/// (Oeztireli, Guennebaud and Gross 2009, without their iteration). The constant 0.02 decides where all normals differ from
/// their mean.
///
/// Of a wall thinner than the support radii, or of such a gap, x has points of both faces around it, and their mean tells neither
/// face. So if |sum_i w_i n_i| < 1/2 sum_i w_i, m is the mean normal of the nearer face: of the points with <n_i, s> > 0, weighted by
/// <n_i, s>^2 + 0.02,
///
///   s = (x - c) / |x - c| if d > 0, the opposite if d < 0,   c = sum_i w_i p_i / sum_i w_i,   d = sum_i w_i <n_i, p_i - c> / sum_i w_i
///
/// d is positive of a wall, whose points face away from their middle c, and negative of a gap. Where |d| is below 1/20 of the reach,
/// or the normals of the face don't agree (|sum w n| < 0.85 sum w), a_i is that above.
///
/// The weight is a polynomial of compact support: no exp and no root, so all machines compute the same bits. Four partial
/// sums are added in a fixed order, so vector units may be used.
MlsValue mls_value(const RayPoints& points, RayWindow window, float depth);

/// |sum_i w_i (x - p_i)| / (reach sum_i w_i): 0 in the middle of the points, 1 beyond all of them; 0 where there is no weight.
float off_centre(const RayPoints& points, RayWindow window, float depth);

}  // namespace plumbline::inline slicer
