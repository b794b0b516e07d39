#include "slicer/ray_points.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr const char* kStage = "ray search";
constexpr std::size_t kColumns = 10;  ///< the nine of RayPoints and the half chord

std::size_t padded(std::uint32_t capacity) {
  // Room for the padding, in whole cache lines.
  return (std::size_t{capacity} + RayPoints::kLanes + 15) / 16 * 16;
}

}  // namespace

std::size_t RayGatherer::bytes_needed(std::uint32_t capacity) {
  return Arena::rounded(capacity * sizeof(TilePoint)) + Arena::rounded(padded(capacity)) +
         Arena::rounded(kColumns * padded(capacity) * sizeof(float));
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
  const std::size_t length = padded(capacity);
  auto practical = arena.take_top<std::uint8_t>(length, kStage);
  if (!practical) return tl::unexpected<Error>(practical.error());
  gatherer.practical_ = *practical;
  auto columns = arena.take_top<float>(kColumns * length, kStage);
  if (!columns) return tl::unexpected<Error>(columns.error());
  float* next = columns->data();
  for (float** column : {&gatherer.columns_.depth, &gatherer.columns_.distance2, &gatherer.columns_.plane,
                         &gatherer.columns_.slope, &gatherer.columns_.inverse_radius2, &gatherer.columns_.normal_x,
                         &gatherer.columns_.normal_y, &gatherer.columns_.offset_x, &gatherer.columns_.offset_y}) {
    *column = next;
    next += length;
  }
  gatherer.half_chord_ = std::span(next, length);
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
  const auto keep = [&](std::uint32_t i) {
    const PackedNormal& n = cloud_->normal[i];
    tile_[count_++] = {cloud_->position[i], std::min(cloud_->radius[i], max_radius_), n.unpack(), i,
                       n.point_class != PointClass::kNeutral};
  };

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
    // More than a surface can hold: every n-th point by index, so that the choice depends on nothing but the cloud.
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
  std::sort(tile_.begin(), tile_.begin() + count_, [](const TilePoint& a, const TilePoint& b) {
    return a.position[2] < b.position[2] || (a.position[2] == b.position[2] && a.index < b.index);
  });
}

const RayPoints& RayGatherer::points_of_ray(float x, float y) {
  RayPoints& c = columns_;
  std::uint32_t size = 0;
  float reach = 0;
  for (std::uint32_t t = 0; t < count_; ++t) {
    const TilePoint& p = tile_[t];
    const float dx = x - p.position[0];
    const float dy = y - p.position[1];
    const float distance2 = dx * dx + dy * dy;
    const float radius2 = p.radius * p.radius;
    if (distance2 >= radius2) continue;
    c.depth[size] = p.position[2];
    c.distance2[size] = distance2;
    c.plane[size] = p.normal[0] * dx + p.normal[1] * dy - p.normal[2] * p.position[2];
    c.slope[size] = p.normal[2];
    c.inverse_radius2[size] = 1.0F / radius2;
    c.normal_x[size] = p.normal[0];
    c.normal_y[size] = p.normal[1];
    c.offset_x[size] = dx;
    c.offset_y[size] = dy;
    half_chord_[size] = std::sqrt(radius2 - distance2);
    practical_[size] = p.practical ? 1 : 0;
    reach = std::max(reach, p.radius);
    ++size;
  }
  for (std::uint32_t j = size; j < size + RayPoints::kLanes; ++j) {
    c.depth[j] = c.plane[j] = c.slope[j] = 0;
    c.normal_x[j] = c.normal_y[j] = c.offset_x[j] = c.offset_y[j] = 0;
    c.distance2[j] = 1;
    c.inverse_radius2[j] = 2;
  }
  c.size = size;
  c.reach = reach;
  return c;
}

}  // namespace plumbline
