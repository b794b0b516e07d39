#include "slicer/rays/ray_points.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "ray search";

constexpr float kFarAway = 1e15F;  ///< mm: of what fills up the last lanes

struct Places {
  const float* x;
  const float* y;
};

/// Sets what depends on the ray for all points.
/// @param least  out: of the inverse squares of their support radii, of those that have weight on the ray; else FLT_MAX
PLUMBLINE_WIDE void look(const RayPoints& points, const Places& places, float ray_x, float ray_y, float& least) {
  Lanes inverse2 = Lanes{} + std::numeric_limits<float>::max();
  const Lanes none = inverse2;
  for (std::uint32_t j = 0; j < points.size; j += kLanes) {
    Lanes x, y, depth, nx, ny, nz, inverse;
    load(x, places.x + j);
    load(y, places.y + j);
    load(depth, points.depth + j);
    load(nx, points.normal_x + j);
    load(ny, points.normal_y + j);
    load(nz, points.slope + j);
    load(inverse, points.inverse_radius2 + j);
    x = ray_x - x;
    y = ray_y - y;
    const Lanes distance2 = x * x + y * y;
    store(points.offset_x + j, x);
    store(points.offset_y + j, y);
    store(points.distance2 + j, distance2);
    store(points.plane + j, nx * x + ny * y - nz * depth);
    Lanes met;
    choose(met, distance2 * inverse < 1.0F, inverse, none);
    choose(inverse2, met < inverse2, met, inverse2);
  }
  least = smallest(inverse2);
}

/// @returns the largest support radius of the points that have weight on the ray, mm
float look_from(const RayPoints& points, const Places& places, float ray_x, float ray_y) {
  float least = 0;
  look(points, places, ray_x, ray_y, least);
  return 1.0F / std::sqrt(least);
}

/// Ascends with the depth, then with the index of the point, which is its lower half.
std::uint64_t depth_key(float depth, std::uint32_t index) {
  constexpr std::uint32_t kSign = 1U << 31U;
  const auto bits = std::bit_cast<std::uint32_t>(depth + 0.0F);  // which turns -0 into 0
  return std::uint64_t{(bits & kSign) != 0 ? ~bits : bits | kSign} << 32U | index;
}

}  // namespace

std::size_t RayGatherer::bytes_needed(std::uint32_t capacity) {
  return 2 * RayPoints::bytes_needed(capacity) + 3 * Arena::rounded((capacity + kLanes) * sizeof(float)) +
         Arena::rounded(capacity * sizeof(std::uint64_t)) + Arena::rounded(capacity * sizeof(float));
}

Expected<RayGatherer> RayGatherer::create(const Cloud& cloud, const KdTree2& tree, std::uint32_t capacity,
                                          const SupportWidths& widths, Arena& arena) {
  RayGatherer gatherer;
  gatherer.cloud_ = &cloud;
  gatherer.tree_ = &tree;
  gatherer.widths_ = widths;
  for (RayPoints* const points : {&gatherer.tile_, &gatherer.columns_}) {
    auto columns = RayPoints::create(capacity, arena, kStage);
    PLUMBLINE_TRY(columns);
    *points = *columns;
  }
  for (std::span<float>* const column : {&gatherer.x_, &gatherer.y_, &gatherer.radius_}) {
    PLUMBLINE_TRY(arena.take_top(*column, capacity + kLanes, kStage));
  }
  PLUMBLINE_TRY(arena.take_top(gatherer.chosen_, capacity, kStage));
  PLUMBLINE_TRY(arena.take_top(gatherer.half_chord_, capacity, kStage));
  return gatherer;
}

