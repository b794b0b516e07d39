#pragma once
/// Collects points for the sink.

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <span>

#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::inline slicer {

/// The numbers of a point that readers look for; also their order in a row.
enum Slot : std::uint8_t { kX, kY, kZ, kNx, kNy, kNz };
inline constexpr std::size_t kSlots = 6;
/// What a Gaussian splat has besides: see SplatFilter.
enum SplatSlot : std::uint8_t { kOpacity = kSlots, kScale, kTurn = kScale + 3 };
inline constexpr std::size_t kThirdScale = kScale + 2;  ///< splats of two dimensions don't have it
inline constexpr std::size_t kRowSlots = kTurn + 4;
using SlotValues = double[kRowSlots];

/// The slot of a property, field or column called `name`: x, y, z, nx or normal_x and so on, ignoring case.
/// @returns kSlots for any other name
std::size_t slot_of(std::string_view name);

/// The slot of a property of a splat: opacity, scale_0 and so on.
/// @returns kRowSlots for any other name
std::size_t splat_slot_of(std::string_view name);

/// Decides about each point before it is delivered.
class PointFilter {
 public:
  enum class Verdict : std::uint8_t { kKeep, kLeaveOut, kIgnore };  ///< kIgnore: without counting it

  virtual ~PointFilter() = default;
  /// @param row  may be changed
  virtual Verdict look(SlotValues& row) = 0;
};

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

  /// Call before the first add() of each view.
  [[nodiscard]] Status begin_view(const ScanView& view) {
    PLUMBLINE_TRY(flush());
    sink_.begin_view(view);
    return {};
  }

  /// Also passes on points with a coordinate that is not finite: the corners of a mesh keep their numbers.
  void keep_not_finite() { keeps_not_finite_ = true; }

  /// @param filter  null: none
  void filter_by(PointFilter* filter) { filter_ = filter; }

  /// Adds one row. The batch must not be full(): call flush() then.
  void add(const SlotValues& row) {
    if (filter_ == nullptr) return deliver(row);
    SlotValues own;
    std::copy(std::begin(row), std::end(row), own);
    const auto verdict = filter_->look(own);
    if (verdict == PointFilter::Verdict::kKeep) deliver(own);
    if (verdict == PointFilter::Verdict::kLeaveOut) leave_out();
  }

  /// Counts a point that the file itself marks as invalid or deleted.
  void leave_out() { ++summary_.left_out; }
  bool full() const { return count_ == room_.size(); }

  /// Passes the collected points to the sink, if there are any.
  [[nodiscard]] Status flush();

 private:
  void deliver(const SlotValues& row) {
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
  static bool is_finite(const SlotValues& row) {
    return std::isfinite(row[kX]) && std::isfinite(row[kY]) && std::isfinite(row[kZ]);
  }

  PointSink& sink_;
  std::span<ScanPoint> room_;
  ScanSummary& summary_;
  PointFilter* filter_ = nullptr;
  std::size_t count_ = 0;
  bool keeps_not_finite_ = false;
};

}  // namespace plumbline::inline slicer
