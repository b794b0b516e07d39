#include "slicer/normals/flipped_normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "slicer/cloud/agreement.hpp"
#include "slicer/normals/normal_orientation.hpp"
#include "slicer/normals/sheets.hpp"
#include "slicer/normals/sided_sets.hpp"

namespace plumbline::inline slicer {
namespace {

// A group is eight consecutive points in the order of the tree, which are neighbours in space. Only its first point searches
// its nearest points, since the searches take most of the time. Larger groups are faster, but join sparse surfaces less well.
constexpr std::uint32_t kGroup = 8;  ///< points in a group; only the first searches its nearest
constexpr std::uint32_t kNearest =
    2 * kGroup;  ///< nearest points that the first is joined with: twice a group, to reach the next
constexpr std::uint32_t kInARow = 3;  ///< following points that each point is joined with
constexpr float kSameSide = 0.5F;     ///< least join_weight(): that across a right-angled edge
constexpr float kNear2 = 4;  ///< followers are joined up to twice the distance of the farthest of the nearest; squared
constexpr std::uint32_t kBatch = 1024;  ///< groups that are searched at once, in parallel: 128 KiB of scratch, twice
constexpr std::int64_t kContradictory = 5;  ///< one in this many pairs of neighbours, see turn_flipped_normals()
constexpr double kJoinShare = 0.6;          ///< of the time, for progress only; the field takes the rest

/// Median radii of a point's share within which others must agree with one on a thin wall: 3 epsilon.
constexpr float kReach = 24;

class FlippedNormals {
 public:
  FlippedNormals(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress)
      : cloud_(cloud), tree_(tree), arena_(arena), progress_(progress) {}

  Expected<NormalCounts> turn() {
    auto entries = arena_.take_top<std::uint32_t>(cloud_.size, "normals");
    PLUMBLINE_TRY(entries);
    sets_ = SidedSets(*entries);
    bool all_seen = true;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      sets_.start(i, cloud_.has_scanner(i));
      all_seen &= cloud_.has_scanner(i);
    }
    PLUMBLINE_TRY(join());
    if (all_seen) return NormalCounts{};
    if (kContradictory * (opposite_ - std::abs(facing_)) > pairs_) {
      NormalCounts counts;
      counts.contradictory = true;
      return counts;
    }
    const auto radius = Sheets::limit_areas(cloud_, arena_);
    PLUMBLINE_TRY(radius);
    if (!progress_.advance(kJoinShare)) return fail(ErrorCode::kCancelled, "cancelled while orienting normals");
    const auto stays = [&](std::uint32_t i) {
      return opposed(cloud_, tree_, i) == Opposed::kBehind &&
             agrees_with_neighbours(cloud_, tree_, i, kReach * *radius);
    };
    return Sheets(cloud_, sets_, arena_).turn(FirstSide::kLargest, stays);
  }

 private:
  Status join() {
    const ArenaScope scope(arena_);
    const std::uint32_t groups = (cloud_.size + kGroup - 1) / kGroup;
    const std::uint32_t most = std::min(kBatch, groups);
    auto block = arena_.take_top<Neighbour>(2 * std::size_t{most} * kNearest, "normals");
    PLUMBLINE_TRY(block);
    std::span<Neighbour> here = block->first(std::size_t{most} * kNearest);
    std::span<Neighbour> before = block->last(here.size());
    for (std::uint32_t first = 0; first < groups; first += kBatch) {
      if (!progress_.advance(kJoinShare * first / groups)) {
        return fail(ErrorCode::kCancelled, "cancelled while orienting normals");
      }
      const std::uint32_t count = std::min(kBatch, groups - first);
#pragma omp parallel
      {
        // One thread joins the batch before, which depends on the order, while the others search.
#pragma omp single nowait
        if (first > 0) join_batch(first - kBatch, kBatch, before);
#pragma omp for schedule(dynamic, 32)
        for (std::uint32_t g = 0; g < count; ++g) search(first + g, here.subspan(std::size_t{g} * kNearest, kNearest));
      }
      std::swap(here, before);
      if (first + count == groups) join_batch(first, count, before);
    }
    return {};
  }

  void search(std::uint32_t group, std::span<Neighbour> found) const {
    const std::uint32_t have = tree_.nearest(cloud_.position[group * kGroup], found);
    std::fill(found.begin() + have, found.end(), found[have - 1]);
  }

  void join_batch(std::uint32_t first, std::uint32_t count, std::span<const Neighbour> found) {
    for (std::uint32_t g = 0; g < count; ++g) {
      join_group((first + g) * kGroup, found.subspan(std::size_t{g} * kNearest, kNearest));
    }
  }

  void join_group(std::uint32_t first, std::span<const Neighbour> nearest) {
    const float farthest2 = nearest.back().distance2;
    const std::uint32_t end = std::min(cloud_.size, first + kGroup);
    for (const Neighbour& n : nearest) count_pair(first, n.index, join_pair(first, n.index));
    for (std::uint32_t i = first; i < end; ++i) {
      cloud_.radius[i] = std::sqrt(farthest2 / kNearest);
      for (std::uint32_t j = i + 1; j <= i + kInARow && j < cloud_.size; ++j) {
        const Vec3f d = cloud_.position[j] - cloud_.position[i];
        if (d.dot(d) <= kNear2 * farthest2) join_pair(i, j);
      }
    }
  }

  /// @returns join_weight(), 0 for a point and itself
  float join_pair(std::uint32_t i, std::uint32_t j) {
    if (i == j) return 0;
    const float weight = join_weight(cloud_, i, j);
    if (weight < kSameSide) return weight;
    const SidedSets::Place a = sets_.find(i);
    const SidedSets::Place b = sets_.find(j);
    if (a.root != b.root) sets_.unite(a, b, false);
    return weight;
  }

  void count_pair(std::uint32_t i, std::uint32_t j, float weight) {
    if (std::abs(weight) < kSameSide) return;
    ++pairs_;
    if (weight > 0) return;
    ++opposite_;
    const float towards = cloud_.normal[i].unpack().dot(cloud_.position[j] - cloud_.position[i]);
    facing_ += towards > 0 ? 1 : towards < 0 ? -1 : 0;
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  Arena& arena_;
  StageProgress progress_;
  SidedSets sets_;
  std::int64_t pairs_ = 0;     ///< of neighbours whose normals are nearly parallel
  std::int64_t opposite_ = 0;  ///< of these, those that face opposite sides
  std::int64_t facing_ = 0;    ///< of these, those that face each other, minus those that face away from each other
};

}  // namespace

std::size_t flipped_normals_bytes(std::uint32_t points) {
  const std::size_t sides = sizeof(std::uint32_t) * std::size_t{points};
  const std::size_t batch = 2 * sizeof(Neighbour) * kNearest * std::size_t{kBatch};
  return std::max(sides + std::max(batch, Sheets::bytes_needed(points)), orientation_bytes(points));
}

Expected<NormalCounts> turn_flipped_normals(Cloud& cloud, const KdTree3& tree, Arena& arena,
                                            const StageProgress& progress) {
  if (cloud.size == 0) return NormalCounts{};
  const std::size_t mark = arena.top_mark();
  auto counts = FlippedNormals(cloud, tree, arena, progress).turn();
  arena.release_top(mark);
  if (!counts || !counts->contradictory) return counts;
  const auto turned = orient_normals(cloud, tree, {}, arena, progress.part(kJoinShare, 1));
  PLUMBLINE_TRY(turned);
  counts->turned = *turned;
  return counts;
}

}  // namespace plumbline::inline slicer
