#include "slicer/bore_walls.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

namespace plumbline {
namespace {

constexpr const char* kStage = "bore walls";

constexpr std::uint32_t kMostEnds = 4096;
constexpr std::uint32_t kFewSparse = 16;  ///< one point in so many at most: of more, epsilon tells no density
constexpr std::uint32_t kChunk = 1024;    ///< points between two looks at the progress
constexpr float kSparse = 0.3F;      ///< of epsilon: the radius of a point's own share of a sparse surface, at least
constexpr float kWidest = 8;         ///< times epsilon
constexpr float kOpposite = -0.5F;   ///< most inner product of the normals of opposite walls
constexpr float kAlike = 0.5F;       ///< least inner product of the normals of two ends
constexpr float kSlope = 0.2F;       ///< of the line between them against the wall, at most
constexpr float kWidthRatio = 1.5F;  ///< of their widths, at most
constexpr float kShortest = 2;       ///< times epsilon
constexpr float kLongest = 6;        ///< times the width
constexpr float kAround = 0.6F;      ///< of the width: walls all round an end are as near as this to a circle
constexpr float kFacing = 0.3F;      ///< least inner product of their normals with the way to its middle
constexpr float kClear = 0.3F;       ///< of the width: round the middle of the bore there is no point so near
constexpr float kSpacing = 0.5F;     ///< of epsilon, of the points that are added
constexpr float kPi = 3.14159265F;

struct End {
  std::uint32_t point = 0;
  float width = 0;
};

/// Between two ends, along the wall.
struct Line {
  Vec3f from;
  Vec3f chord;
  float length;
  Vec3f normal;  ///< of the wall
};

/// Cells that have a point already.
class Cells {
 public:
  Cells(std::span<std::uint64_t> slots, const Vec3f& low, float edge) : slots_(slots), low_(low), inverse_(1 / edge) {
    std::fill(slots_.begin(), slots_.end(), 0);
  }
  /// @returns false: it was taken
  bool take(const Vec3f& p) {
    std::uint64_t key = 1;
    for (int axis = 0; axis < 3; ++axis) {
      key = key << 21U | (static_cast<std::uint64_t>((p[axis] - low_[axis]) * inverse_) & 0x1FFFFFU);
    }
    auto slot = static_cast<std::size_t>(key * 0x9E3779B97F4A7C15U >> (64 - std::bit_width(slots_.size() - 1)));
    while (slots_[slot] != 0 && slots_[slot] != key) slot = (slot + 1) % slots_.size();
    if (slots_[slot] == key) return false;
    slots_[slot] = key;
    return true;
  }

 private:
  std::span<std::uint64_t> slots_;  ///< 0: empty; a power of two of them, of which half stay empty
  Vec3f low_;
  float inverse_;
};

std::size_t slots_for(std::uint32_t room) { return std::bit_ceil(std::size_t{2} * room + 2); }

class Continuation {
 public:
  Continuation(Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering, std::span<End> ends, Cells& cells)
      : cloud_(cloud),
        tree_(tree),
        epsilon_(clustering.epsilon),
        growth_(std::sqrt(clustering.support_points)),
        seen_(cloud.size),
        ends_(ends),
        cells_(cells) {}

  Status run(const StageProgress& progress) {
    PLUMBLINE_TRY(find_ends(progress.part(0, 0.5)));
    const StageProgress joining = progress.part(0.5, 1);
    for (std::size_t a = 0; a < ends_.size(); ++a) {
      if (!joining.advance(static_cast<double>(a) / static_cast<double>(ends_.size()))) return cancelled();
      for (std::size_t b = a + 1; b < ends_.size(); ++b) {
        if (const auto line = line_between(ends_[a], ends_[b])) fill(*line);
      }
    }
    return {};
  }

  std::uint32_t added() const { return cloud_.size - seen_; }

 private:
  static Status cancelled() { return fail(ErrorCode::kCancelled, "cancelled while the walls of bores were continued"); }

