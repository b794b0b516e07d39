#pragma once
/// Collects triangles for the sink.

#include <cmath>
#include <cstddef>
#include <span>

#include "slicer/reader/triangles/triangle.hpp"

namespace plumbline::inline slicer {

/// Collects triangles into batches, leaves out those with an unusable corner, and counts both.
class TriangleBatch {
 public:
  static constexpr std::size_t kTriangles = 512;  ///< 36 KiB; enough to hide the cost of a virtual call a batch

  /// @param room     kTriangles of them
  /// @param summary  gets the counts
  TriangleBatch(TriangleSink& sink, std::span<Triangle> room, MeshSummary& summary)
      : sink_(sink), room_(room), summary_(summary) {}

  [[nodiscard]] Status add(const Triangle& triangle) {
    if (!is_usable(triangle[0]) || !is_usable(triangle[1]) || !is_usable(triangle[2])) {
      ++summary_.not_finite;
      return {};
    }
    room_[count_++] = triangle;
    return count_ == room_.size() ? flush() : Status{};
  }

  /// Says whose the triangles that follow are.
  [[nodiscard]] Status begin_body(BodyLabel body) {
    if (body == body_) return {};
    PLUMBLINE_TRY(flush());
    body_ = body;
    sink_.begin_body(body);
    return {};
  }

  /// Passes the collected triangles to the sink, if there are any.
  [[nodiscard]] Status flush() {
    if (count_ == 0) return {};
    const auto ready = room_.first(count_);
    count_ = 0;
    summary_.triangles += ready.size();
    return sink_.take(ready);
  }

  MeshSummary& summary() { return summary_; }
  /// For what is not read through a ByteInput, which reports by itself.
  [[nodiscard]] Status report(double fraction) {
    return sink_.progress(fraction) ? Status() : Status(fail(ErrorCode::kCancelled, "reading was cancelled"));
  }

 private:
  /// NaN is not.
  static bool is_usable(const Vec3d& p) {
    return std::abs(p[0]) <= kLargestCoordinate && std::abs(p[1]) <= kLargestCoordinate &&
           std::abs(p[2]) <= kLargestCoordinate;
  }

  TriangleSink& sink_;
  std::span<Triangle> room_;
  MeshSummary& summary_;
  std::size_t count_ = 0;
  BodyLabel body_;
};

}  // namespace plumbline::inline slicer
