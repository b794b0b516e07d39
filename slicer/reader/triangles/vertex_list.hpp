#pragma once
/// The vertices of an indexed mesh, while its file is read.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Positions as single precision offsets from the first vertex, 12 bytes each, and one bit each for whether a face uses it. Every
/// face that names a vertex sees the same position, so that rounding opens no gaps.
class VertexList {
 public:
  VertexList() = default;

  /// Bytes of arena for that many vertices.
  static std::size_t bytes_needed(std::uint64_t vertices);
  /// The most vertices for which there is room in `bytes` bytes.
  static std::uint64_t most_in(std::size_t bytes);

  /// @param capacity  vertices
  /// @param arena     bytes_needed() from the bottom; the caller releases it
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<VertexList> create(std::uint64_t capacity, Arena& arena);

  void clear();
  std::uint64_t size() const { return size_; }
  std::uint64_t capacity() const { return positions_.size(); }
  std::uint64_t used() const { return used_; }  ///< vertices that use() was called for

  /// @param p  any numbers; at() returns NaN and huge ones as infinite
  /// @returns false if the list is full
  [[nodiscard]] bool add(const Vec3d& p) {
    if (size_ == positions_.size()) return false;
    if (size_ == 0) origin_ = origin_at(p);
    if (size_ % 64 == 0) bits_[size_ / 64] = 0;
    positions_[size_++] = offset_from(origin_, p);
    return true;
  }
  /// The origin of a list whose first vertex is p, and another vertex as an offset from it.
  static Vec3d origin_at(const Vec3d& p);
  static Vec3f offset_from(const Vec3d& origin, const Vec3d& p) {
    return {offset(p[0] - origin[0]), offset(p[1] - origin[1]), offset(p[2] - origin[2])};
  }
  /// Most of its memory, for other use until the first vertex is added.
  std::span<std::byte> room() { return std::as_writable_bytes(positions_); }

  /// @param i  below size()
  Vec3d at(std::uint64_t i) const { return positions_[static_cast<std::size_t>(i)].cast<double>() + origin_; }
  /// Notes that a face uses vertex i.
  void use(std::uint64_t i) {
    std::uint64_t& word = bits_[static_cast<std::size_t>(i / 64)];
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    used_ += (word & bit) == 0 ? 1 : 0;
    word |= bit;
  }

 private:
  static constexpr double kLargestOffset = 1e30;  ///< scan units; any larger one counts as infinite

  static float offset(double d) {
    return std::abs(d) <= kLargestOffset ? static_cast<float>(d) : std::numeric_limits<float>::infinity();
  }

  std::span<Vec3f> positions_;
  std::span<std::uint64_t> bits_;
  Vec3d origin_ = Vec3d::Zero();
  std::size_t size_ = 0;
  std::uint64_t used_ = 0;
};

}  // namespace plumbline::inline slicer
