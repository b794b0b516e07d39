#include "slicer/views/grid_growth.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

constexpr std::size_t kSample = ViewGridFit::kMaxPoints;
constexpr std::uint32_t kBlock = 1024;      ///< points of the cloud that one thread looks at in a row
constexpr std::size_t kRoom = kSample + 1;  ///< points: one more than fit, before every second one is dropped
/// Growth of the radius in one step. The grid must be right to a third of a pixel at the new radius, so that larger
/// steps lose it and smaller ones take longer.
constexpr double kGrowth = 1.4;
constexpr double kFinest = 0.06;  ///< pixels: distance from the grid within which points are the view's
/// Distances from the grid within which points count, pixels, from the one that suits a start a third of a pixel off; and the most
/// steps with each.
constexpr std::array kWidths = {std::pair{0.3, 3}, std::pair{0.2, 2}, std::pair{0.12, 2}, std::pair{kFinest, 2}};
constexpr double kSettled = 0.1;  ///< share of the width: after a step that moves the grid by less comes the next width
/// Points on a grid above those by chance, in standard deviations. High, since many pairs of peaks are tried.
constexpr double kSignificance = 8;
/// Largest change of a pixel's size while its grid grows, either way: a fit that shrinks or stretches it more has left the view.
constexpr double kMaxScale = 1.4;
constexpr double kViewShare = 0.9;  ///< share of a view's points that its tolerance must hold
constexpr double kMaxChance = 0.3;  ///< share of the points within the tolerance that may be there by chance

/// One thread's part is the whole.
std::size_t parts_for(std::size_t threads) { return threads > 1 ? threads + 1 : 1; }

/// The number of points within a distance of the grid, and how many to expect there by chance.
struct Score {
  double near, chance;
  Score(std::uint32_t count, double width, std::size_t points)
      : near(count), chance(std::numbers::pi * width * width * static_cast<double>(points)) {}
  bool is_significant() const { return near - chance > kSignificance * std::sqrt(chance + 1); }
};

/// Whether the pixels around the middle have kept about their size.
bool keeps_scale(const ViewGrid& grid, const ViewGrid& first) {
  const double u = grid.map.segment<3>(0).norm() / first.map.segment<3>(0).norm();
  const double v = grid.map.segment<3>(4).norm() / first.map.segment<3>(4).norm();
  return std::min(u, v) > 1 / kMaxScale && std::max(u, v) < kMaxScale;
}

}  // namespace

std::size_t GridGrowth::bytes(std::uint32_t threads) {
  const std::size_t parts = parts_for(threads);
  return 3 * kSample * sizeof(float) + parts * (sizeof(Part) + kRoom * (3 * sizeof(float) + sizeof(std::uint32_t)));
}

Expected<GridGrowth> GridGrowth::create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                        Arena& arena) {
  const auto room = arena.take_top<float>(3 * kSample, kStage);
  PLUMBLINE_TRY(room);
  const Vec3f size = cloud.bounds().size();
  GridGrowth growth(cloud, tree, view_of, 0.5 * std::sqrt(static_cast<double>(size.dot(size))), *room);
  PLUMBLINE_TRY(arena.take_top(growth.parts_, parts_for(static_cast<std::size_t>(omp_get_max_threads())), kStage));
  for (Part& part : growth.parts_) {
    part = {};
    for (std::span<float>& axis : part.at) PLUMBLINE_TRY(arena.take_top(axis, kRoom, kStage));
    PLUMBLINE_TRY(arena.take_top(part.index, kRoom, kStage));
  }
  return growth;
}

/// @returns whether clearly more points lie on the grid than would by chance
bool GridGrowth::fit(ViewGrid& grid, const LocalPoints& points, double radius) const {
  for (const auto& [width, steps] : kWidths) {
    for (int step = 0; step < steps; ++step) {
      const auto moved = fit_.improve(grid, points, radius, width);
      if (!moved) return false;
      if (*moved < kSettled * width) break;
    }
  }
  std::uint32_t near = 0;
  count_near(grid, points, std::span(&kFinest, 1), std::span(&near, 1));
  return Score(near, kFinest, points.size()).is_significant();
}

std::optional<GrownGrid> GridGrowth::grow(ViewGrid grid, double radius, const LocalPoints& points) {
  const ViewGrid first = grid;
  GrownGrid grown;
  for (;;) {
    const LocalPoints sample = grown.radius == 0 && points.size() > 0 ? points : take_sample(grid.middle, radius);
    if (!fit(grid, sample, radius) || !keeps_scale(grid, first)) break;
    grown.grid = grid;
    grown.radius = radius;
    if (radius > 2 * extent_) break;
    radius *= kGrowth;
  }
  if (grown.radius == 0) return std::nullopt;
  grown.tolerance = tolerance_of(grown.grid, grown.radius);
  if (grown.tolerance == 0) return std::nullopt;
  return grown;
}

