#pragma once
/// The header of a PLY file.

#include <bit>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/reader/records/record.hpp"
#include "slicer/reader/stream/line_input.hpp"

namespace plumbline {

struct PlyElement {
  std::uint64_t count = 0;
  RecordLayout layout;
};

struct PlyHeader {
  bool ascii = true;
  std::endian order = std::endian::little;  ///< unless ascii
  PlyElement vertex;
  std::span<const PlyElement> before_vertex;  ///< elements between the header and the vertices, in order
};

/// Reads up to and including the line `end_header`. Elements declared after the vertices are ignored, since none of their
/// bytes is needed.
/// @param memory  holds the layouts
/// @retval ErrorCode::kMalformed, kTruncated, kUnsupported
/// @retval ErrorCode::kNoPoints  it declares no vertices, or no x, y and z
[[nodiscard]] Expected<PlyHeader> read_ply_header(LineInput& lines, Arena& memory);

}  // namespace plumbline
