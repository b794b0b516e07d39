#include "slicer/views/grid_growth.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "slicer/core/lanes.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

constexpr std::size_t kSample = ViewGridFit::kMaxPoints;
/// Growth of the radius in one step. The grid must be right to a third of a pixel at the new radius, so that larger
/// steps lose it and smaller ones take longer.
constexpr double kGrowth = 1.4;
// Distance from the grid within which points count, pixels: from the one that suits a start a third of a pixel off,
// down to the one that decides which points are the view's.
constexpr double kCoarse = 0.3;
constexpr double kMedium = 0.2;
constexpr double kFine = 0.12;
constexpr double kFinest = 0.06;
constexpr double kSettled = 0.1;  ///< share of the width: after a step that moves the grid by less comes the next width
/// Points on a grid above those by chance, in standard deviations. High, since many pairs of peaks are tried.
constexpr double kSignificance = 8;
// Range of a pixel's size while its grid grows, over the first: a fit that shrinks or stretches it has left the view.
constexpr double kMinScale = 0.7;
constexpr double kMaxScale = 1.4;
constexpr double kViewShare = 0.9;  ///< share of a view's points that its tolerance must hold
constexpr double kMaxChance = 0.3;  ///< share of the points within the tolerance that may be there by chance
constexpr double kPi = std::numbers::pi;

/// The number of points within a distance of the grid, and how many to expect there by chance.
struct Score {
  double near, chance;
  bool is_significant() const { return near - chance > kSignificance * std::sqrt(chance + 1); }
};

Score score(std::span<const float> distances2, double width) {
  const auto limit = static_cast<float>(width * width);
  const auto near = std::count_if(distances2.begin(), distances2.end(), [limit](float d2) { return d2 < limit; });
  return {static_cast<double>(near), kPi * width * width * static_cast<double>(distances2.size())};
}

/// Whether the pixels around the middle have kept about their size.
bool keeps_scale(const ViewGrid& grid, const ViewGrid& first) {
  const double u = grid.map.segment<3>(0).norm() / first.map.segment<3>(0).norm();
  const double v = grid.map.segment<3>(4).norm() / first.map.segment<3>(4).norm();
  return std::min(u, v) > kMinScale && std::max(u, v) < kMaxScale;
}

}  // namespace

std::size_t GridGrowth::bytes() { return kSample * (7 * sizeof(float) + sizeof(std::uint32_t)); }

Expected<GridGrowth> GridGrowth::create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                        Arena& arena) {
  auto room = arena.take_top<float>(4 * kSample, kStage);
  PLUMBLINE_TRY(room);
  auto sample = arena.take_top<float>(3 * kSample, kStage);
  PLUMBLINE_TRY(sample);
  auto sampled = arena.take_top<std::uint32_t>(kSample, kStage);
  PLUMBLINE_TRY(sampled);
  const Vec3f size = cloud.bounds().size();
  GridGrowth growth(cloud, tree, view_of, 0.5 * std::sqrt(static_cast<double>(size.dot(size))), *room);
  for (std::size_t axis = 0; axis < 3; ++axis) growth.sample_[axis] = sample->subspan(axis * kSample, kSample);
  growth.sampled_ = *sampled;
  return growth;
}

/// @returns whether clearly more points lie on the grid than would by chance
bool GridGrowth::fit(ViewGrid& grid, const LocalPoints& points, double radius) const {
  for (const auto& [width, steps] : {std::pair{kCoarse, 3}, {kMedium, 2}, {kFine, 2}, {kFinest, 2}}) {
    for (int step = 0; step < steps; ++step) {
      const auto moved = fit_.improve(grid, points, radius, width);
      if (!moved) return false;
      if (*moved < kSettled * width) break;
    }
  }
  const auto distances2 = room_.first(points.size());
  distances2_from_grid(grid, points, distances2);
  return score(distances2, kFinest).is_significant();
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
  constexpr double kWidest = 0.1;
  const LocalPoints sample = take_sample(grid.middle, radius);
  for (int k = 0; k < 3; ++k) fit_.improve(grid, sample, radius, kFinest / 2);
  const auto distances2 = room_.first(sample.size());
  distances2_from_grid(grid, sample, distances2);
  const Score wide = score(distances2, kWidest);
  for (const double width : {0.005, 0.01, 0.02, 0.04, 0.06, kWidest}) {
    const Score s = score(distances2, width);
    if (s.near - s.chance < kViewShare * (wide.near - wide.chance)) continue;
    return s.chance < kMaxChance * s.near ? width : 0;
  }
  return 0;
}

/// Free points around `middle`: all of them, or every second, fourth, and so on, so that they fit.
LocalPoints GridGrowth::take_sample(const Vec3f& middle, double radius) {
  const auto r = static_cast<float>(radius);
  const double share = std::min(1.0, radius * radius / (extent_ * extent_));
  const double expected = share * cloud_->size / (2 * static_cast<double>(kSample));
  std::uint32_t stride = std::bit_floor(std::max(1U, static_cast<std::uint32_t>(expected)));
  std::size_t size = 0;
  const auto keep = [&](std::size_t to, std::size_t from) {
    for (const auto& axis : sample_) axis[to] = axis[from];
    sampled_[to] = sampled_[from];
  };
  const auto add = [&](std::uint32_t i) {
    const Vec3f d = cloud_->position[i] - middle;
    if (view_of_[i] != kNoView || d.dot(d) > r * r) return;
    if (size == kSample) {
      stride *= 2;
      std::size_t kept = 0;
      for (std::size_t k = 0; k < size; ++k) {
        if ((sampled_[k] & (stride - 1)) == 0) keep(kept++, k);
      }
      size = kept;
      if ((i & (stride - 1)) != 0) return;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) sample_[axis][size] = d[static_cast<Eigen::Index>(axis)];
    sampled_[size++] = i;
  };
  for (;;) {
    tree_->visit_box(middle - Vec3f::Constant(r), middle + Vec3f::Constant(r),
                     [&](std::uint32_t first, std::uint32_t last) {
                       for (std::uint32_t i = (first + stride - 1) & ~(stride - 1); i < last;) {
                         add(i);
                         i = (i & ~(stride - 1)) + stride;
                       }
                     });
    if (size >= kSample / 4 || stride == 1) break;
    stride = std::max(1U, stride / 4);
    size = 0;
  }
  size -= size % kLanes;
  return {sample_[0].first(size), sample_[1].first(size), sample_[2].first(size)};
}

}  // namespace plumbline
