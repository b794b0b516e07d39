#pragma once
/// The header of a PLY file.

#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/reader/records/record.hpp"
#include "slicer/reader/stream/line_input.hpp"

namespace plumbline::inline slicer {

struct PlyElement {
  std::uint64_t count = 0;
  RecordLayout layout;
};

struct PlyHeader {
  bool ascii = true;
  std::endian order = std::endian::little;  ///< unless ascii
  /// "ascii", "binary little endian" or "binary big endian".
  const char* encoding() const {
    return ascii ? "ascii" : order == std::endian::little ? "binary little endian" : "binary big endian";
  }
  PlyElement vertex;
  std::span<const PlyElement> before_vertex;  ///< elements between the header and the vertices, in order
  std::span<const PlyElement> before_face;    ///< elements between the vertices and the faces, in order
  /// Faces after the vertices, with a list of vertex indices. count 0: there are none that can be read.
  PlyElement face;
  std::uint64_t declared_faces = 0;  ///< wherever they are; more than face.count: some can't be read
  bool ends_with_vertices = true;    ///< no element comes after them
  bool ends_with_faces = true;
  bool strips = false;  ///< the lists are strips of triangles, as Stanford's scans have: -1 begins another strip
};

/// Reads up to and including the line `end_header`. Declarations after the vertices that can't be understood only mean that the
/// faces can't be read.
/// @param memory  holds the layouts
/// @retval ErrorCode::kMalformed, kTruncated, kUnsupported
/// @retval ErrorCode::kNoPoints  it declares no vertices, or no x, y and z
[[nodiscard]] Expected<PlyHeader> read_ply_header(LineInput& lines, Arena& memory);

}  // namespace plumbline::inline slicer
