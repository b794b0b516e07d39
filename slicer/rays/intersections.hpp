#pragma once
/// Query points on a ray and its intersections with the MLS surface (thesis III-3).

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/implicit/mls.hpp"
#include "slicer/rays/ray_points.hpp"

namespace plumbline::inline slicer {

/// A zero of the MLS value on the ray: the ray meets the surface.
struct Intersection {
  float depth = 0;       ///< z, mm
  float off_centre = 0;  ///< off_centre() of the points there
};

/// A stretch of the ray on which the MLS value is defined: the union of the points' support radii. The scan says nothing about
/// the ray outside of all bands.
struct Band {
  float low = 0, high = 0;            ///< z, mm
  std::uint32_t first = 0, last = 0;  ///< its intersections
  bool inside_at_low = false;         ///< sign of the MLS value at the ends
  bool inside_at_high = false;
};

/// A place on a ray and the MLS value there.
struct RayQuery {
  float depth = 0;  ///< z, mm
  MlsValue value;
  /// Where the tangent plane crosses the ray, mm.
  float sheet() const { return depth - value.distance / value.slope; }
};

/// Result of the search on one ray. The spans are valid until the solver's next call.
struct RaySurface {
  std::span<const Band> bands;                  ///< ascending, disjoint
  std::span<const Intersection> intersections;  ///< ascending
};

/// Finds the intersections of one ray after another. One object a thread.
class RaySolver {
 public:
  static constexpr std::uint32_t kMaxBands = 256;           ///< a ray; further ones are joined with the last
  static constexpr std::uint32_t kMaxIntersections = 1024;  ///< a ray; further ones are ignored

  // Thesis III-3.b.
  static constexpr std::uint32_t kMostIterations = 10;  ///< of the Illinois method
  static constexpr float kInterval = 0.1F;              ///< gamma / w: a root enclosed this narrowly is found

  RaySolver() = default;
  /// @param width  w, mm: queries closer than delta = w are merged
  explicit RaySolver(float width) : width_(width) {}

  /// Queries the MLS value at the depths of the points, merged within w (thesis III-3.a), and at the ends of the bands. A sign
  /// change between two queries of a band encloses an intersection.
  /// @param gatherer  after points_of_ray() for this ray
  RaySurface solve(const RayGatherer& gatherer, const RayPoints& points);

  /// Finds the intersection near a predicted depth: one step along the slope, then the secant.
  /// @param most_off_centre  most that the points may lie to one side: off_centre()
  /// @returns mm; nothing if the steps don't converge to a zero with this direction
  std::optional<float> solve_near(const RayPoints& points, float depth, bool entering, float most_off_centre) const;

 private:
  void find_bands(const RayGatherer& gatherer, const RayPoints& points);
  void search(const RayPoints& points, Band& band, RayWindow& near, std::uint32_t& candidate);
  void solve_between(const RayPoints& points, RayWindow hint, const RayQuery& low, const RayQuery& high);
  void solve_root(const RayPoints& points, RayWindow hint, float low, float low_value, float high, float high_value);

  float width_ = 0;
  std::array<Band, kMaxBands> bands_;
  std::array<Intersection, kMaxIntersections> intersections_;
  std::uint32_t band_count_ = 0;
  std::uint32_t intersection_count_ = 0;
};

}  // namespace plumbline::inline slicer
