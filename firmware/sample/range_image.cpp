#include "firmware/sample/range_image.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/sample/analytic_bust.hpp"

namespace plumbline::firmware {
namespace {

constexpr double kDepthNoise = 0.02;  // mm, sigma for a surface seen straight on
constexpr double kSteepest = 0.2079;  // cosine of 78 degrees: steeper surfaces are not measured
constexpr double kFull = 0.6428;      // cosine of 50 degrees: below it the density falls
constexpr double kStandTop = 0.01;    // mm: what is lower is the underside, which the stand covers

}  // namespace

/// @returns the range along `direction`, or 0 if the ray misses the bust
double RangeImage::trace(const Vec3d& direction, double from) const {
  double t = from, before = 0.0, step = 0.0;
  for (int i = 0; i < 300 && t < kFarEnd; ++i) {
    const double d = bust_distance(view_.eye + t * direction);
    if (std::abs(d) < kHit) return t;
    // Near the surface the bound is almost linear: the secant converges in two or three steps, while stepping by the
    // bound only halves the rest. It may overshoot; then d is negative and it steps back.
    const double slope = step != 0.0 ? (before - d) / step : 0.0;
    const bool secant = std::abs(d) < 0.3 && slope > 0.15;
    step = secant ? d / slope : d;
    before = d;
    t += step;
  }
  return 0.0;
}

void RangeImage::trace_band(std::size_t first) {
  const std::size_t end = std::min(first + kTile, rows_);
  for (std::size_t left = 0; left < columns_; left += kTile) {
    // One march for the cone around the tile's rays finds where the nearest of them may hit.
    const double half = 0.5 * (kTile - 1);
    const Vec3d axis = direction(double(left) + half, double(first) + half);
    const double spread = 1.5 * half * pitch_ / kStationDistance;  // > sqrt(2): radius of the cone at range 1
    double t = kNear;
    while (t < kFarEnd) {
      const double free = bust_distance(view_.eye + t * axis) - spread * t;
      if (free < 0.05) break;
      t += free;
    }
    if (t >= kFarEnd) continue;
    for (std::size_t j = first; j < end; ++j) {
      for (std::size_t i = left; i < std::min(left + kTile, columns_); ++i) {
        const double range = trace(direction(i, j), t);
        if (range == 0.0 || (view_.eye + range * direction(i, j)).z() < kStandTop) continue;
        range_[index(i, j)] = range;
        state_[index(i, j)] = PixelState::kSeen;
      }
    }
  }
}

/// Normal of the range image at a pixel, from the neighbours that are connected with it.
bool RangeImage::local_normal(std::size_t i, std::size_t j, Vec3d& normal) const {
  const std::size_t here = index(i, j);
  const auto connected = [&](std::size_t other) { return seen(other) && !jump(here, other); };
  if (i == 0 || j == 0 || i + 1 == columns_ || j + 1 == rows_) return false;
  const std::size_t left = connected(here - 1) ? i - 1 : i, right = connected(here + 1) ? i + 1 : i;
  const std::size_t low = connected(here - columns_) ? j - 1 : j, high = connected(here + columns_) ? j + 1 : j;
  if (left == right || low == high) return false;
  // Rows count upwards, so right x up points back at the camera.
  normal = (point(right, j) - point(left, j)).cross(point(i, high) - point(i, low)).normalized();
  return true;
}

/// True if nothing is between `p` on the surface and the projector.
bool RangeImage::lit(const Vec3d& p, const Vec3d& normal) const {
  const Vec3d towards = (view_.projector - p).normalized();
  if (towards.dot(normal) < kSteepest) return false;
  double t = 0.15;  // clear of the surface itself, whose normal is known from pixels only
  for (int i = 0; i < 200; ++i) {
    const Vec3d q = p + 0.05 * normal + t * towards;
    if ((q - view_.middle).squaredNorm() > kBoundingRadius * kBoundingRadius) return true;
    const double d = bust_distance(q);
    if (d < 0.005) return false;
    t += d;
  }
  return true;
}

std::size_t RangeImage::select(const CounterRng& rng) {
  cosine_.assign(range_.size(), 0.0F);
  std::size_t kept = 0;
  for (std::size_t j = 0; j < rows_; ++j) {
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::size_t pixel = index(i, j);
      Vec3d normal;
      if (!seen(pixel) || !local_normal(i, j, normal)) continue;
      const double cosine = -normal.dot(direction(i, j));
      cosine_[pixel] = static_cast<float>(cosine);
      if (cosine < kSteepest) continue;
      const double density = std::min((cosine - kSteepest) / (kFull - kSteepest), 1.0);
      if (rng.uniform(pixel) >= 0.15 + 0.85 * density || !lit(point(i, j), normal)) continue;
      state_[pixel] = PixelState::kKept;
      ++kept;
    }
  }
  return kept;
}

void RangeImage::add_noise(const CounterRng& rng) {
  for (std::size_t pixel = 0; pixel < range_.size(); ++pixel) {
    if (!seen(pixel)) continue;
    range_[pixel] += kDepthNoise / std::max(double{cosine_[pixel]}, 0.34) * rng.normal(pixel);
  }
}

Vec3d RangeImage::normal(std::size_t i, std::size_t j) const {
  // Four cells of about 0.2 mm at any pitch: smaller ones show the noise, larger ones lose the strands of hair.
  // (At 300 000 points half of the normals are within 3.4 degrees of the truth, 90 % within 12.)
  const std::size_t size = static_cast<std::size_t>(std::max(1L, std::lround(0.2 / pitch_)));
  const std::size_t here = index(i, j);
  Vec3d sum = Vec3d::Zero();
  if (i >= size && j >= size && i + size < columns_ && j + size < rows_) {
    std::array<Vec3d, 9> around;
    std::array<bool, 9> usable;
    for (std::size_t b = 0; b < 3; ++b) {
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t x = i - size + a * size, y = j - size + b * size;
        usable[b * 3 + a] = seen(index(x, y)) && !jump(here, index(x, y));
        if (usable[b * 3 + a]) around[b * 3 + a] = point(x, y);
      }
    }
    for (std::size_t b = 0; b < 2; ++b) {
      for (std::size_t a = 0; a < 2; ++a) {
        const std::size_t k = b * 3 + a;
        if (!usable[k] || !usable[k + 1] || !usable[k + 3] || !usable[k + 4]) continue;
        sum += (around[k + 4] - around[k]).cross(around[k + 3] - around[k + 1]);
      }
    }
  }
  const Vec3d away = direction(i, j);
  if (sum.squaredNorm() == 0.0) return -away;  // an isolated pixel: use the direction to the camera that saw it
  const Vec3d unit = sum.normalized();
  return unit.dot(away) > 0.0 ? Vec3d{-unit} : unit;
}

}  // namespace plumbline::firmware