void RayGatherer::gather(const Vec2f& low, const Vec2f& high) {
  const Vec3f from(low[0] - widths_.usual, low[1] - widths_.usual, 0);
  const Vec3f to(high[0] + widths_.usual, high[1] + widths_.usual, 0);
  const auto order = tree_->order();
  const auto left_of = [&](std::uint32_t i, float x) { return cloud_->position[i][0] < x; };
  const auto& wide = widths_.wide;
  const auto first_wide = std::lower_bound(wide.begin(), wide.end(), low[0] - widths_.widest, left_of);
  const auto last_wide = std::lower_bound(first_wide, wide.end(), high[0] + widths_.widest, left_of);
  const auto seen = [&](std::uint32_t i) {
    const Vec3f& p = cloud_->position[i];
    const float radius = widths_.of(cloud_->radius[i]);
    const float dx = std::max({low[0] - p[0], 0.0F, p[0] - high[0]});
    const float dy = std::max({low[1] - p[1], 0.0F, p[1] - high[1]});
    return dx * dx + dy * dy < radius * radius;
  };
  const auto capacity = static_cast<std::uint32_t>(chosen_.size());
  // Keeps every n-th point, as many as there is room for, and returns how many there are.
  const auto keep = [&](std::uint32_t n) {
    count_ = 0;
    std::uint32_t met = 0;
    std::uint32_t next = 0;
    const auto meet = [&](std::uint32_t i) {
      if (!seen(i) || met++ != next || count_ == capacity) return;
      next += n;
      chosen_[count_++] = depth_key(cloud_->position[i][2], i);
    };
    tree_->visit_box(from, to, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t at = first; at < last; ++at) {
        if (!widths_.is_wide(cloud_->radius[order[at]])) meet(order[at]);
      }
    });
    std::for_each(first_wide, last_wide, meet);
    return met;
  };
  const std::uint32_t met = keep(1);
  thinned_ = met > capacity;
  // In the order of the tree, so that the choice depends on the cloud alone.
  if (thinned_) keep((met + capacity - 1) / capacity);
  std::sort(chosen_.begin(), chosen_.begin() + count_);
  tile_reach_ = 0;
  tile_.size = 0;
  for (std::uint32_t t = 0; t < count_; ++t) {
    const auto i = static_cast<std::uint32_t>(chosen_[t]);
    const Vec3f& p = cloud_->position[i];
    const PackedNormal& n = cloud_->normal[i];
    const float radius = widths_.of(cloud_->radius[i]);
    x_[t] = p[0];
    y_[t] = p[1];
    radius_[t] = radius;
    tile_.add(0, 0, p[2], n.unpack(), 1.0F / (radius * radius), n.weight);
    tile_reach_ = std::max(tile_reach_, radius);
  }
  tile_.close();
  for (std::uint32_t t = count_; t < count_ + kLanes; ++t) x_[t] = y_[t] = kFarAway;
}

const RayPoints& RayGatherer::points_of_ray(float x, float y) {
  look_from(tile_, {x_.data(), y_.data()}, x, y);
  // Without branches, which could not be predicted.
  std::uint32_t count = 0;
  for (std::uint32_t t = 0; t < count_; ++t) {
    chosen_[count] = t;
    count += tile_.distance2[t] < radius_[t] * radius_[t] ? 1 : 0;
  }
  RayPoints& c = columns_;
  c.size = count;
  c.reach = 0;
  for (std::uint32_t j = 0; j < count; ++j) {
    const auto t = static_cast<std::uint32_t>(chosen_[j]);
    const float radius = radius_[t];
    half_chord_[j] = std::sqrt(radius * radius - tile_.distance2[t]);
    c.reach = std::max(c.reach, radius);
    c.copy(j, tile_, t);
  }
  c.close();
  return c;
}

RayPoints RayGatherer::points_near(float x, float y, float depth) {
  const float* const depths = tile_.depth;
  const float* const first = std::lower_bound(depths, depths + count_, depth - tile_reach_);
  const float* const last = std::lower_bound(first, depths + count_, depth + tile_reach_);
  const std::ptrdiff_t below = first - depths;
  RayPoints near = tile_.part(below, static_cast<std::uint32_t>(last - first));
  near.reach = look_from(near, {x_.data() + below, y_.data() + below}, x, y);
  return near;
}

}  // namespace plumbline::inline slicer
