#include "slicer/views/shared_place.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "slicer/cloud/nearest_in_box.hpp"
#include "slicer/views/find_views.hpp"

namespace plumbline {
namespace {

constexpr float kMinCosine = 0.8F;  ///< of the normals of one smooth place: within 37 degrees of its middle point's
/// Share of points whose normals differ more; at an edge a paraboloid does not fit.
constexpr float kMaxBentShare = 0.05F;
/// Cosine of ray and normal below which a ray grazes. Noise along a grazing ray moves points outside of a curved
/// surface.
constexpr double kMinIncidence = 0.5;
/// Weight of such points. Not 0: they may be all that determines where their view lies.
constexpr float kGrazingWeight = 0.05F;

/// The rays of each view at a place, where they hardly differ.
class PlaceRays {
 public:
  explicit PlaceRays(const MovedViews& views) : views_(views) {}
  /// The ray of a point's view, at the first point of it that was asked for.
  const Vec3d& operator[](std::uint32_t point) {
    const std::uint8_t view = views_.view_of(point);
    if ((known_ >> view & 1U) == 0) ray_[view] = views_.ray(point);
    known_ |= std::uint64_t{1} << view;
    return ray_[view];
  }

 private:
  const MovedViews& views_;
  std::uint64_t known_ = 0;  ///< a bit a view
  std::array<Vec3d, kMaxViews> ray_;
};
static_assert(kMaxViews <= 64);

}  // namespace

void PlacePoints::find(const Cloud& cloud, const KdTree3& tree, const MovedViews& moved_views, std::uint32_t i) {
  size = 0;
  if (moved_views.view_of(i) == kNoView) return;
  NearestRoom room;
  constexpr std::uint32_t kWanted = LocalParaboloid::kMaxPoints;
  const float radius = moved_views.spacing() * std::sqrt(1.7F * kWanted / std::numbers::pi_v<float>);
  const auto nearest = nearest_in_box(cloud.positions(), tree, cloud.position[i], radius, kWanted, room,
                                      [&](std::uint32_t other) { return moved_views.view_of(other) != kNoView; });
  const Vec3f facing = cloud.normal[i].unpack();
  PlaceRays ray(moved_views);
  std::uint32_t bent = 0;
  for (const Neighbour& n : nearest) {
    const Vec3f normal = cloud.normal[n.index].unpack();
    const float alike = normal.dot(facing);
    if (alike < -kOneWay) continue;  // on the other side of a wall, not at an edge
    if (alike < kMinCosine) {
      ++bent;
      continue;
    }
    // A point that faces away from its view is on the view's grid by chance. Such points are few, but where no view saw
    // both an upper and a lower side they alone would determine the distance between the two.
    if (ray[n.index].dot(normal.cast<double>()) > 0) continue;
    point[size++] = n.index;
  }
  if (static_cast<float>(bent) > kMaxBentShare * static_cast<float>(nearest.size())) size = 0;
}

bool SharedPlace::measure(const MovedViews& moved_views, const PlacePoints& near) {
  PlaceRays ray(moved_views);
  std::array<Vec3d, LocalParaboloid::kMaxPoints> position;
  for (std::uint32_t k = 0; k < near.size; ++k) {
    position[k] = moved_views.moved_position(near.point[k], ray[near.point[k]]);
  }
  LocalParaboloid surface;
  if (!surface.fit(std::span(position).first(near.size))) return false;
  const double weight_here = 1 / (surface.deviation * surface.deviation);
  double weights = 0;
  std::array<double, LocalParaboloid::kMaxPoints> cosine;
  points = surface.size;
  for (std::uint32_t k = 0; k < points; ++k) {
    point[k] = near.point[surface.point[k]];
    view_of[k] = moved_views.view_of(point[k]);
    cosine[k] = ray[point[k]].dot(surface.normal);
    surface.weight[k] = std::abs(cosine[k]) < kMinIncidence ? kGrazingWeight : 1;
    weights += static_cast<double>(surface.weight[k]);
  }
  surface.solve();
  mean_square = 0;
  for (std::uint32_t k = 0; k < points; ++k) {
    const auto counts = static_cast<double>(surface.weight[k]);
    const auto residual = static_cast<double>(surface.residual[k]);
    const double along = weight_here * counts * cosine[k];
    offset[k] = along * residual;
    weight[k] = along * cosine[k];
    mean_square += counts * residual * residual / weights;
  }
  sum_up(surface, moved_views, weight_here);
  return true;
}

void SharedPlace::sum_up(const LocalParaboloid& surface, const MovedViews& moved_views, double weight_here) {
  std::array<Vec6d, kMaxViews> sums;
  std::array<double, kMaxViews> counts = {};
  std::array<std::uint8_t, plumbline::kMaxViews> place_of;  // of a view in `view`
  place_of.fill(kNoView);
  views = 0;
  for (std::uint32_t k = 0; k < points; ++k) {
    const std::uint8_t of = view_of[k];
    if (place_of[of] == kNoView) {
      if (views == kMaxViews) continue;
      place_of[of] = static_cast<std::uint8_t>(views);
      view[views] = of;
      residuals[views] = 0;
      sums[views++].setZero();
    }
    const std::uint8_t v = place_of[of];
    const auto counted = static_cast<double>(surface.weight[k]);
    residuals[v] += weight_here * counted * static_cast<double>(surface.residual[k]);
    sums[v] += counted * surface.terms(k);
    counts[v] += counted;
  }
  const auto factors = surface.gram.ldlt();
  for (std::uint32_t v = 0; v < views; ++v) {
    const Vec6d solved = factors.solve(sums[v]);
    for (std::uint32_t w = 0; w <= v; ++w) {
      products[v][w] = products[w][v] = weight_here * ((v == w ? counts[v] : 0) - solved.dot(sums[w]));
    }
  }
  lever.head<3>() = surface.normal;
  lever.tail<3>() = surface.mean.cross(surface.normal) / moved_views.extent();
}

}  // namespace plumbline
