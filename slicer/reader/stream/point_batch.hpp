#pragma once
/// Collects points for the sink.

#include <cfloat>
#include <cmath>
#include <cstddef>
#include <span>

#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// The numbers of a point that readers look for; also the order of a row of six doubles.
enum Slot : std::uint8_t { kX, kY, kZ, kNx, kNy, kNz };
inline constexpr std::size_t kSlots = 6;
using SlotValues = double[kSlots];

/// The slot of a property, field or column called `name`: x, y, z, nx or normal_x and so on, ignoring case.
/// @returns kSlots for any other name
std::size_t slot_of(std::string_view name);

/// Collects points into batches, drops those with a coordinate that is not finite, and counts both for the report.
class PointBatch {
 public:
  static constexpr std::size_t kPoints = 1024;  ///< 40 KiB; enough to hide the cost of a virtual call a batch

  /// @param room     kPoints points
  /// @param summary  gets the counts
  PointBatch(PointSink& sink, std::span<ScanPoint> room, ScanSummary& summary)
      : sink_(sink), room_(room), summary_(summary) {}

  /// Call before the first add().
  [[nodiscard]] Status begin(const ScanHeader& header) {
    summary_.header = header;
    return sink_.begin(header);
  }

  /// Also passes on points with a coordinate that is not finite: the corners of a mesh keep their numbers.
  void keep_not_finite() { keeps_not_finite_ = true; }

  /// Adds one row. The batch must not be full(): call flush() then.
  void add(const SlotValues& row) {
    if (!keeps_not_finite_ && !is_finite(row)) {
      ++summary_.not_finite;
      return;
    }
    ScanPoint& point = room_[count_++];
    point.x = row[kX];
    point.y = row[kY];
    point.z = row[kZ];
    point.nx = point.ny = point.nz = 0;
    if (!summary_.header.has_normals) return;
    // A normal becomes float: larger components are dropped, as is NaN, for which the comparison is false.
    if (std::abs(row[kNx]) <= FLT_MAX && std::abs(row[kNy]) <= FLT_MAX && std::abs(row[kNz]) <= FLT_MAX) {
      point.nx = static_cast<float>(row[kNx]);
      point.ny = static_cast<float>(row[kNy]);
      point.nz = static_cast<float>(row[kNz]);
    }
    if (point.nx == 0 && point.ny == 0 && point.nz == 0) ++summary_.without_normal;
  }
  /// Counts a point that the file itself marks as invalid or deleted.
  void leave_out() { ++summary_.left_out; }
  bool full() const { return count_ == room_.size(); }

  /// Passes the collected points to the sink, if there are any.
  [[nodiscard]] Status flush();

 private:
  static bool is_finite(const SlotValues& row) {
    return std::isfinite(row[kX]) && std::isfinite(row[kY]) && std::isfinite(row[kZ]);
  }

  PointSink& sink_;
  std::span<ScanPoint> room_;
  ScanSummary& summary_;
  std::size_t count_ = 0;
  bool keeps_not_finite_ = false;
};

}  // namespace plumbline
