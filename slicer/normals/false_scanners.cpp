#include "slicer/normals/false_scanners.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "slicer/cloud/tangent_plane.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kAskedOfView = 64;  ///< points of each view, about
constexpr std::uint32_t kFewest = 16;       ///< points of a view that tell anything
/// Share of hidden points above which a scanner is false. Half of a round object is hidden from any place; from true ones less than a tenth,
/// of narrow gaps in sparse scans up to .37.
constexpr double kMostHidden = 0.4;

constexpr std::uint32_t kNearest = 20;  ///< points that tell the tangent plane, and a point's share of the surface
/// Sine of 30 degrees: flatter sight lines stay near their own surface for long.
constexpr double kSteep = 0.5;
// In radii of a point's share: where a sight line has left its own surface, and how near it passes the points of another.
constexpr float kLeft = 6;
constexpr float kPierced = 1.5F;
constexpr int kMostSteps = 100;

/// Whether the line from point i to its scanner passes through surface.
/// @param ray  from the scanner to the point, unit length
/// @returns nothing if the line is too flat to tell
std::optional<bool> is_hidden(const Cloud& cloud, const KdTree3& tree, const Box3f& bounds, std::uint32_t i,
                              const Vec3d& ray) {
  std::array<Neighbour, kNearest> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const std::uint32_t count = tree.nearest(cloud.position[i], found);
  const PrincipalAxes plane = principal_axes(cloud.position[i], std::span(found).first(count), cloud.position);
  if (std::abs(plane.axes.col(0).dot(ray)) < kSteep) return std::nullopt;
  const float radius = std::sqrt(found[count - 1].distance2 / static_cast<float>(count));
  const float length = (cloud.position[i] - cloud.views.scanner[cloud.view_of(i)]).norm();
  float along = kLeft * radius;
  for (int step = 0; step < kMostSteps && along < length; ++step) {
    const Vec3f place = cloud.position[i] - along * ray.cast<float>();
    if ((place.array() < bounds.low.array()).any() || (place.array() > bounds.high.array()).any()) return false;
    std::array<Neighbour, 1> nearest;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    if (tree.nearest(place, nearest) == 0) return false;
    const float distance = std::sqrt(nearest[0].distance2);
    if (distance < kPierced * radius) return true;
    along += std::max(distance - radius, radius / 2);
  }
  return false;
}

}  // namespace

void forget_false_scanners(Cloud& cloud, const KdTree3& tree) {
  if (cloud.views.scanners() == 0) return;
  struct Answers {
    std::uint32_t asked = 0;
    std::uint32_t hidden = 0;
  };
  std::array<Answers, kMaxViews> answers;
  const Box3f bounds = cloud.bounds();
  const std::uint32_t samples = std::min(cloud.size, kAskedOfView * cloud.views.scanners());
  for (std::uint32_t s = 0; s < samples; ++s) {
    const std::uint32_t i = cloud.sampled(s, samples);
    const auto ray = cloud.views.ray(cloud.view_of(i), cloud.position[i]);
    const auto hidden = ray ? is_hidden(cloud, tree, bounds, i, *ray) : std::nullopt;
    if (!hidden) continue;
    Answers& view = answers[cloud.view_of(i)];
    ++view.asked;
    view.hidden += *hidden ? 1 : 0;
  }
  for (std::uint32_t v = 0; v < cloud.views.count; ++v) {
    if (answers[v].asked >= kFewest && answers[v].hidden > kMostHidden * answers[v].asked) {
      cloud.views.has_scanner[v] = false;
    }
  }
}

}  // namespace plumbline::inline slicer
