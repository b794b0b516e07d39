#pragma once
/// Points on surfaces given by formulas, with exact normals.

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::testing {

inline constexpr double kPi = 3.14159265358979323846;

struct SurfacePoint {
  Vec3d position;
  Vec3d normal;  ///< unit length, outwards
};
using Surface = std::vector<SurfacePoint>;

/// Random numbers that are the same with every standard library; the distributions of <random> are not.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t bits() { return static_cast<std::uint32_t>(engine_()); }
  std::uint32_t below(std::uint32_t end) { return bits() % end; }
  double uniform(double low = 0, double high = 1) { return low + (high - low) * (bits() + 0.5) / 4294967296.0; }
  /// Mean 0, standard deviation 1: the sum of twelve uniform numbers.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
  Vec3d vector() {
    const double x = normal();
    const double y = normal();
    return {x, y, normal()};
  }

 private:
  std::mt19937 engine_;
};

/// Points spread evenly over a sphere (Fibonacci lattice), from top to bottom.
inline Surface sphere(std::uint32_t points, double radius, const Vec3d& centre) {
  constexpr double kGoldenAngle = 2.39996322972865332;
  Surface surface;
  surface.reserve(points);
  for (std::uint32_t i = 0; i < points; ++i) {
    const double z = 1 - 2 * (i + 0.5) / points;
    const double r = std::sqrt(1 - z * z);
    const Vec3d n(r * std::cos(kGoldenAngle * i), r * std::sin(kGoldenAngle * i), z);
    surface.push_back({centre + radius * n, n});
  }
  return surface;
}

/// Number of points of a Fibonacci sphere that are `spacing` apart.
inline std::uint32_t sphere_points(double radius, double spacing) {
  return static_cast<std::uint32_t>(4 * kPi * radius * radius / (spacing * spacing));
}

/// A parallelogram from `corner` along `u` and `v`, with its normal along u x v. Points are moved by up to `jitter` times
/// the spacing within the plane.
inline Surface sheet(const Vec3d& corner, const Vec3d& u, const Vec3d& v, double spacing, double jitter,
                     Random& random) {
  const Vec3d n = u.cross(v).normalized();
  const auto columns = static_cast<std::uint32_t>(std::ceil(u.norm() / spacing));
  const auto rows = static_cast<std::uint32_t>(std::ceil(v.norm() / spacing));
  Surface surface;
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double a = (i + 0.5 + jitter * random.uniform(-1, 1)) / columns;
      const double b = (j + 0.5 + jitter * random.uniform(-1, 1)) / rows;
      surface.push_back({corner + a * u + b * v, n});
    }
  }
  return surface;
}

/// All six sides of the box, normals outwards.
inline Surface box(const Vec3d& low, const Vec3d& high, double spacing, double jitter, Random& random) {
  const Vec3d size = high - low;
  const Vec3d x(size[0], 0, 0);
  const Vec3d y(0, size[1], 0);
  const Vec3d z(0, 0, size[2]);
  Surface all;
  for (const Surface& side :
       {sheet(low, y, x, spacing, jitter, random), sheet(low, x, z, spacing, jitter, random),
        sheet(low, z, y, spacing, jitter, random), sheet(high, -x, -y, spacing, jitter, random),
        sheet(high, -z, -x, spacing, jitter, random), sheet(high, -y, -z, spacing, jitter, random)}) {
    all.insert(all.end(), side.begin(), side.end());
  }
  return all;
}

/// A torus around an axis through `centre`: a tube of radius `tube`, whose centre line is `ring` from the axis.
/// @param axis  2: it lies flat; 0: it stands upright
inline Surface torus(double ring, double tube, const Vec3d& centre, double spacing, int axis) {
  Surface surface;
  const auto around = static_cast<std::uint32_t>(std::ceil(2 * kPi * tube / spacing));
  for (std::uint32_t i = 0; i < around; ++i) {
    const double a = 2 * kPi * i / around;
    const double from_axis = ring + tube * std::cos(a);
    const auto along = static_cast<std::uint32_t>(std::ceil(2 * kPi * from_axis / spacing));
    for (std::uint32_t j = 0; j < along; ++j) {
      const double b = 2 * kPi * (j + 0.37 * (i % 3)) / along;
      Vec3d p(from_axis * std::cos(b), from_axis * std::sin(b), tube * std::sin(a));
      Vec3d n(std::cos(a) * std::cos(b), std::cos(a) * std::sin(b), std::sin(a));
      if (axis == 0) {
        p = Vec3d(p[2], p[0], p[1]);
        n = Vec3d(n[2], n[0], n[1]);
      }
      surface.push_back({centre + p, n});
    }
  }
  return surface;
}

/// Adds normally distributed noise to positions and normals.
inline void add_noise(Surface& surface, double deviation_mm, double normal_deviation, Random& random) {
  for (SurfacePoint& p : surface) {
    p.position += deviation_mm * random.vector();
    p.normal = (p.normal + normal_deviation * random.vector()).normalized();
  }
}

/// Shuffles the points.
inline void shuffle(Surface& surface, Random& random) {
  for (std::uint32_t i = static_cast<std::uint32_t>(surface.size()); i > 1; --i) {
    std::swap(surface[i - 1], surface[random.below(i)]);
  }
}

inline void append(Surface& surface, const Surface& more) { surface.insert(surface.end(), more.begin(), more.end()); }

}  // namespace plumbline::testing