  Status find_ends(const StageProgress& progress) {
    std::uint32_t sparse = 0;
    for (std::uint32_t i = 0; i < seen_; ++i) sparse += is_sparse(i) ? 1 : 0;
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < seen_ && sparse <= seen_ / kFewSparse && count < ends_.size(); ++i) {
      if (i % kChunk == 0 && !progress.advance(1.0 * i / seen_)) return cancelled();
      if (!is_sparse(i)) continue;
      if (const auto width = width_at(i)) ends_[count++] = {i, *width};
    }
    ends_ = ends_.first(count);
    return {};
  }

  bool is_sparse(std::uint32_t i) const { return is_surface(i) && cloud_.radius[i] >= kSparse * epsilon_ * growth_; }

  bool is_surface(std::uint32_t i) const { return cloud_.normal[i].point_class != PointClass::kNoise; }

  /// Squared; of the surface as it was seen.
  float distance2(const Vec3f& x) const {
    std::array<Neighbour, 1> found{};
    tree_.nearest(x, found, [&](std::uint32_t i) { return is_surface(i); });
    return found[0].distance2;
  }

  /// How far off point i the wall is that faces it; nothing if there is none.
  std::optional<float> width_at(std::uint32_t i) const {
    const Vec3f n = cloud_.normal[i].unpack();
    const Vec3f& p = cloud_.position[i];
    for (float t = epsilon_; t < kWidest * epsilon_;) {
      std::array<Neighbour, 8> found{};
      const std::uint32_t count = tree_.nearest(p + n * t, found, [&](std::uint32_t j) { return is_surface(j); });
      const float reach = std::max(0.5F * epsilon_, 0.4F * t);  // the wall may be as sparse there
      for (const Neighbour& other : std::span(found).first(count)) {
        if (other.distance2 > reach * reach || cloud_.normal[other.index].unpack().dot(n) > kOpposite) continue;
        const float width = (cloud_.position[other.index] - p).dot(n);
        if (width >= 0.5F * epsilon_) return width;
      }
      t += std::max(0.5F * epsilon_, 0.5F * std::sqrt(found[0].distance2));
    }
    return std::nullopt;
  }

  /// Nothing where they do not belong together.
  std::optional<Line> line_between(const End& a, const End& b) const {
    const Vec3f& p = cloud_.position[a.point];
    const Vec3f chord = cloud_.position[b.point] - p;
    const float width = std::min(a.width, b.width);
    const float length2 = chord.dot(chord);
    const float longest = kLongest * width;
    const float shortest = kShortest * epsilon_;
    if (length2 > longest * longest || length2 < shortest * shortest) return std::nullopt;
    if (std::max(a.width, b.width) > kWidthRatio * width) return std::nullopt;
    const Vec3f normal_a = cloud_.normal[a.point].unpack();
    const Vec3f normal_b = cloud_.normal[b.point].unpack();
    if (normal_a.dot(normal_b) < kAlike) return std::nullopt;
    const float length = std::sqrt(length2);
    const Vec3f along = chord * (1 / length);
    const Vec3f mean = normal_a + normal_b;
    const float slope = mean.dot(along);
    if (slope * slope > kSlope * kSlope * mean.dot(mean)) return std::nullopt;
    const Vec3f across = mean - along * slope;
    const Line line{p, chord, length, across * (1 / std::sqrt(across.dot(across)))};
    if (!unseen(line, width) || !enclosed(p, line, width) || !enclosed(p + chord, line, width)) return std::nullopt;
    return line;
  }

  /// Whether there are walls all round the bore at a place on its wall.
  bool enclosed(const Vec3f& wall, const Line& line, float width) const {
    const Vec3f axis = wall + line.normal * (0.5F * width);
    const Vec3f sideways = line.chord.cross(line.normal) * (1 / line.length);
    constexpr float kDiagonal = 0.70710678F;
    constexpr std::array<std::array<float, 2>, 8> kRound{{{1, 0},
                                                          {kDiagonal, kDiagonal},
                                                          {0, 1},
                                                          {-kDiagonal, kDiagonal},
                                                          {-1, 0},
                                                          {-kDiagonal, -kDiagonal},
                                                          {0, -1},
                                                          {kDiagonal, -kDiagonal}}};
    return std::all_of(kRound.begin(), kRound.end(), [&](const auto& direction) {
      const Vec3f outwards = line.normal * direction[0] + sideways * direction[1];
      return faces(axis + outwards * (0.5F * width), outwards * -1, kAround * width);
    });
  }

