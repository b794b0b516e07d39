#include "slicer/views/shared_place.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "slicer/cloud/nearest_in_box.hpp"

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

}  // namespace

bool SharedPlace::measure(const Cloud& cloud, const KdTree3& tree, const MovedViews& moved_views, std::uint32_t i) {
  if (moved_views.view_of(i) == kNoView) return false;
  NearestRoom room;
  constexpr std::uint32_t kWanted = LocalParaboloid::kMaxPoints;
  const float radius = moved_views.spacing() * std::sqrt(1.7F * kWanted / std::numbers::pi_v<float>);
  const auto nearest = nearest_in_box(cloud.positions(), tree, cloud.position[i], radius, kWanted, room,
                                      [&](std::uint32_t other) { return moved_views.view_of(other) != kNoView; });
  const Vec3f facing = cloud.normal[i].unpack();
  std::array<Vec3d, LocalParaboloid::kMaxPoints> position;
  std::array<Vec3d, LocalParaboloid::kMaxPoints> ray;
  std::uint32_t bent = 0;
  points = 0;
  for (const Neighbour& n : nearest) {
    const Vec3f normal = cloud.normal[n.index].unpack();
    const float alike = normal.dot(facing);
    if (alike < -kOneWay) continue;  // on the other side of a wall, not at an edge
    if (alike < kMinCosine) {
      ++bent;
      continue;
    }
    ray[points] = moved_views.ray(n.index);
    // A point that faces away from its view is on the view's grid by chance. Such points are few, but where no view saw
    // both an upper and a lower side they alone would determine the distance between the two.
    if (ray[points].dot(normal.cast<double>()) > 0) continue;
    position[points] = moved_views.moved_position(n.index, ray[points]);
    point[points++] = n.index;
  }
  if (static_cast<float>(bent) > kMaxBentShare * static_cast<float>(nearest.size())) return false;
  LocalParaboloid surface;
  if (!surface.fit(std::span(position).first(points))) return false;
  const double weight_here = 1 / (surface.deviation * surface.deviation);
  double weights = 0;
  std::array<double, LocalParaboloid::kMaxPoints> cosine;
  points = surface.size;
  for (std::uint32_t k = 0; k < points; ++k) {
    cosine[k] = ray[surface.point[k]].dot(surface.normal);
    surface.weight[k] = std::abs(cosine[k]) < kMinIncidence ? kGrazingWeight : 1;
    weights += static_cast<double>(surface.weight[k]);
    point[k] = point[surface.point[k]];  // in place, since surface.point[] ascends
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
  views = 0;
  for (std::uint32_t k = 0; k < points; ++k) {
    const std::uint8_t of = moved_views.view_of(point[k]);
    std::uint32_t v = 0;
    while (v < views && view[v] != of) ++v;
    if (v == kMaxViews) continue;
    if (v == views) {
      view[v] = of;
      residuals[v] = 0;
      sums[v].setZero();
      ++views;
    }
    const auto counted = static_cast<double>(surface.weight[k]);
    residuals[v] += weight_here * counted * static_cast<double>(surface.residual[k]);
    sums[v] += counted * surface.terms(k);
    counts[v] += counted;
  }
  const auto factors = surface.gram.ldlt();
  for (std::uint32_t v = 0; v < views; ++v) {
    const Vec6d solved = factors.solve(sums[v]);
    for (std::uint32_t w = 0; w < views; ++w) {
      products[v][w] = weight_here * ((v == w ? counts[v] : 0) - solved.dot(sums[w]));
    }
  }
  lever.head<3>() = surface.normal;
  lever.tail<3>() = surface.mean.cross(surface.normal) / moved_views.extent();
}

}  // namespace plumbline
