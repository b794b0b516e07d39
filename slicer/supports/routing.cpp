#include "slicer/supports/routing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/core/numbers/degrees.hpp"

namespace plumbline::inline slicer {
namespace {

/// A pillar carries this many heads besides its own.
constexpr std::uint32_t kMostBridges = 8;
/// mm; farther pillars are joined only if nothing leads straight down.
constexpr double kShortBridge = 8;
/// mm between pillars, so that a cutter gets in and no resin is caught.
constexpr double kPillarGap = 1;
/// The normal is that of the surface within so many voxels, 1 mm.
constexpr std::int32_t kNormalVoxels = 4;
constexpr double kA = 0.92387953251128674;
constexpr double kB = 0.38268343236508977;
constexpr double kC = 0.70710678118654752;
/// Largest horizontal part of a head's direction: 45 degrees.
constexpr double kMostTilt = kC;
/// Unit vectors at multiples of 22.5 degrees.
constexpr std::array<std::array<double, 2>, 16> kRound = {{{1, 0},
                                                           {kA, kB},
                                                           {kC, kC},
                                                           {kB, kA},
                                                           {0, 1},
                                                           {-kB, kA},
                                                           {-kC, kC},
                                                           {-kA, kB},
                                                           {-1, 0},
                                                           {-kA, -kB},
                                                           {-kC, -kC},
                                                           {-kB, -kA},
                                                           {0, -1},
                                                           {kB, -kA},
                                                           {kC, -kC},
                                                           {kA, -kB}}};
/// By which the room round a way must grow for each millimetre from a tip, which is at the object.
constexpr double kOpening = 0.5;
/// mm; of a joint above plate or raft.
constexpr double kLowestJoint = 0.5;
/// mm; a head so near to its tip may touch the object.
constexpr double kAtTip = 0.75;
/// mm; of a pin that leans on a wall: a longer one bends.
constexpr double kLongestLean = 6;
/// Lengths of heads, as shares of head_width.
constexpr std::array<double, 3> kLengths = {1, 0.5, 0.25};

// Light up to a quarter of the most load, for an island up to kLightLoad; heavy above three quarters: diameters of tip and pillar.
struct LoadClass {
  double tip, pillar;
  std::uint32_t RouteCounts::*count;
};
constexpr LoadClass kLight = {kLightTip, 0.75, &RouteCounts::light};
constexpr LoadClass kMedium = {1, 1, &RouteCounts::medium};
constexpr LoadClass kHeavy = {kHeavyTip, 1.2, &RouteCounts::heavy};

}  // namespace

Routing::Routing(const SupportSettings& settings, double raft_mm, const Obstacles& obstacles, StrutList& list)
    : settings_(settings),
      raft_(raft_mm),
      low_(raft_mm + kLowestJoint),
      px_(static_cast<double>(list.grid().pitch_x_mm)),
      py_(static_cast<double>(list.grid().pitch_y_mm)),
      lh_(static_cast<double>(list.grid().layer_height_mm)),
      obstacles_(obstacles),
      list_(list) {
  const SineCosine angle = sine_cosine(settings.critical_angle);
  slope_ = angle.sine / angle.cosine;
}

Expected<bool> Routing::route(const Tip& tip) {
  const double carries = tip.load * px_ * py_;
  const double most = settings_.area_per_tip;
  const double light = tip.island ? std::min(kLightLoad, 0.25 * most) : 0.25 * most;
  const LoadClass& load = carries < light ? kLight : carries > 0.75 * most ? kHeavy : kMedium;
  Head head;
  head.tip = {tip.column * px_, tip.row * py_, tip.layer * lh_};
  head.radius = settings_.pillar_diameter / 2 * load.pillar;
  head.tip_radius = std::min(head.radius, settings_.head_front_diameter / 2 * load.tip);
  const auto done = find_way(tip, head);
  PLUMBLINE_TRY(done);
  if (!*done) {
    (tip.island ? counts_.unreached_islands : counts_.unreached_overhangs).add(tip);
    return false;
  }
  ++(counts_.*load.count);
  PLUMBLINE_TRY(list_.add(StrutKind::kTip, head.tip, head.tip, tip.layer, tip.end, head.tip_radius, head.tip_radius));
  PLUMBLINE_TRY(list_.add(StrutKind::kHead, head.joint, head.tip,
                          std::min(std::uint32_t{tip.layer}, list_.layer_at(head.joint.z)), tip.layer, head.radius,
                          head.tip_radius));
  return true;
}

Expected<bool> Routing::find_way(const Tip& tip, Head& head) {
  const Vec3d normal = obstacles_.normal(tip.column, tip.row, tip.layer, kNormalVoxels);
  // Along the normal, half as far aside, straight down; then aside, all round.
  constexpr std::size_t kFirst = 3;
  std::array<Vec3d, kFirst + kRound.size() / 2> directions{tilted(normal, 1), tilted(normal, 0.5), Vec3d(0, 0, -1)};
  for (std::size_t i = kFirst; i < directions.size(); ++i) {
    const auto& aside = kRound[2 * (i - kFirst)];
    directions[i] = {kMostTilt * aside[0], kMostTilt * aside[1], -kC};
  }
  const double pillar = settings_.pillar_diameter / 2;
  for (const Room& room :
       {Room{settings_.base_diameter / 2, kPillarGap}, Room{pillar, kPillarGap}, Room{pillar, -kFar}}) {
    for (std::size_t i = 0; i < directions.size(); ++i) {
      if (!find_joint(directions[i], low_, head)) continue;
      const auto done = lead_away(head, room, i < kFirst);
      if (!done || *done) return done;
    }
  }
  for (const Vec3d& direction : directions) {
    if (settings_.buildplate_only) break;
    if (!find_joint(direction, 0, head)) continue;
    const auto done = stand_on_object(head);
    if (!done || *done) return done;
  }
  const Head before = head;
  const auto stands = stand_below(tip, head);
  if (!stands || *stands || settings_.buildplate_only) return stands;
  head = before;
  return lean_on_object(head);
}

/// @returns a unit vector that points down, by 45 degrees aside at most
Vec3d Routing::tilted(const Vec3d& normal, double share) {
  double nx = normal[0] * share;
  double ny = normal[1] * share;
  const double aside = std::sqrt(nx * nx + ny * ny);
  if (aside > kMostTilt || normal[2] > 0) {
    nx *= aside > 0 ? kMostTilt * share / aside : 0;
    ny *= aside > 0 ? kMostTilt * share / aside : 0;
  }
  return {nx, ny, -std::sqrt(std::max(0.0, 1 - nx * nx - ny * ny))};
}

/// Finds where the longest head ends that leads this way and stays above `low`.
bool Routing::find_joint(const Vec3d& direction, double low, Head& head) const {
  for (const double share : kLengths) {
    const double length = share * settings_.head_width;
    head.joint = {head.tip.x + direction[0] * length, head.tip.y + direction[1] * length,
                  head.tip.z + direction[2] * length};
    head.length = length;
    if (head.joint.z < low || !is_on_panel(head.joint.x, head.joint.y, head.radius)) continue;
    if (is_way_clear(head.tip, head.joint, head.tip_radius, head.radius, {0, kFar})) return true;
  }
  return false;
}

/// Whether a cone fits, with room that grows from the object at its ends to base_safety_distance.
bool Routing::is_way_clear(const Place& from, const Place& to, double radius_from, double radius_to,
                           const Ends& ends) const {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const double dz = to.z - from.z;
  const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
  const auto steps = static_cast<std::uint32_t>(std::ceil(length / Obstacles::kVoxel_mm)) + 1;
  for (std::uint32_t i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const double way = std::min(ends.from + t * length, ends.to + (1 - t) * length);
    if (way < Obstacles::kVoxel_mm) continue;
    // At a tip the object may be beside a head, not in it.
    const bool is_at_tip = way < kAtTip;
    const double radius = is_at_tip ? 0 : radius_from + t * (radius_to - radius_from);
    const double room = is_at_tip ? 0 : std::min(settings_.base_safety_distance, kOpening * way);
    const double above = std::max(0.0, room - Obstacles::kVoxel_mm);
    const auto column = static_cast<std::int64_t>(std::floor((from.x + t * dx) / px_ + 0.5));
    const auto row = static_cast<std::int64_t>(std::floor((from.y + t * dy) / py_ + 0.5));
    const auto is_clear = [&](double z, double r) {
      return obstacles_.is_clear(column, row, static_cast<std::int64_t>(std::floor(z / lh_)), nanometres(r));
    };
    const double z = from.z + t * dz;
    if (!is_clear(z, radius + room) || !is_clear(z + above, radius) || !is_clear(z - above, radius)) return false;
  }
  return true;
}

/// Whether a pillar from the plate to `top` has its room, from the object and from other pillars.
bool Routing::stands_free(const Place& top, double radius, const Room& room) const {
  if (!is_on_panel(top.x, top.y, raft_ > 0 ? settings_.base_diameter / 2 + settings_.pad_brim_size : room.base))
    return false;
  for (const Pillar& other : list_.pillars()) {
    const double dx = other.x - top.x;
    const double dy = other.y - top.y;
    const double apart = radius + other.radius + room.gap;
    if (apart > 0 && dx * dx + dy * dy < apart * apart) return false;
  }
  const auto column = static_cast<std::int64_t>(std::floor(top.x / px_ + 0.5));
  const auto row = static_cast<std::int64_t>(std::floor(top.y / py_ + 0.5));
  return obstacles_.is_clear(column, row, static_cast<std::int64_t>(std::floor(raft_ / lh_)),
                             nanometres(room.base + settings_.base_safety_distance)) &&
         obstacles_.is_column_clear(column, row, static_cast<std::int64_t>(std::floor(top.z / lh_)));
}

bool Routing::is_on_panel(double x, double y, double radius) const {
  const PrintGrid& grid = list_.grid();
  return x >= radius && y >= radius && x <= (grid.columns - 1) * px_ - radius && y <= (grid.rows - 1) * py_ - radius;
}

Expected<bool> Routing::lead_away(const Head& head, const Room& room, bool aside) {
  auto done = join_pillar(head, kShortBridge);
  if (done && !*done) done = lead_to_plate(head, room);
  if (done && !*done) done = join_pillar(head, settings_.max_bridge_length);
  if (done && !*done && aside) done = lead_aside(head, room);
  return done;
}

Expected<bool> Routing::lead_to_plate(const Head& head, const Room& room) {
  const Place& joint = head.joint;
  const double open = std::max(raft_, joint.z - std::max(0.0, settings_.base_safety_distance / kOpening - head.length));
  if (!stands_free({joint.x, joint.y, open}, head.radius, room) ||
      !is_way_clear(joint, {joint.x, joint.y, open}, head.radius, head.radius, {head.length, kFar})) {
    return false;
  }
  PLUMBLINE_TRY(stand_on_plate(joint, head.radius));
  ++counts_.on_plate;
  return true;
}

Expected<bool> Routing::join_pillar(const Head& head, double farthest) {
  Pillar* best = nullptr;
  double least = 0;
  Place end;
  const double steep = std::sqrt(1 + slope_ * slope_);
  for (Pillar& pillar : list_.pillars()) {
    const double dx = pillar.x - head.joint.x;
    const double dy = pillar.y - head.joint.y;
    const double away = std::sqrt(dx * dx + dy * dy);
    if (away * steep > farthest || pillar.bridges >= kMostBridges || (best != nullptr && away >= least)) continue;
    const Place at{pillar.x, pillar.y, head.joint.z - away * slope_};
    const double foot = pillar.bottom + (pillar.on_plate ? raft_ : 0) + kLowestJoint;
    if (at.z < foot || at.z > pillar.top) continue;
    // Its own pillar would take less.
    if (farthest <= kShortBridge && away * steep > head.joint.z - low_) continue;
    if (!is_way_clear(head.joint, at, head.radius, head.radius, {head.length, kFar})) continue;
    best = &pillar;
    least = away;
    end = at;
  }
  if (best == nullptr) return false;
  ++best->bridges;
  PLUMBLINE_TRY(add_bridge(head, end));
  ++counts_.on_supports;
  return true;
}

Expected<bool> Routing::lead_aside(const Head& head, const Room& room) {
  const double most =
      std::min(settings_.max_bridge_length / std::sqrt(1 + slope_ * slope_), (head.joint.z - low_) / slope_);
  const double step = 2 * Obstacles::kVoxel_mm;
  for (double away = step; away <= most; away += step) {
    for (const auto& direction : kRound) {
      const Place end{head.joint.x + away * direction[0], head.joint.y + away * direction[1],
                      head.joint.z - away * slope_};
      if (!stands_free(end, head.radius, room)) continue;
      if (!is_way_clear(head.joint, end, head.radius, head.radius, {head.length, kFar})) continue;
      PLUMBLINE_TRY(add_bridge(head, end));
      PLUMBLINE_TRY(stand_on_plate(end, head.radius));
      ++counts_.on_plate;
      return true;
    }
  }
  return false;
}

/// A pillar from the joint down to the object, with a head at its foot.
Expected<bool> Routing::stand_on_object(const Head& head) {
  const auto column = static_cast<std::uint32_t>(std::floor(head.joint.x / px_ + 0.5));
  const auto row = static_cast<std::uint32_t>(std::floor(head.joint.y / py_ + 0.5));
  const std::uint32_t floor = obstacles_.floor_below(column, row, list_.layer_at(head.joint.z));
  if (floor == 0 || !obstacles_.is_footing(column, row, floor)) return false;
  const Place foot{head.joint.x, head.joint.y, floor * lh_};
  const double height = head.joint.z - foot.z;
  const double cone = std::min(settings_.head_width, height / 2);
  if (!(height > 0) || !is_way_clear(foot, head.joint, head.radius, head.radius, {0, head.length})) return false;
  return stand_on_foot(foot, floor, cone, head);
}

/// A pin straight down from the tip to what is below it, which is too near for a head: to the plate, or to the object.
Expected<bool> Routing::stand_below(const Tip& tip, Head& head) {
  const double bottom = tip.floor * lh_;
  const double height = head.tip.z - bottom;
  const bool on_plate = tip.floor == 0;
  if (!on_plate && settings_.buildplate_only) return false;
  const double cone = std::min(settings_.head_width, on_plate ? height * 2 / 3 : height / 2);
  head.radius = head.tip_radius + (head.radius - head.tip_radius) * cone / settings_.head_width;
  head.joint = {head.tip.x, head.tip.y, head.tip.z - cone};
  const Place foot{head.tip.x, head.tip.y, bottom};
  if (!is_way_clear(foot, head.tip, head.radius, head.tip_radius, {on_plate ? kFar : 0, 0})) return false;
  if (!on_plate) return stand_on_foot(foot, tip.floor, cone, head);
  ++counts_.on_plate;
  PLUMBLINE_TRY(stand_on_plate(head.joint, head.radius));
  return true;
}

/// A pin at 45 degrees down from the tip to the nearest wall that it can reach into, thickest in its middle.
Expected<bool> Routing::lean_on_object(Head& head) {
  constexpr double kVoxel = Obstacles::kVoxel_mm;
  const double deep = std::max(settings_.head_penetration, kVoxel);  // a voxel may be solid only at its far side
  for (double way = kAtTip; way <= kLongestLean; way += kVoxel / 2) {
    const double cone = std::min(settings_.head_width, way / 2);
    const double radius = head.tip_radius + (head.radius - head.tip_radius) * cone / settings_.head_width;
    for (const auto& aside : kRound) {
      const auto at = [&](double away) {
        return Place{head.tip.x + kC * aside[0] * away, head.tip.y + kC * aside[1] * away, head.tip.z - kC * away};
      };
      const auto pixel = [](double mm, double pitch) {
        return static_cast<std::uint32_t>(std::max(0.0, mm / pitch + 0.5));
      };
      const auto is_clear = [&](double away) {
        const auto [x, y, z] = at(away);
        return obstacles_.is_clear(pixel(x, px_), pixel(y, py_), static_cast<std::int64_t>(std::floor(z / lh_)), 0);
      };
      if (!is_clear(way - kVoxel / 2)) continue;
      double solid = 0;
      while (solid < deep + kVoxel && !is_clear(way + solid)) solid += kVoxel / 2;
      const Place end = at(way + deep);
      if (solid < deep + kVoxel || !is_way_clear(at(way), head.tip, radius, radius, {0, 0}) ||
          !obstacles_.is_footing(pixel(end.x, px_), pixel(end.y, py_), list_.layer_at(end.z + kVoxel))) {
        continue;
      }
      head.joint = at(way - cone);
      head.radius = radius;
      ++counts_.on_object;
      PLUMBLINE_TRY(list_.add(StrutKind::kBase, end, head.joint, list_.layer_at(end.z), list_.layer_at(head.joint.z),
                              head.tip_radius, radius));
      return true;
    }
  }
  return false;
}

/// @param floor  first layer above the object there
/// @param cone   height of the head at the foot
Expected<bool> Routing::stand_on_foot(const Place& foot, std::uint32_t floor, double cone, const Head& head) {
  ++counts_.on_object;
  const std::uint32_t joint = std::max(list_.layer_at(head.joint.z), floor);
  const std::uint32_t above = std::min(joint, list_.layer_at(foot.z + cone));
  PLUMBLINE_TRY(
      list_.add(StrutKind::kBase, foot, {foot.x, foot.y, foot.z + cone}, floor, above, head.tip_radius, head.radius));
  // Into the object, as a head goes: on the point of a spire the foot would be an island. Never through it: it goes on for a voxel.
  const auto deep = static_cast<std::uint32_t>(std::floor(settings_.head_penetration / lh_ + 0.5));
  const auto voxel = static_cast<std::uint32_t>(std::ceil(Obstacles::kVoxel_mm / lh_));
  const auto column = static_cast<std::int64_t>(std::floor(foot.x / px_ + 0.5));
  const auto row = static_cast<std::int64_t>(std::floor(foot.y / py_ + 0.5));
  if (deep > 0 && floor > deep + voxel && !obstacles_.is_clear(column, row, floor - 1 - deep - voxel, 0)) {
    PLUMBLINE_TRY(list_.add(StrutKind::kBase, foot, foot, floor - deep, floor, head.tip_radius, head.tip_radius));
  }
  PLUMBLINE_TRY(list_.add(StrutKind::kPillar, foot, head.joint, above, joint, head.radius, head.radius));
  Pillar pillar;
  pillar.x = foot.x;
  pillar.y = foot.y;
  pillar.bottom = foot.z + cone;
  pillar.top = head.joint.z;
  pillar.radius = head.radius;
  PLUMBLINE_TRY(list_.add_pillar(pillar));
  return true;
}

Status Routing::add_bridge(const Head& head, const Place& end) {
  return list_.add(StrutKind::kBridge, end, head.joint, list_.layer_at(end.z), list_.layer_at(head.joint.z) + 1,
                   head.radius, head.radius);
}

Status Routing::stand_on_plate(const Place& place, double radius) {
  const auto [x, y, top] = place;
  const Place foot{x, y, raft_};
  const std::uint32_t first = raft_ > 0 ? list_.layer_at(raft_ + lh_ / 2) : 0;
  const std::uint32_t end = std::max(first, list_.layer_at(top) + 1);
  PLUMBLINE_TRY(list_.add(StrutKind::kPillar, {x, y, 0}, {x, y, top}, 0, end, radius, radius));
  // On the plate beside the object, the largest base that keeps its distance; at most a third as high as its pillar.
  double base = std::max(radius, settings_.base_diameter / 2);
  const double height = std::min(settings_.base_height, (top - raft_) / 3);
  while (base > radius &&
         (!is_on_panel(x, y, base) || !is_way_clear(foot, {x, y, raft_ + height}, base, base, {kFar, kFar}))) {
    base = std::max(radius, base - Obstacles::kVoxel_mm);
  }
  const std::uint32_t above = std::min(end, list_.layer_at(raft_ + height + lh_ / 2));
  if (above > first) {
    PLUMBLINE_TRY(list_.add(StrutKind::kBase, foot, {x, y, raft_ + height}, first, above, base, radius));
  }
  Pillar pillar;
  pillar.x = x;
  pillar.y = y;
  pillar.top = top;
  pillar.radius = radius;
  pillar.on_plate = true;
  return list_.add_pillar(pillar);
}

}  // namespace plumbline::inline slicer
