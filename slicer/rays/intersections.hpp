#pragma once
/// Query points on a ray and its intersections with the MLS surface (thesis III-3).

#include <cstdint>
#include <span>

#include "slicer/core/vec.hpp"
#include "slicer/implicit/mls.hpp"
#include "slicer/rays/ray_points.hpp"

namespace plumbline {

enum class Direction : std::uint8_t { kEntering, kExiting };

/// A place where the ray meets the surface.
struct Intersection {
  float depth = 0;                             ///< z, mm
  Direction direction = Direction::kEntering;  ///< of a ray that goes up
  Vec3f normal = Vec3f::Zero();                ///< of the MLS surface, unit length
  float off_centre = 0;                        ///< MlsFrame::off_centre
};

/// A stretch of the ray on which the MLS value is defined: the union of the points' supports. Outside of all bands the
/// scan says nothing about the ray.
struct Band {
  float low = 0, high = 0;            ///< z, mm
  std::uint32_t first = 0, last = 0;  ///< its intersections
  bool inside_at_low = false;         ///< sign of the MLS value at its ends
  bool inside_at_high = false;
};

/// Numbers of thesis III-3, in units of the grid width w.
struct IntersectionSettings {
  float width = 0.1F;                 ///< w, mm: queries closer than delta = w are merged
  std::uint32_t max_iterations = 10;  ///< of the Illinois method
  float interval = 0.1F;              ///< gamma / w: root found when it is enclosed this narrowly
};

/// What a ray's search found; the spans are the solver's and last until its next call.
struct RaySurface {
  std::span<const Band> bands;                  ///< ascending, disjoint
  std::span<const Intersection> intersections;  ///< ascending
};

/// Solves one ray after another. One object a thread.
class RaySolver {
 public:
  static constexpr std::uint32_t kMaxBands = 256;           ///< a ray; more are joined with the last
  static constexpr std::uint32_t kMaxIntersections = 1024;  ///< a ray; more are not looked for

  static std::size_t bytes_needed();
  [[nodiscard]] static Expected<RaySolver> create(const IntersectionSettings& settings, Arena& arena);

  /// Query points where the points of practical clusters project on the ray, merged within w (thesis III-3.a), the ends of
  /// the bands added; a sign change between two queries of a band encloses an intersection.
  /// @param gatherer  after points_of_ray() for this ray
  RaySurface solve(const RayGatherer& gatherer, const RayPoints& points);

  /// The same with queries spread evenly over the bands (thesis III-4.a), for rays that came out imperfect.
  /// @param spacing  mm
  RaySurface solve_uniform(const RayGatherer& gatherer, const RayPoints& points, float spacing);

 private:
  void find_bands(const RayGatherer& gatherer, const RayPoints& points);
  template <class NextQuery>
  void search(const RayPoints& points, Band& band, NextQuery next_query);
  void solve_root(const RayPoints& points, float low, float low_value, float high, float high_value);
  RaySurface surface() const;

  IntersectionSettings settings_;
  std::span<Band> bands_;
  std::span<Intersection> intersections_;
  std::uint32_t band_count_ = 0;
  std::uint32_t intersection_count_ = 0;
};

}  // namespace plumbline
