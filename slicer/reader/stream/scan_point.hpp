#pragma once
/// What a reader delivers.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline {

/// One point as the file has it. Every number is finite.
struct ScanPoint {
  double x = 0, y = 0, z = 0;    ///< scan units
  float nx = 0, ny = 0, nz = 0;  ///< any length; all zero where the file has no usable normal for this point
};

enum class ScanFormat : std::uint8_t { kPly, kXyz, kPcd, kObj };

/// What the head of a scan says, known before its first point.
struct ScanHeader {
  ScanFormat format = ScanFormat::kPly;
  const char* encoding = "";                     ///< "ascii", "binary little endian", "binary compressed", ...
  bool has_normals = false;                      ///< columns or properties for them exist
  std::optional<std::uint64_t> declared_points;  ///< as the header says; hostile until the points have come
  std::uint64_t reader_bytes = 0;                ///< that the reader keeps beside its work space; as hostile
};

/// Takes the points in the order of the file, in batches.
class PointSink {
 public:
  virtual ~PointSink() = default;
  /// Called once, before the first batch.
  [[nodiscard]] virtual Status begin(const ScanHeader& header) = 0;
  /// @param points  one or more, valid only during the call
  [[nodiscard]] virtual Status take(std::span<const ScanPoint> points) = 0;
  /// @param fraction  0 to 1 of the file, where its size is known; false cancels
  virtual bool progress(double fraction) = 0;
};

/// What was read, for the report.
struct ScanSummary {
  ScanHeader header;
  std::uint64_t points = 0;          ///< delivered to the sink
  std::uint64_t not_finite = 0;      ///< dropped: a coordinate was NaN or infinite
  std::uint64_t without_normal = 0;  ///< delivered with a zero normal although the file has normals
  std::uint64_t bytes = 0;           ///< read from the source
};

}  // namespace plumbline
