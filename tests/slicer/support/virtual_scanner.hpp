#pragma once
/// Range images of solids with thin walls and holes, which are given by their distance functions.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/slicer/support/scan_cloud.hpp"

namespace plumbline::testing {

/// Signed distance, negative inside; outside never more than the true one. mm.
using DistanceFunction = double (*)(const Vec3d& p);

inline double distance_to_box(const Vec3d& p, const Vec3d& half) {
  const Vec3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
}

struct ThinSolid {
  const char* name;
  DistanceFunction distance;
};

/// All around the origin, 18 to 30 mm long.
inline constexpr std::array<ThinSolid, 5> kThinSolids = {{
    {"plate .4 mm thick with six holes",
     [](const Vec3d& p) {
       double solid = distance_to_box(p, {15, 10, .2});
       for (const double x : {-9.0, 0.0, 9.0}) {
         for (const double y : {-4.5, 4.5}) solid = std::max(solid, 2 - std::hypot(p[0] - x, p[1] - y));
       }
       return solid;
     }},
    {"open box with walls of .6 mm",
     [](const Vec3d& p) {
       return std::max(distance_to_box(p, {10, 8, 6}), -distance_to_box(p - Vec3d(0, 0, 1.2), {9.4, 7.4, 6.6}));
     }},
    {"tube with a wall of .5 mm",
     [](const Vec3d& p) {
       const double r = std::hypot(p[0], p[1]);
       return std::max({r - 6, 5.5 - r, std::abs(p[2]) - 9});
     }},
    {"torus", [](const Vec3d& p) { return std::hypot(std::hypot(p[0], p[1]) - 9, p[2]) - 2.5; }},
    {"comb with teeth of .6 mm",
     [](const Vec3d& p) {
       double solid = distance_to_box(p + Vec3d(0, 0, 4), {12, 4, 1.5});
       for (int t = -5; t <= 5; ++t) solid = std::min(solid, distance_to_box(p - Vec3d(2.2 * t, 0, 1), {.3, 4, 4}));
       return solid;
     }},
}};

/// What scanners at some places see of a solid.
struct SeenSurface {
  std::vector<Vec3d> scanners;
  Surface points;
  std::vector<std::uint8_t> view_of;  ///< of each point
};

/// A scanner in each corner of an icosahedron around the origin, each with a range image.
/// @param pitch  of its pixels at the distance of the origin, mm
/// @param noise  of the range, mm
inline SeenSurface scan_all_around(DistanceFunction distance, double pitch, double noise = 0) {
  constexpr double kFar = 150;
  constexpr double kHalf = 20;  ///< of the image, mm
  const double g = (1 + std::sqrt(5.0)) / 2;
  SeenSurface seen;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      for (const Vec3d& v : {Vec3d(0, a, b), Vec3d(a, b, 0), Vec3d(b, 0, a)}) {
        seen.scanners.push_back(kFar * v.normalized());
      }
    }
  }
  Random random(5);
  for (std::size_t view = 0; view < seen.scanners.size(); ++view) {
    const Vec3d& eye = seen.scanners[view];
    const Vec3d right = eye.cross(Vec3d(.3, .5, .8)).normalized();
    const Vec3d up = eye.cross(right).normalized();
    for (double v = -kHalf; v < kHalf; v += pitch) {
      for (double u = -kHalf; u < kHalf; u += pitch) {
        const Vec3d ray = (u * right + v * up - eye).normalized();
        double range = kFar - 1.5 * kHalf;
        double left = distance(eye + range * ray);
        while (left > 1e-6 && range < kFar + 1.5 * kHalf) {
          range += left;
          left = distance(eye + range * ray);
        }
        if (left > 1e-6) continue;
        const Vec3d hit = eye + range * ray;
        Vec3d normal;
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3d step = 1e-5 * Vec3d::Unit(axis);
          normal[axis] = distance(hit + step) - distance(hit - step);
        }
        seen.points.push_back({hit + noise * random.normal() * ray, normal.normalized()});
        seen.view_of.push_back(static_cast<std::uint8_t>(view));
      }
    }
  }
  return seen;
}

/// The seen points as a cloud with their views.
inline Cloud cloud_of(const SeenSurface& seen, Arena& arena) {
  Cloud cloud = value_of(Cloud::create(static_cast<std::uint32_t>(seen.points.size()), arena, true));
  for (const Vec3d& scanner : seen.scanners) {
    cloud.views.scanner[cloud.views.count] = scanner.cast<float>();
    cloud.views.has_scanner[cloud.views.count++] = true;
  }
  for (const SurfacePoint& p : seen.points) {
    cloud.views.of[cloud.size] = seen.view_of[cloud.size];
    cloud.position[cloud.size] = p.position.cast<float>();
    cloud.normal[cloud.size] = {};
    cloud.normal[cloud.size].set(p.normal.cast<float>());
    cloud.radius[cloud.size++] = 0;
  }
  return cloud;
}

}  // namespace plumbline::testing
