#pragma once
/// Scans whose normals face into the object, in the ways that exporters get them wrong.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/slicer/support/surfaces.hpp"

namespace plumbline::testing {

enum class WrongNormals : std::uint8_t {
  kAllInward,
  kViewsAtRandom,  ///< those of each view face one side, at random
  kHalfAtRandom,   ///< half of all points
  kAbsent,
};
inline constexpr std::array<WrongNormals, 4> kWrongNormals = {WrongNormals::kAllInward, WrongNormals::kViewsAtRandom,
                                                              WrongNormals::kHalfAtRandom, WrongNormals::kAbsent};

inline const char* to_string(WrongNormals wrong) {
  switch (wrong) {
    case WrongNormals::kAllInward: return "AllInward";
    case WrongNormals::kViewsAtRandom: return "ViewsAtRandom";
    case WrongNormals::kHalfAtRandom: return "HalfAtRandom";
    case WrongNormals::kAbsent: return "Absent";
  }
  return "";
}

/// Deals the points of a surface out to the twelve views from the corners of an icosahedron: each point to one of those that
/// see it at less than 70 degrees.
/// @returns the view of each point
inline std::vector<std::size_t> deal_to_views(const Surface& surface, Random& random) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3d> views;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      views.insert(views.end(),
                   {Vec3d(0, a, b).normalized(), Vec3d(a, b, 0).normalized(), Vec3d(b, 0, a).normalized()});
    }
  }
  std::vector<std::size_t> view_of;
  for (const SurfacePoint& p : surface) {
    std::vector<std::size_t> sees;
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (views[v].dot(p.normal) > 0.34) sees.push_back(v);
    }
    view_of.push_back(sees[random.below(static_cast<std::uint32_t>(sees.size()))]);
  }
  return view_of;
}

/// @param view_of  of each point; read for kViewsAtRandom only
inline Surface with_wrong_normals(Surface surface, WrongNormals wrong, const std::vector<std::size_t>& view_of,
                                  Random& random) {
  std::vector<bool> view_is_wrong;
  if (wrong == WrongNormals::kViewsAtRandom) {
    view_is_wrong.resize(*std::max_element(view_of.begin(), view_of.end()) + 1);
    for (std::size_t v = 0; v < view_is_wrong.size(); ++v) view_is_wrong[v] = random.below(2) == 1;
  }
  for (std::size_t i = 0; i < surface.size(); ++i) {
    Vec3d& n = surface[i].normal;
    switch (wrong) {
      case WrongNormals::kAllInward: n = -n; break;
      case WrongNormals::kViewsAtRandom: n *= view_is_wrong[view_of[i]] ? -1 : 1; break;
      case WrongNormals::kHalfAtRandom: n *= random.below(2) == 1 ? -1 : 1; break;
      case WrongNormals::kAbsent: n.setZero(); break;
    }
  }
  return surface;
}

}  // namespace plumbline::testing
