#include "slicer/views/shared_place.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <span>

namespace plumbline {
namespace {

constexpr float kLeastCosine = 0.8F;     ///< of two normals of one smooth place
constexpr float kMostBent = 0.05F;       ///< of a place's points: about an edge a paraboloid tells nothing
constexpr float kFacingAway = -0.5F;     ///< cosine: the other side of a wall
constexpr double kLeastIncidence = 0.5;  ///< cosine: noise along a grazing ray puts points outside of what is curved;
constexpr double kGrazing = 0.05;        ///< weight of these, which may be all that tells where their view is

}  // namespace

bool SharedPlace::look_at(const Cloud& cloud, const KdTree3& tree, const MovedViews& views_now, std::uint32_t i) {
  if (views_now.view_of(i) == kNoView) return false;
  std::array<Neighbour, LocalForm::kMostPoints> found = {};
  const std::uint32_t count =
      tree.nearest(cloud.position[i], found, [&](std::uint32_t other) { return views_now.view_of(other) != kNoView; });
  const Vec3f facing = cloud.normal[i].unpack();
  std::array<Vec3d, LocalForm::kMostPoints> position;
  std::array<Vec3d, LocalForm::kMostPoints> ray;
  std::uint32_t bent = 0;
  points = 0;
  for (const Neighbour& n : std::span(found).first(count)) {
    const Vec3f normal = cloud.normal[n.index].unpack();
    const float alike = normal.dot(facing);
    if (alike < kFacingAway) continue;
    if (alike < kLeastCosine) {
      ++bent;
      continue;
    }
    ray[points] = views_now.ray(n.index);
    // No view sees what faces away from it: such a point lies on the view's grid by chance. They are few, but where an upper
    // and a lower side have no view in common they would be all that says how these lie to each other.
    if (ray[points].dot(normal.cast<double>()) > 0) continue;
    position[points] = views_now.moved(n.index);
    point[points++] = n.index;
  }
  if (static_cast<float>(bent) > kMostBent * static_cast<float>(count)) return false;
  LocalForm form;
  if (!form.fit(std::span(position).first(points))) return false;
  const double weight_here = 1 / (form.deviation * form.deviation);
  double weights = 0;
  std::array<double, LocalForm::kMostPoints> cosine;
  points = form.size;
  for (std::uint32_t k = 0; k < points; ++k) {
    cosine[k] = ray[form.point[k]].dot(form.normal);
    form.weight[k] = std::abs(cosine[k]) < kLeastIncidence ? kGrazing : 1;
    weights += form.weight[k];
    point[k] = point[form.point[k]];  // which are in order
  }
  form.solve();
  mean_square = 0;
  for (std::uint32_t k = 0; k < points; ++k) {
    const double along = weight_here * form.weight[k] * cosine[k];
    off[k] = along * form.residual[k];
    weight[k] = along * cosine[k];
    mean_square += form.weight[k] * form.residual[k] * form.residual[k] / weights;
  }
  sum_up(form, views_now, weight_here);
  return true;
}

void SharedPlace::sum_up(const LocalForm& form, const MovedViews& views_now, double weight_here) {
  std::array<Vec6d, kMostViews> sums;
  std::array<double, kMostViews> counts = {};
  views = 0;
  for (std::uint32_t k = 0; k < points; ++k) {
    const std::uint8_t of = views_now.view_of(point[k]);
    std::uint32_t v = 0;
    while (v < views && view[v] != of) ++v;
    if (v == kMostViews) continue;
    if (v == views) {
      view[v] = of;
      residuals[v] = 0;
      sums[v].setZero();
      ++views;
    }
    residuals[v] += weight_here * form.weight[k] * form.residual[k];
    sums[v] += form.weight[k] * form.terms[k];
    counts[v] += form.weight[k];
  }
  const auto factors = form.gram.ldlt();
  for (std::uint32_t v = 0; v < views; ++v) {
    const Vec6d solved = factors.solve(sums[v]);
    for (std::uint32_t w = 0; w < views; ++w) {
      products[v][w] = weight_here * ((v == w ? counts[v] : 0) - solved.dot(sums[w]));
    }
  }
  lever.head<3>() = form.normal;
  lever.tail<3>() = form.mean.cross(form.normal) / views_now.extent();
}

}  // namespace plumbline
