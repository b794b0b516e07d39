#pragma once
/// Query points on a ray and its intersections with the MLS surface (thesis III-3).

#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/numbers/vec.hpp"
#include "slicer/implicit/mls.hpp"
#include "slicer/rays/ray_points.hpp"

namespace plumbline {

enum class Direction : std::uint8_t { kEntering, kExiting };

/// A zero of the MLS value on the ray: the ray meets the surface.
struct Intersection {
  float depth = 0;                             ///< z, mm
  Direction direction = Direction::kEntering;  ///< of a ray that goes up
  Vec3f normal = Vec3f::Zero();                ///< of the MLS surface, unit length
  float off_centre = 0;                        ///< MlsFrame::off_centre
};

/// A stretch of the ray on which the MLS value is defined: the union of the points' support radii. The scan says nothing about
/// the ray outside of all bands.
struct Band {
  float low = 0, high = 0;            ///< z, mm
  std::uint32_t first = 0, last = 0;  ///< its intersections
  bool inside_at_low = false;         ///< sign of the MLS value at the ends
  bool inside_at_high = false;
};

/// Parameters of thesis III-3, relative to the grid width w.
struct IntersectionSettings {
  float width = 0.1F;                 ///< w, mm: queries closer than delta = w are merged
  std::uint32_t max_iterations = 10;  ///< of the Illinois method
  float interval = 0.1F;              ///< gamma / w: root found when it is enclosed this narrowly
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

  static std::size_t bytes_needed();
  [[nodiscard]] static Expected<RaySolver> create(const IntersectionSettings& settings, Arena& arena);

  /// Queries the MLS value at the depths of the points, merged within w (thesis III-3.a), and at the ends of the bands. A sign
  /// change between two queries of a band encloses an intersection.
  /// @param gatherer  after points_of_ray() for this ray
  RaySurface solve(const RayGatherer& gatherer, const RayPoints& points);

  /// Finds the intersection near a predicted depth: one step along the slope, then the secant.
  /// @param off_centre  most that the points may lie to one side (MlsFrame::off_centre)
  /// @returns mm; nothing if the steps don't converge to a zero with this direction
  std::optional<float> solve_near(const RayPoints& points, float depth, bool entering, float off_centre) const;

 private:
  void find_bands(const RayGatherer& gatherer, const RayPoints& points);
  void search(const RayPoints& points, Band& band, RayWindow& near, std::uint32_t& candidate);
  void solve_between(const RayPoints& points, RayWindow hint, const RayQuery& low, const RayQuery& high);
  void solve_root(const RayPoints& points, RayWindow hint, float low, float low_value, float high, float high_value);
  RaySurface surface() const;

  IntersectionSettings settings_;
  std::span<Band> bands_;
  std::span<Intersection> intersections_;
  std::uint32_t band_count_ = 0;
  std::uint32_t intersection_count_ = 0;
};

}  // namespace plumbline
