#include "slicer/normals/normal_orientation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/normals/sheets.hpp"
#include "slicer/normals/sided_sets.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "normals";

constexpr std::uint32_t kPairs = 10;  ///< nearest points that may be joined to a point; more bridge gaps but cost time
constexpr std::uint32_t kBatch = 4096;  ///< points whose neighbours are searched at once, in parallel: 180 KB
constexpr std::uint32_t kNoPoint = 0xFFFFFFFFU;

/// Lower limits of |join_weight()| of each class, surest first. Pairs below the last are not joined: one such pair, at the
/// rim of a hole or where two sheets touch, could turn a whole sheet the wrong way. The field decides instead.
constexpr std::array<float, 3> kLeastWeight = {0.95F, 0.8F, 0.5F};
constexpr std::uint8_t kNoClass = kLeastWeight.size();

class NormalTurning {
 public:
  NormalTurning(Cloud& cloud, const KdTree3& tree, std::span<const std::uint64_t> estimated, Arena& arena,
                const StageProgress& progress)
      : cloud_(cloud), tree_(tree), estimated_(estimated), arena_(arena), progress_(progress) {}

  Expected<std::uint32_t> run() {
    auto entries = arena_.take_top<std::uint32_t>(cloud_.size, kStage);
    PLUMBLINE_TRY(entries);
    sets_ = SidedSets(*entries);
    bool any = false;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      sets_.start(i, !may_turn(i));
      any |= may_turn(i);
    }
    PLUMBLINE_TRY(Sheets::limit_areas(cloud_, arena_));
    if (!any) return 0U;
    PLUMBLINE_TRY(join());
    const auto counts = Sheets(cloud_, sets_, arena_).turn(FirstSide::kKnownOrConvex);
    PLUMBLINE_TRY(counts);
    return counts->turned;
  }

 private:
  bool may_turn(std::uint32_t i) const {
    return !cloud_.has_scanner(i) && (estimated_.empty() || ((estimated_[i / 64] >> (i % 64)) & 1U) != 0);
  }

  static std::uint8_t class_of(float magnitude) {
    std::uint8_t c = 0;
    while (c < kNoClass && magnitude < kLeastWeight[c]) ++c;
    return c;
  }

  /// Joins neighbours, class by class. A later class only searches points that still have a pair of it to join.
  Status join() {
    const ArenaScope scope(arena_);
    const std::uint32_t batch = std::min(kBatch, cloud_.size);
    PLUMBLINE_TRY(arena_.take_top(open_, batch, kStage));
    PLUMBLINE_TRY(arena_.take_top(pairs_, std::size_t{batch} * kPairs, kStage));
    PLUMBLINE_TRY(arena_.take_top(next_class_, cloud_.size, kStage));
    for (std::uint32_t i = 0; i < cloud_.size; ++i) next_class_[i] = cloud_.normal[i].known() ? 0 : kNoClass;
    for (std::uint8_t c = 0; c < kNoClass; ++c) {
      std::uint32_t next = 0;
      while (next < cloud_.size) {
        std::uint32_t count = 0;
        for (; next < cloud_.size && count < batch; ++next) {
          if (next_class_[next] <= c) open_[count++] = next;
        }
        // The first class searches every point, the others only those that it left.
        const double done = c == 0 ? 0.5 * next / cloud_.size : 0.5 + 0.5 * c / kNoClass;
        if (!progress_.advance(done)) return fail(ErrorCode::kCancelled, "cancelled while orienting normals");
        search(count);
        for (std::uint32_t k = 0; k < count; ++k) join_point(k, c);
      }
    }
    return {};
  }

  void search(std::uint32_t count) {
#pragma omp parallel for schedule(dynamic, 64)
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t i = open_[k];
      std::array<Neighbour, kPairs + 1> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      const std::uint32_t near = tree_.nearest(cloud_.position[i], found);
      std::uint32_t pairs = 0;
      for (std::uint32_t n = 0; n < near && pairs < kPairs; ++n) {
        if (found[n].index != i && cloud_.normal[found[n].index].known()) pairs_[k * kPairs + pairs++] = found[n].index;
      }
      for (; pairs < kPairs; ++pairs) pairs_[k * kPairs + pairs] = kNoPoint;
    }
  }

  /// Runs in one thread, in the order of the points: the order of the joins of a class decides the signs.
  void join_point(std::uint32_t k, std::uint8_t current) {
    const std::uint32_t i = open_[k];
    std::uint8_t next = kNoClass;
    for (std::uint32_t p = k * kPairs; p < (k + 1) * kPairs && pairs_[p] != kNoPoint; ++p) {
      const std::uint32_t j = pairs_[p];
      const SidedSets::Place a = sets_.find(i);
      const SidedSets::Place b = sets_.find(j);
      if (a.root == b.root) continue;
      const float w = join_weight(cloud_, i, j);
      const std::uint8_t c = class_of(std::abs(w));
      if (c <= current) {
        sets_.unite(a, b, w < 0);
      } else {
        next = std::min(next, c);
      }
    }
    next_class_[i] = next;
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  std::span<const std::uint64_t> estimated_;
  Arena& arena_;
  StageProgress progress_;
  SidedSets sets_;
  std::span<std::uint32_t> open_;       ///< points of the batch
  std::span<std::uint32_t> pairs_;      ///< kPairs neighbours of each point of the batch
  std::span<std::uint8_t> next_class_;  ///< of each point: the surest class that may still join it to another sheet
};

}  // namespace

std::size_t orientation_bytes(std::uint32_t points) {
  const std::size_t sides = sizeof(std::uint32_t) * std::size_t{points};
  const std::size_t batch = sizeof(std::uint32_t) * (kPairs + 1) * std::min(kBatch, points) + points;
  return sides + std::max(batch, Sheets::bytes_needed(points));
}

Expected<std::uint32_t> orient_normals(Cloud& cloud, const KdTree3& tree, std::span<const std::uint64_t> estimated,
                                       Arena& arena, const StageProgress& progress) {
  const ArenaScope scope(arena);
  return NormalTurning(cloud, tree, estimated, arena, progress).run();
}

}  // namespace plumbline::inline slicer
