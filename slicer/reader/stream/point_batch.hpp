#pragma once
/// Points on their way to the sink.

#include <cfloat>
#include <cmath>
#include <cstddef>
#include <span>

#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// The numbers of a point that a reader looks for, in the order of a row of six doubles.
enum Slot : std::uint8_t { kX, kY, kZ, kNx, kNy, kNz };
inline constexpr std::size_t kSlots = 6;
using SlotValues = double[kSlots];

/// What a property, field or column called `name` is: x, y, z, nx or normal_x and so on, in any case.
/// @returns kSlots for anything else
std::size_t slot_of(std::string_view name);

/// Collects points, drops those that are nowhere, and counts for the report.
class PointBatch {
 public:
  static constexpr std::size_t kPoints = 1024;

  /// @param room     kPoints of them
  /// @param summary  counted into
  PointBatch(PointSink& sink, std::span<ScanPoint> room, ScanSummary& summary)
      : sink_(sink), room_(room), summary_(summary) {}

  /// Before the first add().
  [[nodiscard]] Status begin(const ScanHeader& header) {
    summary_.header = header;
    return sink_.begin(header);
  }

  /// Takes one row; there must be room: flush() when full().
  void add(const SlotValues& row) {
    if (!std::isfinite(row[kX]) || !std::isfinite(row[kY]) || !std::isfinite(row[kZ])) {
      ++summary_.not_finite;
      return;
    }
    ScanPoint& point = room_[count_++];
    point.x = row[kX];
    point.y = row[kY];
    point.z = row[kZ];
    point.nx = point.ny = point.nz = 0;
    if (!summary_.header.has_normals) return;
    // The comparison is false for NaN too. A float holds no more than FLT_MAX.
    if (std::abs(row[kNx]) <= FLT_MAX && std::abs(row[kNy]) <= FLT_MAX && std::abs(row[kNz]) <= FLT_MAX) {
      point.nx = static_cast<float>(row[kNx]);
      point.ny = static_cast<float>(row[kNy]);
      point.nz = static_cast<float>(row[kNz]);
    }
    if (point.nx == 0 && point.ny == 0 && point.nz == 0) ++summary_.without_normal;
  }
  bool full() const { return count_ == room_.size(); }

  /// Hands over what there is, if anything.
  [[nodiscard]] Status flush();

 private:
  PointSink& sink_;
  std::span<ScanPoint> room_;
  ScanSummary& summary_;
  std::size_t count_ = 0;
};

}  // namespace plumbline
