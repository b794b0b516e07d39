#include "slicer/supports/bracing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/core/numbers/degrees.hpp"

namespace plumbline::inline slicer {
namespace {

/// Between braces of two pillars, mm, so that a cutter gets in; and a brace is added only where a pillar has no contact for longer.
constexpr double kApart = 6;
/// mm between a brace and a pillar that it passes.
constexpr double kPassing = 0.5;
/// Longest rise of a brace, mm.
constexpr double kMostRise = 8;
/// A brace is this share of a pillar's diameter.
constexpr double kThickness = 0.5;
/// Props, legs and helpers of a pillar, at most.
constexpr int kMostProps = 2;
constexpr int kMostLegs = 1;
constexpr int kMostHelpers = 2;
/// Slope of props and legs, at most. A leg at the critical angle from the rim of the base would reach no higher than that is wide.
constexpr double kSteepest = 3;
/// A prop or leg that halves no gap, but takes less than this share of it, is left out.
constexpr double kLeastShare = 0.2;
/// The raft has a disc below each pillar, and a bar to the next one.
constexpr std::size_t kStrutsOfRaft = 2;
/// Neighbours that are tried.
constexpr std::size_t kMostNeighbours = 12;
/// Distances of a helper from its pillar, mm.
constexpr std::array<double, 5> kHelperAway = {4, 5, 3, 6, 7};
constexpr double kC = 0.70710678118654752;
/// Unit vectors at multiples of 45 degrees.
constexpr std::array<std::array<double, 2>, 8> kRound = {
    {{1, 0}, {kC, kC}, {0, 1}, {-kC, kC}, {-1, 0}, {-kC, -kC}, {0, -1}, {kC, -kC}}};
constexpr std::uint32_t kNone = ~0U;

}  // namespace

Bracing::Bracing(const SupportSettings& settings, double raft_mm, const Obstacles& obstacles, StrutList& list,
                 std::span<StrutContact> contacts)
    : settings_(settings),
      raft_(raft_mm),
      px_(static_cast<double>(list.grid().pitch_x_mm)),
      py_(static_cast<double>(list.grid().pitch_y_mm)),
      lh_(static_cast<double>(list.grid().layer_height_mm)),
      radius_(settings.pillar_diameter / 2 * kThickness),
      obstacles_(obstacles),
      list_(list),
      contacts_(contacts) {
  const SineCosine angle = sine_cosine(settings.critical_angle);
  slope_ = angle.sine / angle.cosine;
}

Status Bracing::brace_all() {
  const std::size_t pillars = list_.pillars().size();  // helpers come after these
  if (settings_.max_pillar_link_distance > 0) {
    for (std::size_t i = 0; i < pillars; ++i) PLUMBLINE_TRY(brace(i));
  }
  for (const Pillar& pillar : list_.pillars()) {
    const double free = largest_gap(pillar).height();
    counts_.longest_free_mm = std::max(counts_.longest_free_mm, free);
    if (free > kMostFree_mm) ++counts_.unbraced;
  }
  return {};
}

double Bracing::distance(const Pillar& a, const Pillar& b) const {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

/// A brace between such pillars would hold neither, and close the gap between them.
bool Bracing::stand_in_each_other(const Pillar& a, const Pillar& b) const {
  return distance(a, b) < a.radius + b.radius + 2 * radius_ + kPassing;
}

Bracing::Gap Bracing::largest_gap(const Pillar& pillar) const {
  Gap largest;
  double at = foot(pillar);
  while (at < pillar.top) {
    double next = pillar.top;
    for (std::uint32_t c = pillar.contacts; c != kNone; c = contacts_[c].next) {
      if (contacts_[c].z > at) next = std::min(next, contacts_[c].z);
    }
    if (next - at > largest.height()) largest = {at, next};
    at = next;
  }
  return largest;
}

Bracing::Gap Bracing::gap_at(const Pillar& pillar, double z) const {
  Gap gap{foot(pillar), pillar.top};
  for (std::uint32_t c = pillar.contacts; c != kNone; c = contacts_[c].next) {
    if (contacts_[c].z <= z) gap.low = std::max(gap.low, contacts_[c].z);
    if (contacts_[c].z >= z) gap.high = std::min(gap.high, contacts_[c].z);
  }
  return gap;
}

void Bracing::add_contact(Pillar& pillar, double z) {
  if (contact_count_ == contacts_.size()) return;  // then a pillar is counted as less braced than it is
  contacts_[contact_count_] = {z, pillar.contacts};
  pillar.contacts = static_cast<std::uint32_t>(contact_count_++);
}

/// Whether a brace keeps its distance from the object, and from the pillars between its ends.
bool Bracing::is_clear(const Place& from, const Place& to) const {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const double dz = to.z - from.z;
  const double square = dx * dx + dy * dy;
  for (const Pillar& pillar : list_.pillars()) {
    const double x = pillar.x - from.x;
    const double y = pillar.y - from.y;
    const double t = square > 0 ? (x * dx + y * dy) / square : 0;
    const double room = pillar.radius + radius_ + kPassing;
    const bool is_end = (x == 0 && y == 0) || (pillar.x == to.x && pillar.y == to.y);
    if (is_end || !(t > 0 && t < 1) || from.z + t * dz < pillar.bottom || from.z + t * dz > pillar.top) continue;
    if ((x - t * dx) * (x - t * dx) + (y - t * dy) * (y - t * dy) < room * room) return false;
  }
  const auto steps = static_cast<std::uint32_t>(std::ceil(std::sqrt(square + dz * dz) / Obstacles::kVoxel_mm)) + 1;
  for (std::uint32_t i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    if (!obstacles_.is_clear(static_cast<std::int64_t>(std::floor((from.x + t * dx) / px_ + 0.5)),
                             static_cast<std::int64_t>(std::floor((from.y + t * dy) / py_ + 0.5)),
                             static_cast<std::int64_t>(std::floor((from.z + t * dz) / lh_)),
                             nanometres(radius_ + settings_.base_safety_distance))) {
      return false;
    }
  }
  return true;
}

Expected<bool> Bracing::join(Pillar& a, Pillar& b) {
  const double rise = distance(a, b) * slope_;
  if (rise > kMostRise || stand_in_each_other(a, b)) return false;
  const double low = std::max(foot(a), foot(b));
  double high = std::min(a.top, b.top);
  Pillar& upper = a.top >= b.top ? a : b;
  Pillar& lower = &upper == &a ? b : a;
  bool any = false;
  while (high - rise > low && has_room()) {
    const Place from{lower.x, lower.y, high - rise};
    const Place to{upper.x, upper.y, high};
    const bool helps = gap_at(lower, from.z).height() > kApart || gap_at(upper, to.z).height() > kApart;
    if (helps && is_clear(from, to)) {
      PLUMBLINE_TRY(add_brace(lower, upper, from, to));
      any = true;
      high -= std::max(kApart, rise);
    } else {
      high -= std::max(lh_, Obstacles::kVoxel_mm);
    }
  }
  return any;
}

Status Bracing::add_brace(Pillar& lower, Pillar& upper, const Place& from, const Place& to) {
  PLUMBLINE_TRY(
      list_.add(StrutKind::kBrace, from, to, list_.layer_at(from.z), list_.layer_at(to.z) + 1, radius_, radius_));
  add_contact(lower, from.z);
  add_contact(upper, to.z);
  ++counts_.braces;
  return {};
}

Status Bracing::brace(std::size_t index) {
  const auto pillars = list_.pillars();
  Pillar& pillar = pillars[index];
  double reached = -1;  // neighbours up to this distance have been tried, those at it up to index `last`
  std::size_t last = 0;
  for (std::size_t tried = 0; tried < kMostNeighbours; ++tried) {
    const Gap gap = largest_gap(pillar);
    if (gap.height() <= kWantedFree_mm) return {};
    std::size_t nearest = pillars.size();
    double least = 0;
    for (std::size_t i = 0; i < pillars.size(); ++i) {
      const double away = distance(pillar, pillars[i]);
      if (i == index || away > settings_.max_pillar_link_distance) continue;
      if (away < reached || (away == reached && i <= last)) continue;
      if (pillars[i].top < gap.low || (nearest < pillars.size() && away >= least)) continue;
      nearest = i;
      least = away;
    }
    if (nearest == pillars.size()) break;
    reached = least;
    last = nearest;
    const auto done = join(pillar, pillars[nearest]);
    PLUMBLINE_TRY(done);
  }
  const auto add_up_to = [&](int most, double wanted_mm, auto add) -> Status {
    for (int added = 0; added < most; ++added) {
      const Gap gap = largest_gap(pillar);
      if (gap.height() <= wanted_mm) return {};
      const auto done = add(gap);
      PLUMBLINE_TRY(done);
      if (!*done) return {};
    }
    return {};
  };
  PLUMBLINE_TRY(add_up_to(kMostProps, kWantedFree_mm, [&](const Gap& gap) { return add_prop(pillar, gap); }));
  PLUMBLINE_TRY(add_up_to(kMostLegs, kWantedFree_mm, [&](const Gap& gap) { return add_leg(pillar, gap); }));
  return add_up_to(kMostHelpers, kMostFree_mm, [&](const Gap& gap) { return add_helper(index, gap); });
}

/// Props a pillar as near to the middle of a gap as one of its neighbours can, the nearest one there.
Expected<bool> Bracing::add_prop(Pillar& pillar, const Gap& gap) {
  if (!has_room()) return false;
  const double middle = (gap.low + gap.high) / 2;
  for (double off = 0; off <= gap.height() * (0.5 - kLeastShare); off += Obstacles::kVoxel_mm) {
    for (const double z : {middle - off, middle + off}) {
      const Place to{pillar.x, pillar.y, z};
      Pillar* nearest = nullptr;
      Place from;
      double least = std::min(settings_.max_pillar_link_distance, kMostRise / slope_);
      for (Pillar& other : list_.pillars()) {
        const double away = distance(pillar, other);
        if (away > least || stand_in_each_other(pillar, other)) continue;
        const Place at{other.x, other.y, std::min(other.top, z - away * slope_)};
        if (at.z < foot(other) || z - at.z > std::max(slope_, kSteepest) * away || !is_clear(at, to)) continue;
        nearest = &other;
        from = at;
        least = away;
      }
      if (nearest == nullptr) continue;
      PLUMBLINE_TRY(add_brace(*nearest, pillar, from, to));
      return true;
    }
  }
  return false;
}

/// Props a pillar by a strut from its base: from the raft, or from the plate.
Expected<bool> Bracing::add_leg(Pillar& pillar, const Gap& gap) {
  if (!pillar.on_plate || !has_room()) return false;
  // The raft is no wider than the panel.
  const double beside = std::min(
      {pillar.x, pillar.y, (list_.grid().columns - 1) * px_ - pillar.x, (list_.grid().rows - 1) * py_ - pillar.y});
  const double rim =
      std::min(settings_.base_diameter / 2 + (raft_ > 0 ? settings_.pad_brim_size : 0), beside) - radius_;
  const double rise = std::min(std::max((gap.low + gap.high) / 2, gap.high - kWantedFree_mm) - raft_, kSteepest * rim);
  const Place top{pillar.x, pillar.y, raft_ + rise};
  if (top.z - gap.low < kLeastShare * gap.height()) return false;
  const double away = std::min(rim, rise / slope_);
  for (const auto& direction : kRound) {
    const Place foot{pillar.x + away * direction[0], pillar.y + away * direction[1], raft_};
    if (!is_clear(foot, top)) continue;
    PLUMBLINE_TRY(list_.add(StrutKind::kBrace, foot, top, raft_ > 0 ? list_.layer_at(raft_ + lh_ / 2) : 0,
                            list_.layer_at(top.z) + 1, radius_, radius_));
    add_contact(pillar, top.z);
    ++counts_.braces;
    return true;
  }
  return false;
}

/// Whether the list has struts left that the raft does not need: braces are a help, so they refuse no print.
bool Bracing::has_room() const { return list_.spare() > kStrutsOfRaft * (list_.pillars().size() + 1); }

/// Puts a pillar beside another and braces the two.
Expected<bool> Bracing::add_helper(std::size_t index, const Gap& gap) {
  if (!has_room()) return false;
  const Pillar pillar = list_.pillars()[index];
  const double reach = settings_.base_diameter / 2 + (raft_ > 0 ? settings_.pad_brim_size : 0);
  const double wide = (list_.grid().columns - 1) * px_ - reach;
  const double deep = (list_.grid().rows - 1) * py_ - reach;
  for (const double away : kHelperAway) {
    if (away * slope_ > kMostRise || away > settings_.max_pillar_link_distance) continue;
    for (const auto& direction : kRound) {
      Pillar helper;
      helper.x = pillar.x + away * direction[0];
      helper.y = pillar.y + away * direction[1];
      helper.top = std::min(pillar.top - away * slope_ / 2, gap.high);
      helper.radius = settings_.pillar_diameter / 2;
      helper.on_plate = true;
      if (helper.x < reach || helper.y < reach || helper.x > wide || helper.y > deep) continue;
      const auto column = static_cast<std::int64_t>(std::floor(helper.x / px_ + 0.5));
      const auto row = static_cast<std::int64_t>(std::floor(helper.y / py_ + 0.5));
      const auto layer = static_cast<std::int64_t>(std::floor(helper.top / lh_));
      if (!obstacles_.is_column_clear(column, row, layer)) continue;
      if (!is_clear({pillar.x, pillar.y, helper.top - away * slope_}, {helper.x, helper.y, helper.top})) continue;
      PLUMBLINE_TRY(list_.add_pillar(helper));
      PLUMBLINE_TRY(list_.add(StrutKind::kPillar, {helper.x, helper.y, 0}, {helper.x, helper.y, helper.top}, 0,
                              list_.layer_at(helper.top) + 1, helper.radius, helper.radius));
      const Place foot{helper.x, helper.y, raft_};
      const std::uint32_t first = raft_ > 0 ? list_.layer_at(raft_ + lh_ / 2) : 0;
      const std::uint32_t above = list_.layer_at(raft_ + settings_.base_height + lh_ / 2);
      PLUMBLINE_TRY(list_.add(StrutKind::kBase, foot, foot, first, std::max(first, above), settings_.base_diameter / 2,
                              helper.radius));
      ++counts_.helpers;
      const auto pillars = list_.pillars();
      return join(pillars[index], pillars.back());
    }
  }
  return false;
}

}  // namespace plumbline::inline slicer
