#pragma once
/// What a reader of meshes delivers: triangles, and a summary.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// Corners in scan units, counter-clockwise seen from outside of the object. Every number is finite.
using Triangle = std::array<Vec3d, 3>;

/// Receives the triangles in the order of the file, in batches. A face with more than three corners is a fan of triangles from
/// its first corner: in the plane of the face they wind around each place as the face does, even if it is not convex.
class TriangleSink : public ReadProgress {
 public:
  /// @param triangles  one or more, valid only during the call
  [[nodiscard]] virtual Status take(std::span<const Triangle> triangles) = 0;
};

/// What was read from a file.
struct MeshSummary {
  ScanFormat format = ScanFormat::kStl;
  const char* encoding = "";        ///< as ScanHeader::encoding
  bool is_in_mm = false;            ///< as ScanHeader::is_in_mm
  std::uint64_t faces = 0;          ///< in the file
  std::uint64_t triangles = 0;      ///< delivered to the sink
  std::uint64_t not_finite = 0;     ///< triangles left out: a coordinate is NaN, infinite or above kLargestCoordinate
  std::uint64_t vertices = 0;       ///< of an indexed format; 0: STL
  std::uint64_t used_vertices = 0;  ///< of these, those of a face
  std::uint64_t most_vertices = 0;  ///< kept at a time: those of one object
  std::uint64_t bytes = 0;          ///< read from the source
};

/// Scan units. Squares and products of three such numbers stay finite.
inline constexpr double kLargestCoordinate = 1e30;

}  // namespace plumbline
