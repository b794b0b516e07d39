#include "slicer/views/grid_growth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

constexpr std::uint32_t kSample = 8192;  ///< points that a grid is fitted to
constexpr std::uint32_t kThin = 65536;   ///< points that samples of large parts of the scan are taken of
constexpr double kGrowth = 1.4;
constexpr double kFinest = 0.06;  ///< pixels: what lies as close to the grid tells whether it is one
constexpr double kClear = 8;      ///< standard deviations over chance
constexpr double kSmaller = 0.7;  ///< what a pixel may become while its grid grows
constexpr double kLarger = 1.4;
constexpr double kMostOfThem = 0.9;  ///< of a view's points lie within its tolerance
constexpr double kMostChance = 0.3;  ///< of the points within it may be so by chance
constexpr double kPi = std::numbers::pi;

/// Points within a distance of the grid, and how many would be by chance.
struct Score {
  double near, chance;
  bool clear() const { return near - chance > kClear * std::sqrt(chance + 1); }
};

Score score(const ViewGrid& grid, std::span<const Vec3f> points, double width) {
  Score s{0, kPi * width * width * static_cast<double>(points.size())};
  for (const Vec3f& p : points) s.near += grid.off_grid(p) < width ? 1 : 0;
  return s;
}

/// Whether the pixels about the middle are still about as large as they were.
bool like(const ViewGrid& grid, const ViewGrid& first) {
  const double u = grid.map.segment<3>(0).norm() / first.map.segment<3>(0).norm();
  const double v = grid.map.segment<3>(4).norm() / first.map.segment<3>(4).norm();
  return std::min(u, v) > kSmaller && std::max(u, v) < kLarger;
}

}  // namespace

double GrownGrid::off(const Vec3f& point) const {
  const double off = grid.off_grid(point);
  if (off > tolerance || (point - grid.middle).cast<double>().squaredNorm() > radius * radius) return 2;
  return off / tolerance;
}

std::size_t GridGrowth::bytes() { return kSample * sizeof(Vec3f) + kThin * sizeof(std::uint32_t); }

Expected<GridGrowth> GridGrowth::create(const Cloud& cloud, const KdTree3& tree, std::span<const std::uint8_t> view_of,
                                        Arena& arena) {
  GridGrowth growth(cloud, tree, view_of);
  auto sample = arena.take_top<Vec3f>(kSample, kStage);
  PLUMBLINE_TRY(sample);
  const std::uint32_t step = (cloud.size + kThin - 1) / kThin;
  auto thin = arena.take_top<std::uint32_t>((cloud.size + step - 1) / step, kStage);
  PLUMBLINE_TRY(thin);
  for (std::uint32_t k = 0; k < thin->size(); ++k) (*thin)[k] = k * step;
  growth.sample_ = *sample;
  growth.thin_ = *thin;
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
    fit(grid, sample, 0.3, 3);
    fit(grid, sample, 0.2, 2);
    fit(grid, sample, 0.12, 2);
    fit(grid, sample, kFinest, 2);
    if (!score(grid, sample, kFinest).clear() || !like(grid, first)) break;
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

/// Fits the grid once more, too. 0 where points that are near by chance could not be told from the others.
double GridGrowth::tolerance_of(ViewGrid& grid, double radius) {
  constexpr double kWidest = 0.1;
  const auto sample = take_sample(grid.middle, radius);
  fit(grid, sample, kFinest / 2, 3);
  const Score wide = score(grid, sample, kWidest);
  for (const double width : {0.005, 0.01, 0.02, 0.04, 0.06, kWidest}) {
    const Score s = score(grid, sample, width);
    if (s.near - s.chance < kMostOfThem * (wide.near - wide.chance)) continue;
    return s.chance < kMostChance * s.near ? width : 0;
  }
  return 0;
}

std::uint32_t GridGrowth::count(const GrownGrid& grid) const {
  return static_cast<std::uint32_t>(std::count_if(thin_.begin(), thin_.end(), [&](std::uint32_t i) {
    return view_of_[i] == kNoView && grid.off(cloud_->position[i]) <= 1;
  }));
}

/// Free points round `middle`, kSample at most, spread evenly; of the thin ones if these are enough.
std::span<const Vec3f> GridGrowth::take_sample(const Vec3f& middle, double radius) {
  const auto reach = static_cast<float>(radius);
  const auto is_in = [&](std::uint32_t i) {
    if (view_of_[i] != kNoView) return false;
    const Vec3f d = cloud_->position[i] - middle;
    return d.dot(d) <= reach * reach;
  };
  const auto each_thin = [&](auto use) {
    for (const std::uint32_t i : thin_) {
      if (is_in(i)) use(i);
    }
  };
  const auto each = [&](auto use) {
    tree_->visit_box(middle - Vec3f::Constant(reach), middle + Vec3f::Constant(reach),
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
  each_thin(add);
  if (inside >= kSample / 2 || thin_.size() == cloud_->size) return pick(inside, each_thin);
  inside = 0;
  each(add);
  return pick(inside, each);
}

}  // namespace plumbline
