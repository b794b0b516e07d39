#pragma once
/// What a place that several views have seen says of how they lie to each other.

#include <array>
#include <cstdint>

#include "slicer/cloud/kd_tree.hpp"
#include "slicer/views/local_form.hpp"
#include "slicer/views/moved_views.hpp"

namespace plumbline {

/// The points about a place, and the smooth surface through them: how far each is off, and what the views that they are of
/// would have to move by.
struct SharedPlace {
  static constexpr std::uint32_t kMostViews = 24;  ///< of a place; more are left out

  /// For its views v and w, products[v][w] of <lever, motion of v> with that of w, and residuals[v]: an equation of the
  /// motions, the surface eliminated.
  Vec6d lever;
  std::uint32_t views = 0;
  std::array<std::uint8_t, kMostViews> view;
  std::array<double, kMostViews> residuals;
  std::array<std::array<double, kMostViews>, kMostViews> products;

  double mean_square = 0;  ///< of the points from the surface, mm^2
  std::uint32_t points = 0;
  std::array<std::uint32_t, LocalForm::kMostPoints> point;
  std::array<double, LocalForm::kMostPoints> off;  ///< mm that it is too far along its ray, times:
  std::array<double, LocalForm::kMostPoints> weight;

  /// @param i  the point that the place is about
  /// @returns false where it says nothing, and nothing of this is set
  bool look_at(const Cloud& cloud, const KdTree3& tree, const MovedViews& views_now, std::uint32_t i);

 private:
  void sum_up(const LocalForm& form, const MovedViews& views_now, double weight_here);
};

}  // namespace plumbline
