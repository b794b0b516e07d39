#pragma once
/// The head of a PLY file.

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
  std::endian order = std::endian::little;  ///< where not ascii
  PlyElement vertex;
  std::span<const PlyElement> before_vertex;  ///< what stands between the head and the vertices, in order
};

/// Reads up to and with the line `end_header`. What is declared behind the vertices is not looked at: no byte of it is
/// needed.
/// @param memory  for the layouts
/// @retval ErrorCode::kMalformed, kTruncated, kUnsupported
/// @retval ErrorCode::kNoPoints  no vertices, or none with x, y and z
[[nodiscard]] Expected<PlyHeader> read_ply_header(LineInput& lines, Arena& memory);

}  // namespace plumbline
