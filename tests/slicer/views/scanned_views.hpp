#pragma once
/// An ellipsoid as cameras see it: noise moves each point along the ray of its pixel, and each view is slightly off.

#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/slicer/support/surfaces.hpp"

namespace plumbline::testing {

struct ScannedViews {
  Surface surface;
  std::vector<Vec3d> unmoved;      ///< each point without the motion of its view, mm
  std::vector<std::uint8_t> view;  ///< view of each point
};

struct Cameras {
  std::uint32_t views = 12;  ///< 255 at most
  double pixel = 0.4;        ///< mm, on a plane through the middle of the ellipsoid
  double noise = 0.05;       ///< standard deviation along the ray, mm
  double shift = 0.05;       ///< standard deviation over the views along each axis, mm
  double turn = 0.002;       ///< standard deviation over the views about each axis, radians
};

inline const Vec3d kEllipsoid = {20, 15, 12};  ///< semi-axes, mm

/// Cameras stand 150 mm from the middle, on all sides. Points seen at up to 75 degrees to the normal are kept. Shifts
/// and turns have a mean of 0 over the views.
inline ScannedViews scan_ellipsoid(const Cameras& cameras, std::uint32_t seed) {
  constexpr double kDistance = 150;
  constexpr double kLeastCosine = 0.26;
  Random random(seed);
  std::vector<Vec3d> shifts(cameras.views);
  std::vector<Vec3d> turns(cameras.views);
  Vec3d mean_shift = Vec3d::Zero();
  Vec3d mean_turn = Vec3d::Zero();
  for (std::uint32_t v = 0; v < cameras.views; ++v) {
    shifts[v] = cameras.shift * random.vector();
    turns[v] = cameras.turn * random.vector();
    mean_shift += shifts[v] / cameras.views;
    mean_turn += turns[v] / cameras.views;
  }
  ScannedViews scan;
  const Surface stations = sphere(cameras.views, kDistance, Vec3d::Zero());
  const auto half = static_cast<int>(kEllipsoid.maxCoeff() * 1.2 / cameras.pixel);
  for (std::uint32_t v = 0; v < cameras.views; ++v) {
    const Vec3d eye = stations[v].position;
    const Vec3d ahead = -stations[v].normal;
    const Vec3d right = ahead.cross(Vec3d(0.3, 0.2, 0.9)).normalized();
    const Vec3d down = ahead.cross(right);
    for (int j = -half; j <= half; ++j) {
      for (int i = -half; i <= half; ++i) {
        const Vec3d ray = (ahead * kDistance + (right * i + down * j) * cameras.pixel).normalized();
        // |(eye + t ray) / axes| = 1
        const Vec3d e = eye.cwiseQuotient(kEllipsoid);
        const Vec3d r = ray.cwiseQuotient(kEllipsoid);
        const double under_root = e.dot(r) * e.dot(r) - r.dot(r) * (e.dot(e) - 1);
        if (under_root < 0) continue;
        const double t = (-e.dot(r) - std::sqrt(under_root)) / r.dot(r);
        const Vec3d at = eye + t * ray;
        const Vec3d normal = at.cwiseQuotient(kEllipsoid.cwiseProduct(kEllipsoid)).normalized();
        if (-normal.dot(ray) < kLeastCosine) continue;
        const Vec3d seen = at + ray * (cameras.noise * random.normal());
        scan.unmoved.push_back(seen);
        scan.view.push_back(static_cast<std::uint8_t>(v));
        scan.surface.push_back({seen + (turns[v] - mean_turn).cross(seen) + shifts[v] - mean_shift, normal});
      }
    }
  }
  return scan;
}

}  // namespace plumbline::testing
