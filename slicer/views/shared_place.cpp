#include "slicer/views/shared_place.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "slicer/cloud/nearest_by_radius.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr float kMinCosine = 0.8F;  ///< of the normals of one smooth place: within 37 degrees of its middle point's
/// Share of points whose normals differ more; at an edge a paraboloid does not fit.
constexpr float kMaxBentShare = 0.05F;
/// Cosine of ray and normal below which a ray grazes. Noise along a grazing ray moves points outside of a curved
/// surface.
constexpr double kMinIncidence = 0.5;
/// Weight of such points. Not 0: they may be all that determines where their view lies.
constexpr float kGrazingWeight = 0.05F;

}  // namespace

void PlacePoints::find(const Cloud& cloud, const KdTree3& tree, const MovedViews& moved_views, std::uint32_t i) {
  size = 0;
  if (moved_views.view_of(i) == kNoView) return;
  NearestRoom room;
  constexpr std::uint32_t kWanted = LocalParaboloid::kMaxPoints;
  const float radius = moved_views.spacing() * std::sqrt(1.7F * kWanted / std::numbers::pi_v<float>);
  const auto nearest = nearest_by_radius(tree, cloud.position[i], radius, kWanted, room, NearestOrder::kOfPoints,
                                         [&](std::uint32_t other) { return moved_views.view_of(other) != kNoView; });
  const Vec3f facing = cloud.normal[i].unpack();
  std::uint32_t bent = 0;
  for (const Neighbour& n : nearest) {
    const Vec3f normal = cloud.normal[n.index].unpack();
    const float alike = normal.dot(facing);
    if (alike < -kOneWay) continue;  // on the other side of a wall, not at an edge
    if (alike < kMinCosine) {
      ++bent;
      continue;
    }
    point[size++] = n.index;
  }
  if (static_cast<float>(bent) > kMaxBentShare * static_cast<float>(nearest.size())) size = 0;
}

bool SharedPlace::measure(const MovedViews& moved_views, const PlacePoints& near) {
  std::array<Vec3d, LocalParaboloid::kMaxPoints> position;
  for (std::uint32_t k = 0; k < near.size; ++k) position[k] = moved_views.moved_position(near.point[k]);
  LocalParaboloid surface;
  if (!surface.fit(std::span(position).first(near.size))) return false;
  const double weight_here = 1 / (surface.deviation * surface.deviation);
  double weights = 0;
  for (std::uint32_t k = 0; k < surface.size; ++k) {
    const std::uint32_t i = near.point[surface.point[k]];
    view_of_[k] = moved_views.view_of(i);
    const auto ray = moved_views.ray(i);
    surface.weight[k] = ray && std::abs(ray->dot(surface.normal)) < kMinIncidence ? kGrazingWeight : 1;
    weights += static_cast<double>(surface.weight[k]);
  }
  surface.solve();
  mean_square = 0;
  for (std::uint32_t k = 0; k < surface.size; ++k) {
    const auto residual = static_cast<double>(surface.residual[k]);
    mean_square += static_cast<double>(surface.weight[k]) * residual * residual / weights;
  }
  sum_up(surface, moved_views, weight_here);
  return true;
}

void SharedPlace::sum_up(const LocalParaboloid& surface, const MovedViews& moved_views, double weight_here) {
  std::array<Vec6d, kMostViews> sums;
  std::array<double, kMostViews> counts = {};
  std::array<std::uint8_t, MovedViews::kMost> place_of;  // of a view in `view`
  place_of.fill(kNoView);
  views = 0;
  for (std::uint32_t k = 0; k < surface.size; ++k) {
    const std::uint8_t of = view_of_[k];
    if (place_of[of] == kNoView) {
      if (views == kMostViews) continue;
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

}  // namespace plumbline::inline slicer
