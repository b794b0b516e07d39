#pragma once
/// A place seen by several views, and its equations for their motions.

#include <array>
#include <cstdint>

#include "slicer/cloud/kd_tree.hpp"
#include "slicer/views/local_paraboloid.hpp"
#include "slicer/views/moved_views.hpp"

namespace plumbline::inline slicer {

/// The points around a place that a surface goes through. They stay the same while views are moved.
struct PlacePoints {
  static constexpr std::uint32_t kUnknown = ~0U;

  std::uint32_t size = kUnknown;  ///< 0 if the place determines nothing
  std::array<std::uint32_t, LocalParaboloid::kMaxPoints> point;

  /// Finds those around point `i`.
  void find(const Cloud& cloud, const KdTree3& tree, const MovedViews& moved_views, std::uint32_t i);
};

/// The points around a place and the smooth surface through them: how far each point is off it, and how its view would
/// have to move.
struct SharedPlace {
  /// Of one place; further views are left out. Sets the size of `products`.
  static constexpr std::uint32_t kMostViews = 24;

  /// Normal equations of the motions with the surface eliminated: products[v][w] is the coefficient of <lever, motion
  /// of v> times <lever, motion of w>, residuals[v] the right-hand side of v.
  Vec6d lever;
  std::uint32_t views = 0;
  std::array<std::uint8_t, kMostViews> view;
  std::array<double, kMostViews> residuals;
  std::array<std::array<double, kMostViews>, kMostViews> products;

  double mean_square = 0;  ///< distance of the points from the surface, squared

  /// Fits the surface through `near` and sets all of the above.
  /// @returns false if the place determines nothing; then the members are not valid
  bool measure(const MovedViews& moved_views, const PlacePoints& near);

 private:
  void sum_up(const LocalParaboloid& surface, const MovedViews& moved_views, double weight_here);

  std::array<std::uint8_t, LocalParaboloid::kMaxPoints> view_of_;  ///< each kept point's
};

}  // namespace plumbline::inline slicer