  /// Whether a point within `reach` of x faces this way.
  bool faces(const Vec3f& x, const Vec3f& way, float reach) const {
    return any_near(x, [&](const Neighbour& other) {
      return other.distance2 < reach * reach && cloud_.normal[other.index].unpack().dot(way) > kFacing;
    });
  }

  /// Whether it holds for one of the points of the surface that are nearest to x.
  template <class Holds>
  bool any_near(const Vec3f& x, Holds holds) const {
    std::array<Neighbour, 8> found{};
    const std::uint32_t count = tree_.nearest(x, found, [&](std::uint32_t i) { return is_surface(i); });
    return std::any_of(found.begin(), found.begin() + count, holds);
  }

  void fill(const Line& line) {
    const auto steps = static_cast<int>(line.length / (kSpacing * epsilon_));
    for (int k = 1; k < steps && cloud_.size < cloud_.capacity(); ++k) {
      const Vec3f x = line.from + line.chord * (static_cast<float>(k) / static_cast<float>(steps));
      if (!has_wall(x, line.normal) && cells_.take(x)) add(x, line.normal);
    }
  }

  bool unseen(const Line& line, float width) const {
    const Vec3f along = line.chord * (1 / line.length);
    const float step = 0.5F * epsilon_;
    for (float t = 0.25F * line.length; t < 0.75F * line.length; t += step) {
      if (distance2(line.from + along * t) < epsilon_ * epsilon_) return false;
    }
    const float clear2 = kClear * kClear * width * width;
    const Vec3f middle = line.from + line.normal * (0.5F * width);
    for (float t = step; t < line.length - step; t += 0.25F * width) {
      if (distance2(middle + along * t) < clear2) return false;
    }
    return true;
  }

  /// Whether x lies in the share of the wall that a point was seen of.
  bool has_wall(const Vec3f& x, const Vec3f& normal) const {
    return any_near(x, [&](const Neighbour& other) {
      const float share = std::min(cloud_.radius[other.index] / growth_, epsilon_);
      return other.distance2 < share * share && cloud_.normal[other.index].unpack().dot(normal) > kAlike;
    });
  }

  void add(const Vec3f& x, const Vec3f& normal) {
    const std::uint32_t i = cloud_.size++;
    cloud_.position[i] = x;
    cloud_.normal[i] = {};
    cloud_.normal[i].set(normal);
    cloud_.normal[i].point_class = orientation_of(cloud_.normal[i]);
    cloud_.radius[i] = growth_ * kSpacing * epsilon_ / std::sqrt(kPi);
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  float epsilon_;
  float growth_;        ///< of a support's radius over that of one point's share
  std::uint32_t seen_;  ///< points of the scan
  std::span<End> ends_;
  Cells& cells_;
};

}  // namespace

std::size_t bore_walls_bytes(std::uint32_t points) {
  return Arena::rounded(kMostEnds * sizeof(End)) +
         Arena::rounded(slots_for(Cloud::spare(points)) * sizeof(std::uint64_t));
}

Expected<BoreWalls> continue_bore_walls(Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering,
                                        Arena& arena, const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto ends = arena.take_top<End>(kMostEnds, kStage);
  PLUMBLINE_TRY(ends);
  const auto slots = arena.take_top<std::uint64_t>(slots_for(cloud.capacity() - cloud.size), kStage);
  PLUMBLINE_TRY(slots);
  Cells cells(*slots, cloud.bounds().low, kSpacing * clustering.epsilon);
  Continuation continuation(cloud, tree, clustering, *ends, cells);
  PLUMBLINE_TRY(continuation.run(progress));
  cloud.continued = continuation.added();
  const float edge = kSpacing * clustering.epsilon;
  return BoreWalls{cloud.continued, edge * edge * static_cast<float>(cloud.continued)};
}

}  // namespace plumbline
