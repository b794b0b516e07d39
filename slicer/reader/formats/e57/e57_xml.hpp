#pragma once
/// The XML section of an E57 file: which scans it has, where their points are, and how they are stored.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/reader/formats/e57/e57_pages.hpp"
#include "slicer/reader/records/scan_pose.hpp"

namespace plumbline::inline slicer {

/// One number of a point. Each has a stream of bits of its own.
struct E57Field {
  enum class Kind : std::uint8_t { kNone, kInteger, kFloat, kDouble };
  Kind kind = Kind::kNone;   ///< kNone: the scan does not have it
  std::uint8_t bits = 0;     ///< 0 to 64; 0: the value is `minimum` for all points
  std::uint16_t stream = 0;  ///< its place among the fields of the file, from 0
  std::int64_t minimum = 0;  ///< of an integer: value = (minimum + bits) * scale + offset
  double scale = 1, offset = 0;
};

/// The fields that are read, in this order.
enum E57Slot : std::uint8_t { kE57X, kE57Y, kE57Z, kE57Nx, kE57Ny, kE57Nz, kE57Invalid };
inline constexpr std::size_t kE57Slots = 7;

/// Fields of a point, wanted or not: more than any scanner writes.
inline constexpr std::size_t kE57MostStreams = 256;

struct E57Scan {
  std::uint64_t section = 0;  ///< physical offset of its points
  std::uint64_t points = 0;   ///< declared
  std::size_t streams = 0;    ///< fields in the file
  bool is_spherical = false;  ///< x, y, z are range, azimuth and elevation: m, radians
  ScanPose pose;              ///< to the file's frame, m
  bool is_placed = false;     ///< its own frame is known to be the scanner's: the pose is not that of a merged cloud
  std::array<E57Field, kE57Slots> field;

  bool has_normals() const { return field[kE57Nx].kind != E57Field::Kind::kNone; }
};

/// Reads the XML section, from where the pages stand.
/// @param bytes   of the section
/// @param memory  a table of the scans at its bottom, which stays; the XML parser works in the rest
/// @returns the scans that have points with coordinates, in the order of the file
/// @retval ErrorCode::kMalformed    not XML, or a value is missing or wrong
/// @retval ErrorCode::kUnsupported  too many scans or fields, a tag too long for the memory, a document type
[[nodiscard]] Expected<std::span<E57Scan>> read_e57_xml(E57Pages& pages, std::uint64_t bytes, Arena& memory);

}  // namespace plumbline::inline slicer
