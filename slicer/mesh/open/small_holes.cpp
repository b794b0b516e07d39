#include "slicer/mesh/open/small_holes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "mesh";

/// One run of an open edge.
struct Run {
  LatticePoint from, to;
  Vec3f outward = Vec3f::Zero();
  std::uint32_t users = 0;
  std::uint32_t left =
      0;  ///< of the first run from a place: those from there that have been walked along, which are the first ones
};

struct Loop {
  std::array<Run, kMostCorners> run;
  std::size_t corners = 0;
};

/// Whether a loop is the rim of a lone triangle, or of two.
bool is_alone(const Loop& loop) {
  const auto runs = std::span(loop.run).first(loop.corners);
  std::size_t different = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto before = runs.first(i);
    const auto same = [&](const Run& run) { return run.users == runs[i].users; };
    different += std::ranges::none_of(before, same) ? 1 : 0;
  }
  // A triangle that reaches into a larger hole has two of its edges.
  return different + (loop.corners > 3 ? 1 : 0) < loop.corners;
}

class HoleCloser {
 public:
  HoleCloser(std::span<Run> runs, std::span<std::uint32_t> path, std::span<LatticeTriangle> caps,
             std::span<RimCorner> rim, const Vec3d& steps, std::size_t most)
      : runs_(runs), path_(path), caps_(caps), rim_(rim), steps_(steps), most_(most) {}

  void close_all() {
    for (const Run& run : runs_) {
      while (leave(run.from)) follow();
    }
  }
  std::size_t caps() const { return capped_; }
  std::uint64_t holes() const { return holes_; }
  std::size_t rim() const { return rim_size_; }

 private:
  /// Adds the next run from a place to the path. @returns false: there is none
  bool leave(const LatticePoint& place) {
    const auto first = std::lower_bound(runs_.begin(), runs_.end(), place,
                                        [](const Run& run, const LatticePoint& p) { return run.from < p; });
    if (first == runs_.end()) return false;
    const std::size_t next = static_cast<std::size_t>(first - runs_.begin()) + first->left;
    if (next >= runs_.size() || runs_[next].from != place) return false;
    ++first->left;
    path_[length_++] = static_cast<std::uint32_t>(next);
    return true;
  }

  /// Walks on, and closes each small loop as soon as the way comes back to one of its last corners.
  void follow() {
    while (length_ > 0) {
      const LatticePoint at = runs_[path_[length_ - 1]].to;
      const std::size_t seen = std::min(length_, kMostCorners);
      std::size_t corners = 1;
      while (corners <= seen && runs_[path_[length_ - corners]].from != at) ++corners;
      if (corners <= seen) {
        length_ -= corners;
        Loop loop;
        for (std::size_t i = 0; i < corners; ++i) loop.run[i] = runs_[path_[length_ + i]];
        loop.corners = corners;
        close(loop);
      } else if (!leave(at)) {  // it is where it began, a long way round
        leave_open(std::span(path_).first(length_), [&](std::uint32_t run) { return runs_[run]; });
        length_ = 0;
      }
    }
  }

  void close(const Loop& loop) {
    if (loop.corners < 3 || loop.corners > most_ || is_alone(loop)) {
      leave_open(std::span(loop.run).first(loop.corners), [](const Run& run) { return run; });
      return;
    }
    ++holes_;
    // The fan with the shortest diagonals.
    std::size_t apex = 0;
    double least = 0;
    for (std::size_t a = 0; a < loop.corners; ++a) {
      double sum = 0;
      for (std::size_t i = 2; i + 1 < loop.corners; ++i) sum += squared_length(loop.run[a].from, corner(loop, a + i));
      if (a == 0 || sum < least) {
        least = sum;
        apex = a;
      }
    }
    for (std::size_t i = 1; i + 1 < loop.corners; ++i) {
      caps_[capped_++] = {loop.run[apex].from, corner(loop, apex + i + 1), corner(loop, apex + i)};
    }
  }

  /// Adds a loop to the rim: there from the rim's first corner, around, and back.
  template <class Runs, class Get>
  void leave_open(const Runs& runs, Get get) {
    const bool first = rim_size_ == 0;
    for (const auto& entry : runs) {
      const Run& run = get(entry);
      const float length = std::sqrt(run.outward.dot(run.outward));
      rim_[rim_size_++] = {run.from, length > 0 ? Vec3f(run.outward / length) : Vec3f::Zero()};
    }
    rim_[rim_size_++] = {get(runs.front()).from, Vec3f::Zero(), true};
    if (!first) rim_[rim_size_++] = {rim_[0].place, Vec3f::Zero(), true};
  }

  static const LatticePoint& corner(const Loop& loop, std::size_t i) { return loop.run[i % loop.corners].from; }
  double squared_length(const LatticePoint& a, const LatticePoint& b) const {
    const Vec3d d(steps_[0] * (b.x - a.x), steps_[1] * (b.y - a.y), steps_[2] * (b.z - a.z));
    return d.dot(d);
  }

  std::span<Run> runs_;            ///< sorted by their beginnings
  std::span<std::uint32_t> path_;  ///< runs
  std::size_t length_ = 0;         ///< of the path
  std::span<LatticeTriangle> caps_;
  std::span<RimCorner> rim_;
  Vec3d steps_;
  std::size_t most_;
  std::size_t rim_size_ = 0;
  std::size_t capped_ = 0;
  std::uint64_t holes_ = 0;
};

/// Corners of the rim of that many runs: a loop of two or more has two more.
std::size_t most_rim_corners(std::size_t runs) { return 2 * runs; }

}  // namespace

std::size_t small_hole_bytes(std::uint64_t runs) {
  const auto count = static_cast<std::size_t>(runs);
  return Arena::rounded(most_rim_corners(count) * sizeof(RimCorner)) + Arena::rounded(count * sizeof(LatticeTriangle)) +
         Arena::rounded(count * sizeof(Run)) + Arena::rounded(count * sizeof(std::uint32_t));
}

Expected<SmallHoles> close_small_holes(const OpenEdges& edges, const Vec3d& steps, std::size_t most, Arena& arena) {
  const auto count = static_cast<std::size_t>(edges.runs());
  const auto caps = arena.take_bottom<LatticeTriangle>(count, kStage);  // a loop has fewer triangles than edges
  PLUMBLINE_TRY(caps);
  const auto rim = arena.take_bottom<RimCorner>(most_rim_corners(count), kStage);
  PLUMBLINE_TRY(rim);
  const auto runs = arena.take_bottom<Run>(count, kStage);
  PLUMBLINE_TRY(runs);
  const auto path = arena.take_bottom<std::uint32_t>(count, kStage);
  PLUMBLINE_TRY(path);
  std::size_t i = 0;
  edges.for_each([&](const OpenEdge& edge, const EdgeUsers& users) {
    const bool up = edge.surplus > 0;
    for (std::int32_t k = std::abs(edge.surplus); k > 0; --k) {
      (*runs)[i++] = {up ? edge.low : edge.high, up ? edge.high : edge.low, users.outward, users.numbers, 0};
    }
  });
  std::sort(runs->begin(), runs->end(),
            [](const Run& a, const Run& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
  HoleCloser closer(*runs, *path, *caps, *rim, steps, most);
  closer.close_all();
  return SmallHoles{caps->first(closer.caps()), closer.holes(), rim->first(closer.rim())};
}

}  // namespace plumbline::inline slicer
