#pragma once
/// The header of a PCD file.

#include <cstdint>
#include <optional>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/reader/records/record.hpp"
#include "slicer/reader/stream/line_input.hpp"

namespace plumbline::inline slicer {

struct PcdField {
  std::uint64_t count = 1;               ///< values a point
  std::uint32_t size = 4;                ///< bytes a value
  char kind = 'F';                       ///< I, U or F
  std::uint8_t slot = kSlots;            ///< kSlots if not wanted
  ScalarType type = ScalarType::kFloat;  ///< of a wanted field

  std::uint64_t bytes() const { return count * size; }  ///< a point; can't overflow, see read_pcd_header()
};

enum class PcdData : std::uint8_t { kAscii, kBinary, kBinaryCompressed };

struct PcdHeader {
  PcdData data = PcdData::kAscii;
  std::uint64_t points = 0;
  std::span<const PcdField> fields;  ///< in the order of the file
  RecordLayout layout;               ///< of one point
  std::optional<Vec3d> scanner;      ///< see ScanView
};

/// Reads up to and including the line `DATA`.
/// @param memory  holds the fields
/// @retval ErrorCode::kMalformed, kTruncated, kUnsupported
/// @retval ErrorCode::kNoPoints  it declares no points, or no x, y and z
[[nodiscard]] Expected<PcdHeader> read_pcd_header(LineInput& lines, Arena& memory);

}  // namespace plumbline::inline slicer
