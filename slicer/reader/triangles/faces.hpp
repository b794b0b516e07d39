#pragma once
/// Faces of an indexed mesh as triangles.

#include <array>
#include <cstdint>

#include "slicer/reader/triangles/triangle_batch.hpp"
#include "slicer/reader/triangles/vertex_list.hpp"

namespace plumbline::inline slicer {

/// Turns the corners of one face after another into a fan of triangles.
class FaceFan {
 public:
  FaceFan(VertexList& vertices, TriangleBatch& batch) : vertices_(vertices), batch_(batch) {}

  void begin() {
    corners_ = 0;
    ++batch_.summary().faces;
  }
  /// @param vertex  below the number of vertices
  [[nodiscard]] Status add(std::uint64_t vertex) {
    vertices_.use(vertex);
    const Vec3d p = vertices_.at(vertex);
    ++corners_;
    if (corners_ == 1) {
      first_ = p;
    } else if (corners_ > 2) {
      PLUMBLINE_TRY(batch_.add({first_, last_, p}));
    }
    last_ = p;
    return {};
  }
  std::uint64_t corners() const { return corners_; }

 private:
  VertexList& vertices_;
  TriangleBatch& batch_;
  Vec3d first_ = Vec3d::Zero();
  Vec3d last_ = Vec3d::Zero();
  std::uint64_t corners_ = 0;
};

/// Turns the corners of a strip into triangles: each with the two corners before it, every second one the other way round.
class FaceStrip {
 public:
  FaceStrip(VertexList& vertices, TriangleBatch& batch) : vertices_(vertices), batch_(batch) {}

  void begin() { corners_ = 0; }
  /// @param vertex  below the number of vertices
  [[nodiscard]] Status add(std::uint64_t vertex) {
    vertices_.use(vertex);
    const std::array<Vec3d, 2> before = last_;
    const Vec3d p = vertices_.at(vertex);
    last_ = {before[1], p};
    if (++corners_ < 3) return {};
    ++batch_.summary().faces;
    return corners_ % 2 == 1 ? batch_.add({before[0], before[1], p}) : batch_.add({before[1], before[0], p});
  }

 private:
  VertexList& vertices_;
  TriangleBatch& batch_;
  std::array<Vec3d, 2> last_ = {Vec3d::Zero(), Vec3d::Zero()};
  std::uint64_t corners_ = 0;
};

}  // namespace plumbline::inline slicer
