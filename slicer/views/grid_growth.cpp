#include "slicer/views/grid_growth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

// Sizes that bound memory and time: a view with a fiftieth of the points still has 160 of a sample.
constexpr std::uint32_t kSample = 8192;          ///< points that a grid is fitted to
constexpr std::uint32_t kThinnedPoints = 65536;  ///< points that samples of large parts of the scan are taken from
/// Growth of the radius in one step. The grid must be right to a third of a pixel at the new radius, so that larger
/// steps lose it and smaller ones take longer.
constexpr double kGrowth = 1.4;
// Distance from the grid within which points count, pixels: from the one that suits a start a third of a pixel off,
// down to the one that decides which points are the view's.
constexpr double kCoarse = 0.3;
constexpr double kMedium = 0.2;
constexpr double kFine = 0.12;
constexpr double kFinest = 0.06;
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

Score score(const ViewGrid& grid, std::span<const Vec3f> points, double width) {
  Score s{0, kPi * width * width * static_cast<double>(points.size())};
  for (const Vec3f& p : points) s.near += grid.distance_from_grid(p) < width ? 1 : 0;
  return s;
}

/// Whether the pixels around the middle have kept about their size.
bool keeps_scale(const ViewGrid& grid, const ViewGrid& first) {
  const double u = grid.map.segment<3>(0).norm() / first.map.segment<3>(0).norm();
  const double v = grid.map.segment<3>(4).norm() / first.map.segment<3>(4).norm();
  return std::min(u, v) > kMinScale && std::max(u, v) < kMaxScale;
}

}  // namespace

double GrownGrid::relative_distance(const Vec3f& point) const {
  const double distance = grid.distance_from_grid(point);
  if (distance > tolerance || (point - grid.middle).cast<double>().squaredNorm() > radius * radius) return 2;
  return distance / tolerance;
}

std::size_t GridGrowth::bytes() { return kSample * sizeof(Vec3f) + kThinnedPoints * sizeof(std::uint32_t); }

Expected<GridGrowth> GridGrowth::create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                        Arena& arena) {
  GridGrowth growth(cloud, tree, view_of);
  auto sample = arena.take_top<Vec3f>(kSample, kStage);
  PLUMBLINE_TRY(sample);
  const std::uint32_t step = (cloud.size + kThinnedPoints - 1) / kThinnedPoints;
  auto thinned = arena.take_top<std::uint32_t>((cloud.size + step - 1) / step, kStage);
  PLUMBLINE_TRY(thinned);
  for (std::uint32_t k = 0; k < thinned->size(); ++k) (*thinned)[k] = k * step;
  growth.sample_ = *sample;
  growth.thinned_ = *thinned;
  const Vec3f size = cloud.bounds().size();
  growth.extent_ = 0.5 * std::sqrt(static_cast<double>(size.dot(size)));
  return growth;
}

void GridGrowth::fit(ViewGrid& grid, std::span<const Vec3f> points, double width, int steps) const {
  for (int k = 0; k < steps; ++k) {
    ViewGridFit step(grid, width, extent_);
    for (const Vec3f& p : points) step.add(p);
    if (!step.improve(grid)) return;
  }
}

std::optional<GrownGrid> GridGrowth::grow(ViewGrid grid, double radius) {
  const ViewGrid first = grid;
  GrownGrid grown;
  for (;;) {
    const auto sample = take_sample(grid.middle, radius);
    fit(grid, sample, kCoarse, 3);
    fit(grid, sample, kMedium, 2);
    fit(grid, sample, kFine, 2);
    fit(grid, sample, kFinest, 2);
    if (!score(grid, sample, kFinest).is_significant() || !keeps_scale(grid, first)) break;
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
  const auto sample = take_sample(grid.middle, radius);
  fit(grid, sample, kFinest / 2, 3);
  const Score wide = score(grid, sample, kWidest);
  for (const double width : {0.005, 0.01, 0.02, 0.04, 0.06, kWidest}) {
    const Score s = score(grid, sample, width);
    if (s.near - s.chance < kViewShare * (wide.near - wide.chance)) continue;
    return s.chance < kMaxChance * s.near ? width : 0;
  }
  return 0;
}

std::uint32_t GridGrowth::count(const GrownGrid& grid) const {
  return static_cast<std::uint32_t>(std::count_if(thinned_.begin(), thinned_.end(), [&](std::uint32_t i) {
    return view_of_[i] == kNoView && grid.contains(cloud_->position[i]);
  }));
}

/// Free points around `middle`, kSample at most, spread evenly; from the thinned points if these are enough.
std::span<const Vec3f> GridGrowth::take_sample(const Vec3f& middle, double radius) {
  const auto r = static_cast<float>(radius);
  const auto is_in = [&](std::uint32_t i) {
    if (view_of_[i] != kNoView) return false;
    const Vec3f d = cloud_->position[i] - middle;
    return d.dot(d) <= r * r;
  };
  const auto each_thinned = [&](auto use) {
    for (const std::uint32_t i : thinned_) {
      if (is_in(i)) use(i);
    }
  };
  const auto each = [&](auto use) {
    tree_->visit_box(middle - Vec3f::Constant(r), middle + Vec3f::Constant(r),
                     [&](std::uint32_t first, std::uint32_t last) {
                       for (std::uint32_t i = first; i < last; ++i) {
                         if (is_in(i)) use(i);
                       }
                     });
  };
  const auto pick = [&](std::uint32_t inside, const auto& all) {
    const std::uint32_t stride = std::max(1U, (inside + kSample - 1) / kSample);
    std::uint32_t at = 0;
    std::uint32_t size = 0;
    all([&](std::uint32_t i) {
      if (at++ % stride == 0) sample_[size++] = cloud_->position[i];
    });
    return std::span<const Vec3f>(sample_).first(size);
  };
  std::uint32_t inside = 0;
  const auto add = [&inside](std::uint32_t) { ++inside; };
  each_thinned(add);
  if (inside >= kSample / 2 || thinned_.size() == cloud_->size) return pick(inside, each_thinned);
  inside = 0;
  each(add);
  return pick(inside, each);
}

}  // namespace plumbline
