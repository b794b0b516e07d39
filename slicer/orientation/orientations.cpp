#include "slicer/orientation/orientations.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slicer/placement/placement.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr float kFlat = 0.97F;         ///< cosine of the normal of a foot: 14 degrees, for noisy normals
constexpr float kFootCells = 1.5F;     ///< height of a foot above the lowest patch, in cells
constexpr std::size_t kLayers = 48;    ///< sections whose areas are compared
constexpr double kFlatHole = 0.985;    ///< cosine of 10 degrees: the rim of a hole that lies on the plate
constexpr double kStep = 15;           ///< degrees between directions
constexpr double kApart = 0.8660254;   ///< cosine of 30 degrees: least angle between two proposals
constexpr double kTurned = 0.9396926;  ///< cosine of 20 degrees: least angle between a proposal and the scan as it came
constexpr double kMuchBetter = 0.75;   ///< of the present cost
constexpr double kCleanCounts = 20;    ///< weight of clean_area, ten times that of support_area
constexpr double kFootCounts = 0.02;   ///< least share of the area that is a foot to stand on

/// What lying on its side adds to an object's cost; upside down adds twice that. Figures stand, and their faces look sideways. On a flat foot
/// it adds less: such an object may have several.
constexpr double kTilted = 0.5;
constexpr double kTiltedOnFoot = 0.1;
constexpr double kNearlySquare = 0.978;  ///< cosine of 12 degrees
constexpr double kHardlyMore = 1.05;

using Angles = std::array<double, 2>;
constexpr std::array<Angles, 6> kSquare{{{0, 0}, {90, 0}, {-90, 0}, {180, 0}, {0, 90}, {0, -90}}};

Vec3f up_of(const Angles& degrees) {
  const Mat3d rotation = rotation_matrix({degrees[0], degrees[1], 0});
  return rotation.row(2).transpose().cast<float>();
}

OrientationCost cost_along(const SurfaceSamples& s, const Vec3f& up, CleanSide clean) {
  OrientationCost cost;
  float low = 1e30F;
  float high = -1e30F;
  for (const SurfaceSample& p : s.patches) {
    low = std::min(low, up.dot(p.position));
    high = std::max(high, up.dot(p.position));
  }
  // The area of a section is the sum of the area vectors below it: the part below is closed by it.
  std::array<double, kLayers> facing_down{};
  const float layer = std::max(high - low, 1e-12F) / static_cast<float>(kLayers);
  for (const SurfaceSample& p : s.patches) {
    const float slope = up.dot(p.normal);
    const float height = up.dot(p.position) - low;
    const double area = static_cast<double>(p.area);
    const double seen = area * static_cast<double>(-slope);
    facing_down[std::min(kLayers - 1, static_cast<std::size_t>(height / layer))] += seen;
    if (slope > -kNeedsSupport) continue;
    if (slope < -kFlat && height < kFootCells * s.cell) {
      cost.foot_area += seen;
    } else {
      cost.support_area += seen;
      cost.support_volume += seen * static_cast<double>(height);
      cost.scar_area += seen * static_cast<double>(p.quality);
      cost.clean_area += seen * static_cast<double>(facing(clean, p.normal));
    }
  }
  cost.height = static_cast<double>(high - low);
  const double area = static_cast<double>(s.area);
  // The hole is a flat underside if it lies on the plate, and hangs over it if it is tilted.
  const double hole_down = static_cast<double>(-up.dot(s.hole));
  const double hole = static_cast<double>(s.hole_share()) * area;
  const bool has_hole = s.has_hole();
  if (has_hole && hole_down > kFlatHole * hole) {
    cost.foot_area += hole_down;
  } else if (has_hole && hole_down > static_cast<double>(kNeedsSupport) * hole) {
    cost.support_area += hole_down;
    cost.scar_area += hole_down;
  }
  double section = 0;
  if (has_hole) section = std::max(0.0, hole_down);
  for (const double part : facing_down) {
    section += part;
    cost.peel_area = std::max(cost.peel_area, section);
  }
  cost.total = (2 * cost.support_area + cost.peel_area + cost.scar_area + kCleanCounts * cost.clean_area) / area +
               cost.support_volume / (area * std::sqrt(area)) + 0.15 * cost.height / std::sqrt(area);
  if (has_hole) cost.total += (hole - hole_down) / area;
  return cost;
}

/// Degrees with a tenth at most, so that they can be typed.
Angles rounded(const Angles& degrees) {
  return {std::floor(degrees[0] * 10 + 0.5) / 10, std::floor(degrees[1] * 10 + 0.5) / 10};
}

/// The angles whose up is nearest to `up`.
Angles towards(const Vec3f& up, Angles from) {
  for (double step = 8; step > 0.03; step /= 2) {
    for (bool moved = true; moved;) {
      moved = false;
      for (const Angles& turn : {Angles{step, 0}, Angles{-step, 0}, Angles{0, step}, Angles{0, -step}}) {
        const Angles to = {from[0] + turn[0], from[1] + turn[1]};
        if (up_of(to).dot(up) <= up_of(from).dot(up)) continue;
        from = to;
        moved = true;
      }
    }
  }
  return rounded(from);
}

/// What a way up costs, with its tilt from upright.
struct Ways {
  const SurfaceSamples& samples;
  CleanSide clean;
  Vec3f upright;

