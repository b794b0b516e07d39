#include "slicer/surface/bores/bore_walls.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "slicer/core/cell_table.hpp"
#include "slicer/core/numbers/degrees.hpp"
#include "slicer/surface/bores/bore_surface.hpp"
#include "slicer/surface/bores/round_bores.hpp"

namespace plumbline {
namespace {

constexpr std::uint32_t kMaxEnds = 4096;  ///< bounds memory and, with its square, time
constexpr std::uint32_t kMaxSparse =
    16;                                 ///< if more than 1 / kMaxSparse of the points are sparse, epsilon is no density
constexpr std::uint32_t kChunk = 1024;  ///< points between two calls of the progress
// Two ends of one wall. Wider limits join walls of different bores; narrower ones miss walls with noisy normals.
constexpr float kMaxSlope = 0.2F;  ///< of the line between them against the wall
constexpr float kMaxWidthRatio = 1.5F;
constexpr float kMaxLength = 6;  ///< widths; longer lines may join different bores
// Walls around an end and the space between them, in widths.
/// Largest distance of a wall's point from the circle of that width; corners of square bores are 0.21 off.
constexpr float kWallDistance = 0.6F;
constexpr float kClear = 0.3F;  ///< radius around the bore's middle line that must be free of points

/// The line between two ends, along the wall.
struct Line {
  Vec3f from;
  Vec3f chord;
  float length;
  Vec3f normal;  ///< of the wall
};

/// Cells that have an added point.
class Cells {
 public:
  Cells(std::span<std::uint64_t> slots, const Box3f& box, float edge) : grid_(box, edge), table_(slots) {
    table_.clear();
  }
  /// Marks the cell of p.
  /// @returns false if it was marked before
  bool take(const Vec3f& p) {
    const std::uint64_t key = grid_.key(p);
    const std::uint32_t slot = table_.find_key(key);
    return std::exchange(table_[slot], key) == 0;
  }

 private:
  CellGrid grid_;
  CellTable<std::uint64_t> table_;  ///< keys; half of the slots stay empty
};

std::size_t slots_for(std::uint32_t room) { return std::bit_ceil(std::size_t{2} * room + 2); }

/// @returns no ends where too much of the surface is sparse
Expected<std::span<BoreEnd>> find_ends(const BoreSurface& surface, std::span<BoreEnd> room,
                                       const StageProgress& progress) {
  const auto is_sparse = [&](std::uint32_t i) { return surface.is_surface(i) && surface.is_sparse(i); };
  std::uint32_t sparse = 0;
  for (std::uint32_t i = 0; i < surface.scanned(); ++i) sparse += is_sparse(i) ? 1 : 0;
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < surface.scanned() && sparse <= surface.scanned() / kMaxSparse && count < room.size();
       ++i) {
    if (i % kChunk == 0 && !progress.advance(1.0 * i / surface.scanned())) {
      return fail(ErrorCode::kCancelled, "cancelled while bores were looked for");
    }
    if (!is_sparse(i)) continue;
    if (const auto width = surface.width_at(i)) room[count++] = {i, *width};
  }
  return room.first(count);
}

/// Extends walls along lines between two ends, for bores that are not round.
class StraightWalls {
 public:
  StraightWalls(BoreSurface& surface, Cells& cells) : surface_(surface), cells_(cells) {}

  Status run(std::span<const BoreEnd> ends, const StageProgress& progress) {
    for (std::size_t a = 0; a < ends.size(); ++a) {
      if (!progress.advance(static_cast<double>(a) / static_cast<double>(ends.size()))) {
        return fail(ErrorCode::kCancelled, "cancelled while the walls of bores were extended");
      }
      for (std::size_t b = a + 1; b < ends.size(); ++b) {
        if (const auto line = line_between(ends[a], ends[b])) add_points(*line);
      }
    }
    return {};
  }

