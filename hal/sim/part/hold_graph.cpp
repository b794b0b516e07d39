#include "hal/sim/part/hold_graph.hpp"

#include <algorithm>

namespace plumbline::inline hal::inline sim {

HoldGraph::HoldGraph() {
  // The plate's two vertices are one: nothing tears between them.
  limbs_.push_back({.holds = kUnbreakable});
  first_arc_.assign(2, kNone);
  add_edge(0, 1, kUnbreakable);
}

void HoldGraph::add_edge(std::uint32_t above, std::uint32_t below, double newtons) {
  for (const auto& [from, to] : {std::pair{below, above}, std::pair{above, below}}) {
    arcs_.push_back({.to = to, .next = first_arc_[from], .newtons = newtons});
    first_arc_[from] = static_cast<std::uint32_t>(arcs_.size() - 1);
  }
}

std::uint32_t HoldGraph::begin_limb(std::span<const Joint> joints, const Place& place, double mm3) {
  const auto limb = static_cast<std::uint32_t>(limbs_.size());
  first_arc_.resize(first_arc_.size() + 2, kNone);
  double holds = 0;
  // The neck's edge comes first, so its arcs are found again by extend().
  Limb added{.begin = place, .neck = place, .below_mm3 = mm3};
  added.neck_arc = static_cast<std::uint32_t>(arcs_.size());
  add_edge(2 * limb, 2 * limb + 1, kUnbreakable);
  for (const Joint& joint : joints) {
    add_edge(2 * joint.limb + 1, 2 * limb, joint.newtons);
    holds += std::min(joint.newtons, limbs_[joint.limb].holds * joint.share);
  }
  added.holds = holds;
  limbs_.push_back(added);
  return limb;
}

void HoldGraph::extend(std::uint32_t limb, double newtons, const Place& place, double mm3) {
  Limb& l = limbs_[limb];
  Arc& neck = arcs_[l.neck_arc];
  if (newtons < neck.newtons) {
    neck.newtons = arcs_[l.neck_arc ^ 1U].newtons = newtons;
    l.above_mm3 += l.below_mm3;
    l.below_mm3 = 0;
    l.neck = place;
    l.holds = std::min(l.holds, newtons);
  }
  l.below_mm3 += mm3;
}

std::vector<HoldGraph::Tear> HoldGraph::pull(std::span<const Load> loads) {
  const auto surely = [&](const Load& load) { return load.newtons <= limbs_[load.limb].holds; };
  if (std::all_of(loads.begin(), loads.end(), surely)) return {};
  // Twice the load first: if that holds, the next look is due when some load has doubled.
  for (const double factor : {2.0, 1.0}) {
    if (!carry_all(loads, factor)) continue;
    for (const Load& load : loads) limbs_[load.limb].holds = factor * load.newtons;
    return {};
  }
  std::vector<Tear> tears;
  std::vector<Load> left(loads.begin(), loads.end());
  while (!carry_all(left, 1)) {
    const auto worst = std::find_if(rest_.begin(), rest_.end(), [](double rest) { return rest > kNothing; });
    const Load& load = left[static_cast<std::size_t>(worst - rest_.begin())];
    tears.push_back(tear_from(2 * load.limb + 1, left));
    for (const std::uint32_t i : tears.back().loads) left[i].newtons = 0;
  }
  for (const Load& load : left) limbs_[load.limb].holds = load.newtons;
  return tears;
}

bool HoldGraph::carry_all(std::span<const Load> loads, double factor) {
  for (Arc& arc : arcs_) arc.flow = 0;
  rest_.clear();
  for (const Load& load : loads) rest_.push_back(load.newtons * factor);
  for (auto& list : lists_) list.resize(first_arc_.size());
  work_in({lists_[0], lists_[1], lists_[2], lists_[3]});
  return carry(rest_, [&](std::uint32_t i) { return 2 * loads[i].limb + 1; });
}

HoldGraph::Tear HoldGraph::tear_from(std::uint32_t vertex, std::span<const Load> loads) {
  const auto piece = reach_from(vertex);
  Tear tear;
  double strongest = -1;
  for (const std::uint32_t here : piece) {
    for (std::uint32_t a = first_arc_[here]; a != kNone; a = arcs_[a].next) {
      Arc& arc = arcs_[a];
      if (reached(arc.to) || arc.newtons <= 0) continue;
      tear.held_n += arc.newtons;
      if (arc.newtons > strongest) {
        strongest = arc.newtons;
        const Limb& lower = limbs_[std::max(here, arc.to) / 2];
        tear.place = here / 2 == arc.to / 2 ? lower.neck : lower.begin;
      }
      arc.newtons = arcs_[a ^ 1U].newtons = 0;
    }
  }
  for (const std::uint32_t here : piece) {
    Limb& limb = limbs_[here / 2];
    const bool top = reached(here & ~1U);
    const bool bottom = reached(here | 1U);
    const bool at_top = (here & 1U) == 0;
    tear.mm3 += at_top ? limb.above_mm3 : limb.below_mm3;
    const bool lost_before = limb.lost_from != kNone;  // then it was the other part
    limb.lost_from = top || lost_before ? 0 : limb.neck.layer;
    limb.lost_to = bottom || lost_before ? kNone : limb.neck.layer;
  }
  for (std::uint32_t i = 0; i < loads.size(); ++i) {
    if (!reached(2 * loads[i].limb + 1)) continue;
    tear.asked_n += loads[i].newtons;
    tear.loads.push_back(i);
  }
  any_lost_ = true;
  return tear;
}

}  // namespace plumbline::inline hal::inline sim
