#include "slicer/rays/ray_points.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr const char* kStage = "ray search";

/// Ascends with the depth, then with the index of the point, which is its lower half.
std::uint64_t depth_key(float depth, std::uint32_t index) {
  constexpr std::uint32_t kSign = 1U << 31U;
  const auto bits = std::bit_cast<std::uint32_t>(depth + 0.0F);  // which turns -0 into 0
  return std::uint64_t{(bits & kSign) != 0 ? ~bits : bits | kSign} << 32U | index;
}

}  // namespace

std::size_t RayGatherer::bytes_needed(std::uint32_t capacity) {
  return Arena::rounded(capacity * sizeof(TilePoint)) + Arena::rounded(capacity * sizeof(std::uint64_t)) +
         Arena::rounded(capacity * sizeof(float)) + RayPoints::bytes_needed(capacity);
}

Expected<RayGatherer> RayGatherer::create(const Cloud& cloud, const KdTree2& tree, std::uint32_t capacity,
                                          float max_radius, Arena& arena) {
  RayGatherer gatherer;
  gatherer.cloud_ = &cloud;
  gatherer.tree_ = &tree;
  gatherer.max_radius_ = max_radius;
  auto tile = arena.take_top<TilePoint>(capacity, kStage);
  if (!tile) return tl::unexpected<Error>(tile.error());
  gatherer.tile_ = *tile;
  auto chosen = arena.take_top<std::uint64_t>(capacity, kStage);
  if (!chosen) return tl::unexpected<Error>(chosen.error());
  gatherer.chosen_ = *chosen;
  auto half_chord = arena.take_top<float>(capacity, kStage);
  if (!half_chord) return tl::unexpected<Error>(half_chord.error());
  gatherer.half_chord_ = *half_chord;
  auto columns = RayPoints::create(capacity, arena, kStage);
  if (!columns) return tl::unexpected<Error>(columns.error());
  gatherer.columns_ = *columns;
  return gatherer;
}

void RayGatherer::gather(const Vec2f& low, const Vec2f& high) {
  const Vec3f from(low[0] - max_radius_, low[1] - max_radius_, 0);
  const Vec3f to(high[0] + max_radius_, high[1] + max_radius_, 0);
  const auto order = tree_->order();
  const auto seen = [&](std::uint32_t i) {
    const Vec3f& p = cloud_->position[i];
    const float radius = std::min(cloud_->radius[i], max_radius_);
    const float dx = std::max({low[0] - p[0], 0.0F, p[0] - high[0]});
    const float dy = std::max({low[1] - p[1], 0.0F, p[1] - high[1]});
    return dx * dx + dy * dy < radius * radius;
  };
  const auto keep = [&](std::uint32_t i) { chosen_[count_++] = depth_key(cloud_->position[i][2], i); };

  count_ = 0;
  thinned_ = false;
  std::uint32_t met = 0;
  tree_->visit_box(from, to, [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t at = first; at < last; ++at) {
      if (!seen(order[at])) continue;
      if (met++ < tile_.size()) keep(order[at]);
    }
  });
  if (met > tile_.size()) {
    // Too many points: use every n-th in the order of the tree, so that the choice depends on the cloud alone.
    thinned_ = true;
    count_ = 0;
    const auto stride = static_cast<std::uint32_t>((met + tile_.size() - 1) / tile_.size());
    std::uint32_t nth = 0;
    tree_->visit_box(from, to, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t at = first; at < last; ++at) {
        if (seen(order[at]) && nth++ % stride == 0) keep(order[at]);
      }
    });
  }
  std::sort(chosen_.begin(), chosen_.begin() + count_);
  tile_reach_ = 0;
  for (std::uint32_t t = 0; t < count_; ++t) {
    const auto i = static_cast<std::uint32_t>(chosen_[t]);
    const PackedNormal& n = cloud_->normal[i];
    const float radius = std::min(cloud_->radius[i], max_radius_);
    tile_[t] = {cloud_->position[i], radius, 1.0F / (radius * radius), n.unpack(), i, n.weight};
    tile_reach_ = std::max(tile_reach_, radius);
  }
}

const RayPoints& RayGatherer::points_of_ray(float x, float y) {
  choose(x, y, 0, count_);
  add_chosen<true>(x, y);
  return columns_;
}

const RayPoints& RayGatherer::points_near(float x, float y, float depth) {
  const auto points = tile_.first(count_);
  const auto below = [](const TilePoint& p, float z) { return p.position[2] < z; };
  const auto first = std::lower_bound(points.begin(), points.end(), depth - tile_reach_, below);
  const auto last = std::lower_bound(first, points.end(), depth + tile_reach_, below);
  choose(x, y, static_cast<std::uint32_t>(first - points.begin()), static_cast<std::uint32_t>(last - points.begin()));
  add_chosen<false>(x, y);
  return columns_;
}

/// Chooses the tile points [first, last) whose supports meet the ray.
void RayGatherer::choose(float x, float y, std::uint32_t first, std::uint32_t last) {
  // Without branches, which could not be predicted.
  std::uint32_t chosen = 0;
  for (std::uint32_t t = first; t < last; ++t) {
    const TilePoint& p = tile_[t];
    const float dx = x - p.position[0];
    const float dy = y - p.position[1];
    chosen_[chosen] = t;
    chosen += dx * dx + dy * dy < p.radius * p.radius ? 1 : 0;
  }
  chosen_count_ = chosen;
}

/// @tparam Chords  also sets half_chord_
template <bool Chords>
void RayGatherer::add_chosen(float x, float y) {
  RayPoints& c = columns_;
  c.size = 0;
  c.reach = 0;
  continued_low_ = std::numeric_limits<float>::max();
  continued_high_ = std::numeric_limits<float>::lowest();
  for (const std::uint64_t t : chosen_.first(chosen_count_)) {
    const TilePoint& p = tile_[static_cast<std::size_t>(t)];
    const float dx = x - p.position[0];
    const float dy = y - p.position[1];
    if constexpr (Chords) half_chord_[c.size] = std::sqrt(p.radius * p.radius - (dx * dx + dy * dy));
    c.reach = std::max(c.reach, p.radius);
    c.add(dx, dy, p.position[2], p.normal, p.inverse_radius2, p.points);
    if (p.index < cloud_->seen()) continue;
    continued_low_ = std::min(continued_low_, p.position[2] - p.radius);
    continued_high_ = std::max(continued_high_, p.position[2] + p.radius);
  }
  c.close();
}

}  // namespace plumbline
