#pragma once
/// The scan in memory: 24 bytes a point, in the arena.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/vec.hpp"

namespace plumbline {

/// What a point's cluster says of it (thesis III-2.b, table 1).
enum class PointClass : std::uint8_t {
  kEntering,  ///< normal against the manufacturing direction: rays going up enter here
  kExiting,   ///< normal along the manufacturing direction
  kNeutral,   ///< normal within 5 degrees of perpendicular to it
  kNoise,     ///< too few neighbours of like orientation
};
inline constexpr std::size_t kPointClassCount = 4;

/// A unit normal in 6 bytes (error below 0.003 degrees) and what goes with it. All zero: no normal is known.
struct PackedNormal {
  std::int16_t x = 0, y = 0, z = 0;  ///< component * 32767
  std::uint8_t weight = 1;           ///< scan points averaged into this one, 255 at most
  PointClass point_class = PointClass::kNoise;

  static constexpr float kScale = 32767.0F;
  bool known() const { return x != 0 || y != 0 || z != 0; }
  Vec3f unpack() const {
    constexpr float kInverse = 1.0F / kScale;
    return {static_cast<float>(x) * kInverse, static_cast<float>(y) * kInverse, static_cast<float>(z) * kInverse};
  }
  /// @param n  any finite vector; shorter than 1e-12 means "not known"
  void set(const Vec3f& n);
};
static_assert(sizeof(PackedNormal) == 8);

/// Structure of arrays over one capacity. Index i is the same point in each, and in both trees: the link of thesis III-2.a.
struct Cloud {
  std::span<Vec3f> position;  ///< mm; scan frame less an offset until placed, print coordinates after
  std::span<PackedNormal> normal;
  std::span<float> radius;  ///< mm; support of the point in the MLS surface, set by clustering
  std::uint32_t size = 0;   ///< points in use
  /// The last so many are no points of the scan: walls of bores that continue_bore_walls() has continued.
  std::uint32_t continued = 0;

  static constexpr std::size_t kBytesPerPoint = sizeof(Vec3f) + sizeof(PackedNormal) + sizeof(float);

  /// Room that a cloud of so many points of a scan has for more of them.
  static constexpr std::uint32_t spare(std::uint32_t points) { return points / 64; }

  [[nodiscard]] static Expected<Cloud> create(std::uint32_t capacity, Arena& arena);
  std::uint32_t capacity() const { return static_cast<std::uint32_t>(position.size()); }
  std::span<const Vec3f> positions() const { return position.first(size); }
  std::uint32_t seen() const { return size - continued; }  ///< points of the scan, the first
  Box3f bounds() const;

  /// Takes out the points of class kNoise and keeps the order of the others.
  void drop_noise();

  /// Puts point order[i] at i, in place. Work space: one bit a point from the top of the arena.
  [[nodiscard]] Status reorder(std::span<const std::uint32_t> order, Arena& arena);
};

}  // namespace plumbline