  OrientationCost cost(const Angles& degrees) const {
    OrientationCost cost = cost_of(samples, degrees, clean);
    const bool has_foot = cost.foot_area > kFootCounts * static_cast<double>(samples.area);
    cost.total += (has_foot ? kTiltedOnFoot : kTilted) * (1 - static_cast<double>(up_of(degrees).dot(upright)));
    return cost;
  }
};

/// Turns the object so that the face it nearly stands on is flat.
void stand_flat(const Ways& ways, Orientation& o) {
  const SurfaceSamples& s = ways.samples;
  const Vec3f up = up_of(o.degrees);
  float low = 1e30F;
  for (const SurfaceSample& p : s.patches) low = std::min(low, up.dot(p.position));
  Vec3f sum = Vec3f::Zero();
  for (const SurfaceSample& p : s.patches) {
    const bool foot = up.dot(p.normal) < -0.9F && up.dot(p.position) - low < 3 * s.cell;
    if (foot) sum += p.area * p.normal;
  }
  const float area = std::sqrt(sum.dot(sum));
  if (!(static_cast<double>(area) > kFootCounts * static_cast<double>(s.area))) return;
  const Angles flat = towards(-sum / area, o.degrees);
  const OrientationCost cost = ways.cost(flat);
  if (cost.total < kHardlyMore * o.cost.total) o = {flat, cost};
}

/// Turns the object square to the scan's axes if it nearly is and that costs hardly more: the rim of a hole is known to some degrees
/// only, and scanners stand objects square.
void lie_square(const Ways& ways, Orientation& o) {
  const Vec3f up = up_of(o.degrees);
  for (const Angles& square : kSquare) {
    if (!(static_cast<double>(up.dot(up_of(square))) > kNearlySquare)) continue;
    const OrientationCost cost = ways.cost(square);
    if (cost.total < kHardlyMore * o.cost.total) o = {square, cost};
  }
}

void refine(const Ways& ways, Orientation& o) {
  for (const double step : {5.0, 2.0}) {
    for (bool better = true; better;) {
      better = false;
      for (const Angles& turn : {Angles{step, 0}, Angles{-step, 0}, Angles{0, step}, Angles{0, -step}}) {
        const Angles to = {o.degrees[0] + turn[0], o.degrees[1] + turn[1]};
        const OrientationCost cost = ways.cost(to);
        if (!(cost.total < 0.999 * o.cost.total)) continue;
        o = {to, cost};
        better = true;
      }
    }
  }
  stand_flat(ways, o);
  lie_square(ways, o);
}

}  // namespace

OrientationCost cost_of(const SurfaceSamples& samples, const std::array<double, 2>& degrees, CleanSide clean) {
  return cost_along(samples, up_of(degrees), clean);
}

std::optional<WaysUp> best_orientations(const SurfaceSamples& samples, CleanSide clean, const StageProgress& progress) {
  const auto upright = better_upright(samples);
  const Ways ways{samples, clean, up_of(upright ? upright->degrees : Angles{})};
  constexpr std::size_t kMost = 12 * 24 + 2;
  std::array<Orientation, kMost> all{};
  std::size_t count = 0;
  for (int y = -6; y <= 6; ++y) {
    if (!progress.advance((y + 6) / 20.0)) return std::nullopt;
    const bool pole = y == -6 || y == 6;
    for (int x = 0; x < (pole ? 1 : 24); ++x) {
      const Angles degrees = {x <= 12 ? x * kStep : (x - 24) * kStep, y * kStep};
      all[count++] = {degrees, ways.cost(degrees)};
    }
  }
  const auto by_cost = [](const Orientation& a, const Orientation& b) { return a.cost.total < b.cost.total; };
  std::stable_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), by_cost);
  WaysUp best{};
  best[0].cost = ways.cost({0, 0});
  std::size_t found = 1;
  const auto is_apart = [&](const Orientation& o) {
    return std::all_of(best.begin() + 1, best.begin() + static_cast<std::ptrdiff_t>(found),
                       [&](const Orientation& other) {
                         return static_cast<double>(up_of(o.degrees).dot(up_of(other.degrees))) < kApart;
                       });
  };
  const auto is_turned = [&](const Orientation& o) {
    return static_cast<double>(up_of(o.degrees)[2]) < kTurned || o.cost.total < kMuchBetter * best[0].cost.total;
  };
  for (std::size_t i = 0; i < count && found < best.size(); ++i) {
    if (!is_apart(all[i])) continue;
    Orientation o = all[i];
    refine(ways, o);
    if (!is_apart(o) || !is_turned(o)) o = all[i];
    if (!is_turned(o)) continue;
    best[found++] = o;
    if (!progress.advance(0.7 + 0.3 * static_cast<double>(found) / static_cast<double>(best.size())))
      return std::nullopt;
  }
  std::stable_sort(best.begin() + 1, best.begin() + static_cast<std::ptrdiff_t>(found), by_cost);
  return best;
}

std::optional<Orientation> better_upright(const SurfaceSamples& samples) {
  const OrientationCost now = cost_of(samples, {0, 0});
  Orientation best{{0, 0}, now};
  for (const Angles& degrees : kSquare) {
    const OrientationCost cost = cost_of(samples, degrees);
    if (cost.total < best.cost.total) best = {degrees, cost};
  }
  const double area = static_cast<double>(samples.area);
  const bool better_foot = best.cost.foot_area > kFootCounts * area && best.cost.foot_area > 2 * now.foot_area;
  if (!(best.cost.total < kMuchBetter * now.total) || !better_foot) return std::nullopt;
  return best;
}

}  // namespace plumbline::inline slicer
