#pragma once
/// What a reader of meshes delivers: triangles, and a summary.

#include <array>
#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::inline slicer {

/// Corners in scan units, counter-clockwise seen from outside of the object. Every number is finite.
using Triangle = std::array<Vec3d, 3>;

/// The body of a triangle, in one number: its item, which is what negative volumes are cut out of, and whether it is one.
class BodyLabel {
 public:
  BodyLabel() = default;
  /// @param item  from 1; 0: of a file without negative volumes
  BodyLabel(std::uint32_t item, bool negative) : number_(item << 1U | (negative ? 1U : 0U)) {}
  static BodyLabel of(std::uint32_t number) { return {number >> 1U, (number & 1U) != 0}; }

  std::uint32_t number() const { return number_; }
  std::uint32_t item() const { return number_ >> 1U; }
  bool is_negative() const { return (number_ & 1U) != 0; }
  friend bool operator==(const BodyLabel&, const BodyLabel&) = default;

 private:
  std::uint32_t number_ = 0;
};

/// Receives the triangles in the order of the file, in batches. A face with more than three corners is a fan of triangles from
/// its first corner: in the plane of the face they wind around each place as the face does, even if it is not convex.
class TriangleSink : public ReadProgress {
 public:
  /// @param triangles  one or more, valid only during the call
  [[nodiscard]] virtual Status take(std::span<const Triangle> triangles) = 0;
  /// The triangles that follow belong to another body; before the first call to BodyLabel().
  virtual void begin_body(BodyLabel /*body*/) {}
};

/// What a project of a slicer says of a volume.
enum class VolumeRole : std::uint8_t {
  kSolid,
  kNegative,  ///< is cut out of the solids of its item
  kIgnored,   ///< a modifier, or where supports are wanted or not
};

/// What a project of a slicer holds that is not used.
struct UnusedSettings {
  std::uint32_t ignored = 0;   ///< volumes: VolumeRole::kIgnored
  std::uint32_t negative = 0;  ///< volumes: these are used
  bool hollowing = false;
  bool drain_holes = false;
  bool support_points = false;
  bool correction = false;  ///< of scale or of XY size

  void add(const UnusedSettings& other) {
    ignored += other.ignored;
    negative += other.negative;
    hollowing |= other.hollowing;
    drain_holes |= other.drain_holes;
    support_points |= other.support_points;
    correction |= other.correction;
  }
};

/// What was read from a file.
struct MeshSummary {
  ScanFormat format = ScanFormat::kStl;
  const char* encoding = "";        ///< as ScanHeader::encoding
  bool is_in_mm = false;            ///< as ScanHeader::is_in_mm
  std::uint64_t faces = 0;          ///< in the file
  std::uint64_t triangles = 0;      ///< delivered to the sink
  std::uint64_t not_finite = 0;     ///< triangles left out: a coordinate is NaN, infinite or above kLargestCoordinate
  std::uint64_t vertices = 0;       ///< of an indexed format; 0: STL
  std::uint64_t used_vertices = 0;  ///< of these, those of a face
  std::uint64_t most_vertices = 0;  ///< kept at a time: those of one object
  std::uint64_t bytes = 0;          ///< read from the source
  UnusedSettings project;           ///< of a 3MF
};

/// Scan units. Squares and products of three such numbers stay finite.
inline constexpr double kLargestCoordinate = 1e30;

}  // namespace plumbline::inline slicer