/// Fits the grid once more, then returns the smallest width that holds most of its points, in pixels. 0 if too many
/// points would lie within it by chance.
double GridGrowth::tolerance_of(ViewGrid& grid, double radius) {
  constexpr std::array kTolerances = {0.005, 0.01, 0.02, 0.04, 0.06, 0.1};
  const LocalPoints sample = take_sample(grid.middle, radius);
  for (int k = 0; k < 3; ++k) fit_.improve(grid, sample, radius, kFinest / 2);
  std::array<std::uint32_t, kTolerances.size()> near = {};
  count_near(grid, sample, kTolerances, near);
  const Score wide(near.back(), kTolerances.back(), sample.size());
  for (std::size_t k = 0; k < near.size(); ++k) {
    const Score s(near[k], kTolerances[k], sample.size());
    if (s.near - s.chance < kViewShare * (wide.near - wide.chance)) continue;
    return s.chance < kMaxChance * s.near ? kTolerances[k] : 0;
  }
  return 0;
}

/// Doubles the stride.
void GridGrowth::Part::thin() {
  stride *= 2;
  const std::size_t before = size;
  size = 0;
  for (std::size_t k = 0; k < before; ++k) {
    if ((index[k] & (stride - 1)) != 0) continue;
    for (const std::span<float>& axis : at) axis[size] = axis[k];
    index[size++] = index[k];
  }
}

/// Adds the points of another part up to `end`.
void GridGrowth::Part::take(Part& from, std::size_t end) {
  const std::size_t count = end - from.taken;
  for (std::size_t axis = 0; axis < 3; ++axis) std::copy_n(&from.at[axis][from.taken], count, &at[axis][size]);
  size += count;
  from.taken = end;
}

/// Free points around `middle`: all of them, or every second, fourth, and so on, so that they fit.
LocalPoints GridGrowth::take_sample(const Vec3f& middle, double radius) {
  const double share = std::min(1.0, radius * radius / (extent_ * extent_));
  const double expected = share * cloud_->size / (2 * static_cast<double>(kSample));
  std::uint32_t stride = std::bit_floor(std::max(1U, static_cast<std::uint32_t>(expected)));
  for (;;) {
    const Part& sample = collect(middle, static_cast<float>(radius), stride);
    if (sample.size >= kSample / 4 || sample.stride == 1) {
      const std::size_t size = sample.size - sample.size % kLanes;
      return {sample.at[0].first(size), sample.at[1].first(size), sample.at[2].first(size)};
    }
    stride = std::max(1U, sample.stride / 4);
  }
}

/// @param stride  of the sample, at least: the smallest with which the points fit
const GridGrowth::Part& GridGrowth::collect(const Vec3f& middle, float radius, std::uint32_t stride) {
  for (Part& part : parts_) {
    part.size = part.taken = 0;
    part.stride = stride;
  }
#pragma omp parallel
  collect_part(middle, radius, static_cast<std::uint32_t>(omp_get_thread_num()),
               static_cast<std::uint32_t>(omp_get_num_threads()));
  Part& whole = parts_.back();
  const auto parts = parts_.first(parts_.size() - 1);
  if (parts.empty()) return whole;
  for (const Part& part : parts) whole.stride = std::max(whole.stride, part.stride);
  for (;; whole.stride *= 2) {
    const bool differ = std::any_of(parts.begin(), parts.end(), [&](const Part& p) { return p.stride < whole.stride; });
#pragma omp parallel for schedule(dynamic) if (differ)
    for (Part& part : parts) {
      while (part.stride < whole.stride) part.thin();
    }
    std::size_t size = 0;
    for (const Part& part : parts) size += part.size;
    if (size <= kSample) break;
  }
  for (;;) {
    Part* next = nullptr;
    for (Part& part : parts) {
      if (part.taken == part.size) continue;
      if (next == nullptr || part.index[part.taken] < next->index[next->taken]) next = &part;
    }
    if (next == nullptr) return whole;
    const std::uint32_t block = next->index[next->taken] / kBlock;  // all of it is in this part
    std::size_t end = next->taken;
    while (end < next->size && next->index[end] / kBlock == block) ++end;
    whole.take(*next, end);
  }
}

/// Takes the points of a thread: the blocks of the cloud go around.
void GridGrowth::collect_part(const Vec3f& middle, float radius, std::uint32_t thread, std::uint32_t threads) {
  Part part = parts_[thread];  // a copy, since threads that write side by side wait for each other
  const auto add = [&](std::uint32_t i) {
    if (view_of_[i] != kNoView) return;
    const Vec3f d = cloud_->position[i] - middle;
    if (d.dot(d) > radius * radius) return;
    for (std::size_t axis = 0; axis < 3; ++axis) part.at[axis][part.size] = d[static_cast<Eigen::Index>(axis)];
    part.index[part.size++] = i;
    while (part.size > kSample) part.thin();
  };
  tree_->visit_box(middle - Vec3f::Constant(radius), middle + Vec3f::Constant(radius),
                   [&](std::uint32_t first, std::uint32_t last) {
                     for (std::uint32_t begin = first; begin < last;) {
                       const std::uint32_t end = std::min(last, (begin / kBlock + 1) * kBlock);
                       if (begin / kBlock % threads == thread) {
                         for (std::uint32_t i = (begin + part.stride - 1) & ~(part.stride - 1); i < end;) {
                           add(i);
                           i = (i & ~(part.stride - 1)) + part.stride;
                         }
                       }
                       begin = end;
                     }
                   });
  parts_[thread] = part;
}

}  // namespace plumbline
