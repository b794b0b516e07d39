#include "slicer/rays/intersections.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

/// Every weight is zero at the very end of a band, so the sign is taken this share of the reach inside of it.
constexpr float kEndInset = 0.1F;

// Of solve_near().
constexpr float kMostStep = 0.5F;     ///< of the reach: a zero farther away is another sheet's
constexpr float kLeastSlope = 0.08F;  ///< of the MLS value along the ray; on steeper surface steps go astray
constexpr std::uint32_t kMostSteps = 5;

/// The middle of two sheets that two queries on the same side have between them: of a wall or a gap thinner than their distance.
std::optional<float> between_sheets(const RayQuery& low, const RayQuery& high) {
  const float side = low.value.distance > 0 ? 1.0F : -1.0F;
  const bool same_side = side * high.value.distance > 0;
  if (!same_side || !(side * low.value.slope < -kLeastSlope) || !(side * high.value.slope > kLeastSlope)) return {};
  const float first = low.sheet();
  const float second = high.sheet();
  if (!(first < second)) return {};
  return 0.5F * (first + second);
}

}  // namespace

void RaySolver::find_bands(const RayGatherer& gatherer, const RayPoints& points) {
  band_count_ = 0;
  intersection_count_ = 0;
  if (points.size == 0) return;
  float low = points.depth[0] - gatherer.half_chord(0);
  float high = points.depth[0] + gatherer.half_chord(0);
  for (std::uint32_t j = 1; j < points.size; ++j) {
    const float from = points.depth[j] - gatherer.half_chord(j);
    const float to = points.depth[j] + gatherer.half_chord(j);
    if (high < from && band_count_ + 1 < kMaxBands) {
      bands_[band_count_++] = {low, high};
      low = from;
      high = to;
      continue;
    }
    low = std::min(low, from);
    high = std::max(high, to);
    // Depths ascend, but the lower ends need not: a wide support radius may reach down into bands already closed.
    while (band_count_ > 0 && bands_[band_count_ - 1].high >= low) {
      const Band& last = bands_[--band_count_];
      low = std::min(low, last.low);
      high = std::max(high, last.high);
    }
  }
  bands_[band_count_++] = {low, high};
}

void RaySolver::solve_root(const RayPoints& points, RayWindow hint, float low, float low_value, float high,
                           float high_value) {
  if (intersection_count_ == kMaxIntersections) return;
  const RayWindow range = window(points, low, high, hint);
  const float enough = kInterval * width_;
  float root = 0.5F * (low + high);
  // Illinois method: regula falsi that halves the value of an end that stays twice, so that both ends close in.
  int stayed = 0;
  for (std::uint32_t i = 0; i < kMostIterations && high - low > enough; ++i) {
    root = (low * high_value - high * low_value) / (high_value - low_value);
    if (!(root > low && root < high)) root = 0.5F * (low + high);
    const float value = mls_value(points, range, root).distance;
    if ((value > 0) == (low_value > 0)) {
      low = root;
      low_value = value;
      if (stayed == -1) high_value *= 0.5F;
      stayed = -1;
    } else {
      high = root;
      high_value = value;
      if (stayed == 1) low_value *= 0.5F;
      stayed = 1;
    }
    if (value == 0) break;
  }
  if (high - low <= enough && high_value != low_value) {
    root = std::clamp((low * high_value - high * low_value) / (high_value - low_value), low, high);
  }
  intersections_[intersection_count_++] = {root, off_centre(points, range, root)};
}

void RaySolver::solve_between(const RayPoints& points, RayWindow hint, const RayQuery& low, const RayQuery& high) {
  const float at_low = low.value.distance;
  const float at_high = high.value.distance;
  if ((at_low > 0) != (at_high > 0)) solve_root(points, hint, low.depth, at_low, high.depth, at_high);
}

/// @param near       a window below the band; out: one in it
/// @param candidate  first point that is not below the band; out: one that is not below its end
void RaySolver::search(const RayPoints& points, Band& band, RayWindow& near, std::uint32_t& candidate) {
  band.first = intersection_count_;
  const float inset = std::min(kEndInset * points.reach, 0.25F * (band.high - band.low));
  const float start = band.low + inset;
  const float end = band.high - inset;
  // The next candidate above the last query; one within w of it is merged into a query w above it, or farther above if the surface is
  // farther away. On a smooth sheet all candidates lie on the surface, where the sign is rounding, so there is a query between sheets, too.
  const auto next_query = [&](float previous, float value) {
    const float step = std::max(width_, std::abs(value));
    while (candidate < points.size && points.depth[candidate] <= previous) ++candidate;
    if (candidate == points.size || points.depth[candidate] > band.high) return end;
    const float depth = points.depth[candidate];
    if (depth - previous > 2 * step) return std::min(end, 0.5F * (previous + depth));
    return std::min(end, std::max(depth, previous + step));
  };
  near = window(points, start, start, near);
  RayQuery previous{start, mls_value(points, near, start)};
  band.inside_at_low = !(previous.value.distance > 0);
  for (float depth = start; depth < end;) {
    depth = next_query(depth, previous.value.distance);
    const RayWindow before = near;
    near = window(points, depth, depth, near);
    const RayQuery query{depth, mls_value(points, near, depth)};
    // In sparse scans a band may hold a place without weight, which has no sign.
    if (!(query.value.weight > 0)) {
      previous.depth = depth;
      continue;
    }
    if (const auto between = between_sheets(previous, query)) {
      const RayWindow range = window(points, *between, *between, before);
      const RayQuery middle{*between, mls_value(points, range, *between)};
      if (middle.value.weight > 0) {
        solve_between(points, before, previous, middle);
        previous = middle;
      }
    }
    solve_between(points, before, previous, query);
    previous = query;
  }
  band.inside_at_high = !(previous.value.distance > 0);
  band.last = intersection_count_;
}

RaySurface RaySolver::solve(const RayGatherer& gatherer, const RayPoints& points) {
  find_bands(gatherer, points);
  std::uint32_t candidate = 0;
  RayWindow near;
  for (Band& band : std::span(bands_).first(band_count_)) {
    while (candidate < points.size && points.depth[candidate] < band.low) ++candidate;
    search(points, band, near, candidate);
  }
  return {std::span(bands_).first(band_count_), std::span(intersections_).first(intersection_count_)};
}

std::optional<float> RaySolver::solve_near(const RayPoints& points, float depth, bool entering,
                                           float most_off_centre) const {
  const RayWindow all{0, points.size};
  const float side = entering ? -1.0F : 1.0F;
  const float enough = 0.25F * kInterval * width_;
  float z = depth;
  MlsValue value = mls_value(points, all, z);
  float slope = value.slope;
  float limit = kMostStep * points.reach;
  for (std::uint32_t i = 0; i < kMostSteps; ++i) {
    if (!(value.weight > 0) || !(side * slope > kLeastSlope) || value.off_centre2 > most_off_centre * most_off_centre) {
      return std::nullopt;
    }
    const float step = -value.distance / slope;
    // The first slope is an estimate, so the first step must be smaller to be the last.
    if (std::abs(step) <= (i == 0 ? 0.25F : 1.0F) * enough) return z + step;
    if (!(std::abs(step) <= limit)) return std::nullopt;
    limit = 0.5F * std::abs(step);
    const MlsValue next = mls_value(points, all, z + step);
    slope = (next.distance - value.distance) / step;
    z += step;
    value = next;
  }
  return std::nullopt;
}

}  // namespace plumbline::inline slicer