 private:
  /// @returns nothing if the two don't belong to one wall
  std::optional<Line> line_between(const BoreEnd& a, const BoreEnd& b) const {
    const Vec3f& p = surface_.position(a.point);
    const Vec3f chord = surface_.position(b.point) - p;
    const float width = std::min(a.width, b.width);
    const float length2 = chord.dot(chord);
    const float longest = kMaxLength * width;
    const float shortest = kLeastUnseen * surface_.epsilon();
    if (length2 > longest * longest || length2 < shortest * shortest) return std::nullopt;
    if (std::max(a.width, b.width) > kMaxWidthRatio * width) return std::nullopt;
    const Vec3f normal_a = surface_.normal(a.point);
    const Vec3f normal_b = surface_.normal(b.point);
    if (normal_a.dot(normal_b) < kOneWay) return std::nullopt;
    const float length = std::sqrt(length2);
    const Vec3f along = chord * (1 / length);
    const Vec3f mean = normal_a + normal_b;
    const float slope = mean.dot(along);
    if (slope * slope > kMaxSlope * kMaxSlope * mean.dot(mean)) return std::nullopt;
    const Vec3f across = mean - along * slope;
    const Line line{p, chord, length, across * (1 / std::sqrt(across.dot(across)))};
    if (!is_unseen(line, width) || !is_enclosed(p, line, width) || !is_enclosed(p + chord, line, width))
      return std::nullopt;
    return line;
  }

  /// Whether there is wall in eight directions around the bore, seen from a place on its wall.
  bool is_enclosed(const Vec3f& wall, const Line& line, float width) const {
    const Vec3f axis = wall + line.normal * (0.5F * width);
    const Vec3f sideways = line.chord.cross(line.normal) * (1 / line.length);
    for (int k = 0; k < 8; ++k) {
      const SineCosine way = sine_cosine(45 * k);
      const Vec3f outwards = line.normal * static_cast<float>(way.cosine) + sideways * static_cast<float>(way.sine);
      if (!has_point_facing(axis + outwards * (0.5F * width), -outwards, kWallDistance * width)) return false;
    }
    return true;
  }

  /// Whether a surface point within `distance` of x faces `way`.
  bool has_point_facing(const Vec3f& x, const Vec3f& way, float distance) const {
    return surface_.any_near(x, [&](const Neighbour& other) {
      return other.distance2 < distance * distance && surface_.normal(other.index).dot(way) > kWallCosine;
    });
  }

  void add_points(const Line& line) {
    const auto steps = static_cast<int>(line.length / (BoreSurface::kSpacing * surface_.epsilon()));
    for (int k = 1; k < steps && !surface_.full(); ++k) {
      const Vec3f x = line.from + line.chord * (static_cast<float>(k) / static_cast<float>(steps));
      if (!surface_.has_wall(x, line.normal) && cells_.take(x)) surface_.add(x, line.normal);
    }
  }

  /// Whether no point lies on the middle half of the line, and none in the middle of the bore in front of it.
  bool is_unseen(const Line& line, float width) const {
    const Vec3f along = line.chord * (1 / line.length);
    const float step = 0.5F * surface_.epsilon();
    for (float t = 0.25F * line.length; t < 0.75F * line.length; t += step) {
      if (surface_.distance2(line.from + along * t) < surface_.epsilon() * surface_.epsilon()) return false;
    }
    const float clear2 = kClear * kClear * width * width;
    const Vec3f middle = line.from + line.normal * (0.5F * width);
    for (float t = step; t < line.length - step; t += 0.25F * width) {
      if (surface_.distance2(middle + along * t) < clear2) return false;
    }
    return true;
  }

  BoreSurface& surface_;
  Cells& cells_;
};

}  // namespace

std::size_t bore_walls_bytes(std::uint32_t points) {
  return Arena::rounded(kMaxEnds * sizeof(BoreEnd)) +
         Arena::rounded(slots_for(Cloud::spare(points)) * sizeof(std::uint64_t));
}

Expected<BoreWalls> continue_bore_walls(Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering,
                                        Arena& arena, const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto room = arena.take_top<BoreEnd>(kMaxEnds, "bore walls");
  PLUMBLINE_TRY(room);
  const auto slots = arena.take_top<std::uint64_t>(slots_for(cloud.capacity() - cloud.size), "bore walls");
  PLUMBLINE_TRY(slots);
  const float edge = BoreSurface::kSpacing * clustering.epsilon;
  Cells cells(*slots, cloud.bounds(), edge);
  BoreSurface surface(cloud, tree, clustering);
  auto ends = find_ends(surface, *room, progress.part(0, 0.5));
  PLUMBLINE_TRY(ends);
  ends = continue_round_bores(surface, *ends, progress.part(0.5, 0.75));
  PLUMBLINE_TRY(ends);
  PLUMBLINE_TRY(StraightWalls(surface, cells).run(*ends, progress.part(0.75, 1)));
  cloud.continued = surface.added();
  return BoreWalls{cloud.continued, edge * edge * static_cast<float>(cloud.continued)};
}

}  // namespace plumbline
