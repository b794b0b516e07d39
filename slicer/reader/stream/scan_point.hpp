#pragma once
/// What a reader delivers: header, points, summary.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/reader/stream/read_progress.hpp"

namespace plumbline::inline slicer {

/// One point as in the file. Every number is finite.
struct ScanPoint {
  double x = 0, y = 0, z = 0;    ///< scan units
  float nx = 0, ny = 0, nz = 0;  ///< any length; all zero if the file has no usable normal for this point
};

enum class ScanFormat : std::uint8_t { kPly, kXyz, kPcd, kObj, kStl, kOff, k3mf, kLas, kPtx, kE57, kSpz };

/// What the header of a scan declares, known before its first point.
struct ScanHeader {
  ScanFormat format = ScanFormat::kPly;
  const char* encoding = "";                     ///< "ascii", "binary little endian", "binary compressed", ...
  bool has_normals = false;                      ///< it has columns or properties for normals
  bool has_unsigned_normals = false;             ///< either side of the surface, not always its outside
  bool has_views = false;                        ///< it says which points were seen together, and mostly from where
  bool is_in_mm = false;                         ///< whatever unit is asked for: the format fixes its unit
  std::optional<std::uint64_t> declared_points;  ///< not to be trusted before as many points have been read
  bool is_packed = false;                        ///< a point may take less than a byte of the file
  std::uint64_t reader_bytes = 0;                ///< kept by the reader beyond its workspace; from the header, so
                                                 ///< not to be trusted either
};

/// One exposure or sweep of a scanner. A merged scan has many.
struct ScanView {
  std::optional<Vec3d> scanner;  ///< where the scanner stood, scan units; none: the file doesn't say
};

/// Receives the points in the order of the file, in batches.
class PointSink : public ReadProgress {
 public:
  /// Called once, before the first batch.
  [[nodiscard]] virtual Status begin(const ScanHeader& header) = 0;
  /// Called before the points of each view, if ScanHeader::has_views.
  virtual void begin_view(const ScanView& /*view*/) {}
  /// @param points  one or more, valid only during the call
  [[nodiscard]] virtual Status take(std::span<const ScanPoint> points) = 0;
};

/// What was read from a file, for the report.
struct ScanSummary {
  ScanHeader header;
  std::uint64_t points = 0;          ///< delivered to the sink
  std::uint64_t not_finite = 0;      ///< dropped: a coordinate was NaN or infinite
  std::uint64_t left_out = 0;        ///< dropped: the file itself says that they are no part of the scan
  std::uint64_t without_normal = 0;  ///< delivered with a zero normal although the file has normals
  std::uint64_t bytes = 0;           ///< read from the source
};

}  // namespace plumbline::inline slicer
