#include "slicer/supports/routing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/core/numbers/degrees.hpp"

namespace plumbline {
namespace {

/// A pillar carries this many heads besides its own.
constexpr std::uint32_t kMostBridges = 5;
/// mm; farther pillars are joined only if nothing leads straight down.
constexpr double kShortBridge = 4;
/// The normal is that of the surface within so many voxels, 1 mm.
constexpr std::int32_t kNormalVoxels = 4;
/// Largest horizontal part of a head's direction: 45 degrees.
constexpr double kMostTilt = 0.70710678118654752;
/// By which the room round a way must grow for each millimetre from a head, which begins at the object.
constexpr double kOpening = 0.5;
/// mm; of a joint above plate or raft.
constexpr double kLowestJoint = 0.5;

// Light below a quarter of the most load, heavy above three quarters: diameters of tip and pillar.
struct LoadClass {
  double tip, pillar;
};
constexpr LoadClass kLight = {kLightTip, 0.75};
constexpr LoadClass kMedium = {1, 1};
constexpr LoadClass kHeavy = {1.5, 1.2};

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

Status Routing::route(const Tip& tip) {
  const double share = tip.load * px_ * py_ / settings_.area_per_tip;
  const LoadClass& load = share < 0.25 ? kLight : share > 0.75 ? kHeavy : kMedium;
  ++(share < 0.25 ? counts_.light : share > 0.75 ? counts_.heavy : counts_.medium);
  Head head;
  head.tip = {tip.column * px_, tip.row * py_, tip.layer * lh_};
  head.radius = settings_.pillar_diameter / 2 * load.pillar;
  head.tip_radius = std::min(head.radius, settings_.head_front_diameter / 2 * load.tip);
  PLUMBLINE_TRY(list_.add(StrutKind::kTip, head.tip, head.tip, tip.layer, tip.end, head.tip_radius, head.tip_radius));

  const double safe = settings_.base_safety_distance;
  const double pillar = settings_.pillar_diameter / 2 + safe;
  for (const Room& room : {Room{safe, settings_.base_diameter / 2 + safe}, Room{safe, pillar}, Room{0, 0}}) {
    // Along the normal, half as far aside, straight down.
    for (const double tilt : {1.0, 0.5, 0.0}) {
      if (!find_joint(tip, tilt, head)) continue;
      auto done = join_pillar(head, room.clear, kShortBridge);
      if (done && !*done) done = lead_to_plate(head, room);
      if (done && !*done) done = join_pillar(head, room.clear, settings_.max_bridge_length);
      if (done && !*done) done = lead_aside(head, room);
      PLUMBLINE_TRY(done);
      if (!*done) continue;
      if (room.clear < safe) ++counts_.close;
      return add_head(head, tip.layer);
    }
  }
  return straight_down(tip, head);
}

/// @param share  of the normal's horizontal part
bool Routing::find_joint(const Tip& tip, double share, Head& head) const {
  const Vec3d normal = obstacles_.normal(tip.column, tip.row, tip.layer, kNormalVoxels);
  double nx = normal[0] * share;
  double ny = normal[1] * share;
  const double aside = std::sqrt(nx * nx + ny * ny);
  if (aside > kMostTilt || normal[2] > 0) {
    nx *= aside > 0 ? kMostTilt * share / aside : 0;
    ny *= aside > 0 ? kMostTilt * share / aside : 0;
  }
  const double down = std::sqrt(std::max(0.0, 1 - nx * nx - ny * ny));
  head.joint = {head.tip.x + nx * settings_.head_width, head.tip.y + ny * settings_.head_width,
                head.tip.z - down * settings_.head_width};
  return head.joint.z >= low_ && is_on_panel(head.joint.x, head.joint.y, head.radius) &&
         is_way_clear(head.joint, head.joint, head.radius, 0);
}

/// Whether a rod of `radius` fits, with room that grows from none at `from` to `clear`.
bool Routing::is_way_clear(const Place& from, const Place& to, double radius, double clear) const {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const double dz = to.z - from.z;
  const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
  const auto steps = static_cast<std::uint32_t>(std::ceil(length / Obstacles::kVoxel_mm)) + 1;
  for (std::uint32_t i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const double room = radius + std::min(clear, kOpening * t * length);
    const auto column = static_cast<std::int64_t>(std::floor((from.x + t * dx) / px_ + 0.5));
    const auto row = static_cast<std::int64_t>(std::floor((from.y + t * dy) / py_ + 0.5));
    const auto layer = static_cast<std::int64_t>(std::floor((from.z + t * dz) / lh_));
    if (!obstacles_.is_clear(column, row, layer, nanometres(room))) return false;
  }
  return true;
}

/// Whether a pillar from the plate to z has its room.
bool Routing::stands_free(double x, double y, double z, double radius, const Room& room) const {
  if (!is_on_panel(x, y, settings_.base_diameter / 2 + (raft_ > 0 ? settings_.pad_brim_size : 0))) return false;
  if (!is_way_clear({x, y, raft_}, {x, y, raft_}, room.base, 0)) return false;
  if (room.clear < settings_.base_safety_distance) return is_way_clear({x, y, z}, {x, y, 0}, radius, room.clear);
  const auto column = static_cast<std::int64_t>(std::floor(x / px_ + 0.5));
  const auto row = static_cast<std::int64_t>(std::floor(y / py_ + 0.5));
  return obstacles_.is_column_clear(column, row, static_cast<std::int64_t>(std::floor(z / lh_)));
}

bool Routing::is_on_panel(double x, double y, double radius) const {
  const PrintGrid& grid = list_.grid();
  return x >= radius && y >= radius && x <= (grid.columns - 1) * px_ - radius && y <= (grid.rows - 1) * py_ - radius;
}

bool Routing::can_stand_below(const Place& joint, double radius, const Room& room) const {
  const double open = std::max(0.0, joint.z - room.clear / kOpening);
  return stands_free(joint.x, joint.y, open, radius, room) &&
         is_way_clear(joint, {joint.x, joint.y, open}, radius, room.clear);
}

Expected<bool> Routing::lead_to_plate(const Head& head, const Room& room) {
  if (!can_stand_below(head.joint, head.radius, room)) return false;
  PLUMBLINE_TRY(stand_on_plate(head.joint.x, head.joint.y, head.joint.z, head.radius));
  ++counts_.on_plate;
  return true;
}

Expected<bool> Routing::join_pillar(const Head& head, double clear, double farthest) {
  Pillar* best = nullptr;
  double least = 0;
  Place end;
  const double most = farthest / std::sqrt(1 + slope_ * slope_);
  for (Pillar& pillar : list_.pillars()) {
    const double dx = pillar.x - head.joint.x;
    const double dy = pillar.y - head.joint.y;
    const double away = std::sqrt(dx * dx + dy * dy);
    if (away > most || pillar.bridges >= kMostBridges || (best != nullptr && away >= least)) continue;
    const Place at{pillar.x, pillar.y, head.joint.z - away * slope_};
    const double foot = pillar.bottom + (pillar.on_plate ? raft_ : 0) + kLowestJoint;
    if (at.z < foot || at.z > pillar.top) continue;
    // Its own pillar would take less.
    if (farthest <= kShortBridge && away * std::sqrt(1 + slope_ * slope_) > head.joint.z - low_) continue;
    if (!is_way_clear(head.joint, at, head.radius, clear)) continue;
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
    // Sixteen directions: unit vectors at multiples of 22.5 degrees.
    constexpr double kA = 0.92387953251128674;
    constexpr double kB = 0.38268343236508977;
    constexpr double kC = 0.70710678118654752;
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
    for (const auto& direction : kRound) {
      const Place end{head.joint.x + away * direction[0], head.joint.y + away * direction[1],
                      head.joint.z - away * slope_};
      if (!stands_free(end.x, end.y, end.z, head.radius, room)) continue;
      if (!is_way_clear(head.joint, end, head.radius, room.clear)) continue;
      PLUMBLINE_TRY(add_bridge(head, end));
      PLUMBLINE_TRY(stand_on_plate(end.x, end.y, end.z, head.radius));
      ++counts_.on_plate;
      return true;
    }
  }
  return false;
}

/// A pillar from the tip to what is below it, with a head at its foot if that is the object.
Status Routing::straight_down(const Tip& tip, const Head& head) {
  const double bottom = tip.floor * lh_;
  const double height = head.tip.z - bottom;
  const bool on_plate = tip.floor == 0;
  const double cone = std::min(settings_.head_width, on_plate ? height * 2 / 3 : height / 2);
  const double radius = head.tip_radius + (head.radius - head.tip_radius) * cone / settings_.head_width;
  const Place top{head.tip.x, head.tip.y, head.tip.z - cone};
  const std::uint32_t joint = std::clamp(list_.layer_at(top.z), std::uint32_t{tip.floor}, std::uint32_t{tip.layer});
  PLUMBLINE_TRY(list_.add(StrutKind::kHead, top, head.tip, joint, tip.layer, radius, head.tip_radius));
  const double safe = settings_.base_safety_distance;
  const bool is_close = !stands_free(top.x, top.y, top.z - safe / kOpening, head.radius, {safe, 0});
  if (is_close) ++counts_.close;
  if (on_plate) {
    ++counts_.on_plate;
    return stand_on_plate(top.x, top.y, top.z, radius);
  }
  ++counts_.on_object;
  const Place foot{head.tip.x, head.tip.y, bottom};
  const std::uint32_t above = std::min(joint, list_.layer_at(bottom + cone));
  PLUMBLINE_TRY(list_.add(StrutKind::kBase, foot, foot, tip.floor, above, head.tip_radius, radius));
  // Into the object, as a head goes: on the point of a spire the foot would be an island. Never through it: it goes on for a voxel.
  const auto deep = static_cast<std::uint32_t>(std::floor(settings_.head_penetration / lh_ + 0.5));
  const auto voxel = static_cast<std::uint32_t>(std::ceil(Obstacles::kVoxel_mm / lh_));
  if (deep > 0 && tip.floor > deep + voxel &&
      !obstacles_.is_clear(tip.column, tip.row, tip.floor - 1 - deep - voxel, 0)) {
    PLUMBLINE_TRY(
        list_.add(StrutKind::kBase, foot, foot, tip.floor - deep, tip.floor, head.tip_radius, head.tip_radius));
  }
  PLUMBLINE_TRY(list_.add(StrutKind::kPillar, foot, top, above, joint, radius, radius));
  Pillar pillar;
  pillar.x = top.x;
  pillar.y = top.y;
  pillar.bottom = bottom + cone;
  pillar.top = top.z;
  pillar.radius = radius;
  return list_.add_pillar(pillar);
}

Status Routing::add_head(const Head& head, std::uint32_t layer) {
  return list_.add(StrutKind::kHead, head.joint, head.tip, std::min(layer, list_.layer_at(head.joint.z)), layer,
                   head.radius, head.tip_radius);
}

Status Routing::add_bridge(const Head& head, const Place& end) {
  return list_.add(StrutKind::kBridge, end, head.joint, list_.layer_at(end.z), list_.layer_at(head.joint.z) + 1,
                   head.radius, head.radius);
}

Status Routing::stand_on_plate(double x, double y, double top, double radius) {
  const Place foot{x, y, raft_};
  const std::uint32_t first = raft_ > 0 ? list_.layer_at(raft_ + lh_ / 2) : 0;
  const std::uint32_t end = std::max(first, list_.layer_at(top) + 1);
  PLUMBLINE_TRY(list_.add(StrutKind::kPillar, {x, y, 0}, {x, y, top}, 0, end, radius, radius));
  // On the plate beside the object, the largest base that keeps its distance; at most a third as high as its pillar.
  double base = std::max(radius, settings_.base_diameter / 2);
  const double height = std::min(settings_.base_height, (top - raft_) / 3);
  while (base > radius && (!is_on_panel(x, y, base) || !is_way_clear({x, y, raft_}, {x, y, raft_ + height},
                                                                     base + settings_.base_safety_distance, 0))) {
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

}  // namespace plumbline
