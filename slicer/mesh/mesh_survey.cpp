#include "slicer/mesh/mesh_survey.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// Of the vertices. Exporters leave a few unused; the points of a scan beside a mesh are many.
constexpr double kCovered = 0.95;
/// Of the surface. The open base of a figure has more, a few holes less.
constexpr double kMostOpen = 0.05;

}  // namespace

bool MeshSurvey::is_object() const {
  const bool covered = static_cast<double>(used_vertices) >= kCovered * static_cast<double>(vertices);
  return triangles > 0 && covered && std::sqrt(directed.dot(directed)) <= kMostOpen * area;
}

void Surveyor::add(const Triangle& triangle, bool negative) {
  std::array<Vec3d, 3> p;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = rotation_ * triangle[i];
    if (negative) continue;
    survey_.bounds.extend(p[i]);
    survey_.came.extend(triangle[i]);
  }
  const Vec3d directed = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]);
  if (negative) {
    survey_.cut_area += std::abs(directed[2]);
    return;
  }
  survey_.directed += directed;
  survey_.area += std::sqrt(directed.dot(directed));
  survey_.seen_area += std::abs(directed[2]);
}

void Surveyor::end_file(const MeshSummary& summary) {
  survey_.vertices += summary.vertices;
  survey_.used_vertices += summary.used_vertices;
  survey_.triangles += summary.triangles;
  survey_.most_vertices = std::max(survey_.most_vertices, summary.most_vertices);
}

}  // namespace plumbline::inline slicer
