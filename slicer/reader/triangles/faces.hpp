#pragma once
/// Faces of an indexed mesh as triangles.

#include <cstdint>

#include "slicer/reader/triangles/triangle_batch.hpp"
#include "slicer/reader/triangles/vertex_list.hpp"

namespace plumbline {

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

}  // namespace plumbline
