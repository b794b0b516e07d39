#include "slicer/core/regions/hold_network.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "checks";

}  // namespace

Expected<HoldNetwork> HoldNetwork::create(std::uint32_t most_ends, Arena& arena) {
  const std::size_t bodies = most_bodies(most_ends);
  const std::size_t joints = most_joints(most_ends);
  HoldNetwork network;
  const auto take = [&arena]<class T>(std::span<T>& to, std::size_t count) -> Status {
    const auto taken = arena.take_top<T>(count, kStage);
    PLUMBLINE_TRY(taken);
    to = *taken;
    return {};
  };
  PLUMBLINE_TRY(take(network.bodies_, bodies));
  PLUMBLINE_TRY(take(network.arcs_, 2 * joints));
  PLUMBLINE_TRY(take(network.joints_, joints));
  for (auto* ends : {&network.ends_, &network.below_}) PLUMBLINE_TRY(take(*ends, most_ends));
  for (auto* loads : {&network.load_, &network.rest_}) PLUMBLINE_TRY(take(*loads, most_ends));
  PLUMBLINE_TRY(take(network.todo_, bodies));
  std::span<std::uint32_t> lists[kListsOfVertices];
  for (auto& list : lists) PLUMBLINE_TRY(take(list, bodies));
  network.work_in(lists);
  PLUMBLINE_TRY(take(network.torn_, most_ends));
  network.clear();
  return network;
}

std::size_t HoldNetwork::bytes_needed(std::uint32_t most_ends) {
  const std::size_t bodies = most_bodies(most_ends);
  const std::size_t joints = most_joints(most_ends);
  return Arena::rounded(bodies * sizeof(Body)) + Arena::rounded(2 * joints * sizeof(Arc)) +
         Arena::rounded(joints * sizeof(Joint)) + 2 * Arena::rounded(most_ends * sizeof(End)) +
         2 * Arena::rounded(most_ends * sizeof(double)) +
         (1 + kListsOfVertices) * Arena::rounded(bodies * sizeof(std::uint32_t)) +
         Arena::rounded(most_ends * sizeof(std::uint32_t));
}

void HoldNetwork::clear() {
  bodies_[kPlate] = {.is_end = true};  // it stays, whatever hangs from it
  body_count_ = 1;
  joint_count_ = 0;
  free_body_ = free_joint_ = kNone;
  end_count_ = below_count_ = todo_count_ = 0;
}

std::uint32_t HoldNetwork::new_body(std::uint64_t voxels) {
  std::uint32_t body = free_body_;
  if (body != kNone) {
    free_body_ = bodies_[body].first_arc;
  } else if (body_count_ < bodies_.size()) {
    body = body_count_++;
  } else {
    return kNone;
  }
  bodies_[body] = {.voxels = voxels, .is_end = true};
  return body;
}

bool HoldNetwork::new_joint(std::uint32_t a, std::uint32_t b, const Joint& joint) {
  std::uint32_t at = free_joint_;
  if (at != kNone) {
    free_joint_ = arcs_[2 * at].next;
  } else if (joint_count_ < joints_.size()) {
    at = joint_count_++;
  } else {
    return false;
  }
  joints_[at] = joint;
  arcs_[2 * at].to = b;
  arcs_[2 * at + 1].to = a;
  link_arc(a, 2 * at);
  link_arc(b, 2 * at + 1);
  return true;
}

void HoldNetwork::link_arc(std::uint32_t body, std::uint32_t arc) {
  Body& from = bodies_[body];
  arcs_[arc].before = kNone;
  arcs_[arc].next = from.first_arc;
  if (from.first_arc != kNone) arcs_[from.first_arc].before = arc;
  from.first_arc = arc;
  ++from.arcs;
}

void HoldNetwork::unlink_arc(std::uint32_t body, std::uint32_t arc) {
  const auto [before, next] = std::pair(arcs_[arc].before, arcs_[arc].next);
  (before == kNone ? bodies_[body].first_arc : arcs_[before].next) = next;
  if (next != kNone) arcs_[next].before = before;
  --bodies_[body].arcs;
}

void HoldNetwork::remove_joint(std::uint32_t joint) {
  unlink_arc(arcs_[2 * joint + 1].to, 2 * joint);
  unlink_arc(arcs_[2 * joint].to, 2 * joint + 1);
  joints_[joint].newtons = 0;
  arcs_[2 * joint].next = std::exchange(free_joint_, joint);
}

void HoldNetwork::remove_body(std::uint32_t body) { bodies_[body].first_arc = std::exchange(free_body_, body); }

void HoldNetwork::list(std::uint32_t body) {
  if (bodies_[body].is_end || std::exchange(bodies_[body].is_listed, true)) return;
  todo_[todo_count_++] = body;
}

void HoldNetwork::reduce_listed() {
  while (todo_count_ > 0) {
    const std::uint32_t body = todo_[--todo_count_];
    bodies_[body].is_listed = false;
    reduce(body);
  }
}

/// Merges a body without an end into another, if it hangs between less than three.
void HoldNetwork::reduce(std::uint32_t body) {
  Body& from = bodies_[body];
  if (from.arcs > 2) return;
  if (from.arcs == 0) return remove_body(body);
  std::uint32_t weaker = from.first_arc;
  if (from.arcs == 1) {
    const std::uint32_t other = arcs_[weaker].to;
    bodies_[other].voxels += from.voxels;
    remove_joint(weaker / 2);
    remove_body(body);
    return list(other);
  }
  std::uint32_t stronger = arcs_[weaker].next;
  const auto& [a, b] = std::tie(joints_[weaker / 2], joints_[stronger / 2]);
  if (a.newtons > b.newtons || (a.newtons == b.newtons && a.place.layer < b.place.layer)) std::swap(weaker, stronger);
  const std::uint32_t other = arcs_[stronger].to;
  const std::uint32_t end = arcs_[weaker].to;
  bodies_[other].voxels += from.voxels;
  remove_joint(stronger / 2);
  unlink_arc(body, weaker);
  remove_body(body);
  link_arc(other, weaker);
  arcs_[weaker ^ 1U].to = other;
  joints_[weaker / 2].yields = true;
  join_parallel(other, end, weaker / 2);
}

/// @param joint  of bodies a and b, which may have another
void HoldNetwork::join_parallel(std::uint32_t a, std::uint32_t b, std::uint32_t joint) {
  if (bodies_[b].arcs < bodies_[a].arcs) std::swap(a, b);
  for (std::uint32_t arc = bodies_[a].first_arc; arc != kNone; arc = arcs_[arc].next) {
    if (arcs_[arc].to != b || arc / 2 == joint) continue;
    Joint& kept = joints_[joint];
    const Joint& other = joints_[arc / 2];
    if (other.newtons > kept.newtons) kept.place = other.place;
    kept.newtons += other.newtons;
    remove_joint(arc / 2);
    list(a);
    list(b);
    return;
  }
}

void HoldNetwork::begin_layer() {
  std::swap(ends_, below_);
  below_count_ = std::exchange(end_count_, 0);
}

bool HoldNetwork::add_end(std::span<const Link> links, double newtons, const Place& place, std::uint64_t voxels) {
  if (end_count_ == ends_.size()) return false;
  End& end = ends_[end_count_];
  end = {};
  if (links.size() == 1 && below_[links[0].end].links == 1) {
    const End& under = below_[links[0].end];
    if (bodies_[under.body].arcs == 1) {
      end = {.body = under.body, .holds = std::min(under.holds, links[0].newtons)};
      extend(end, links[0], place, voxels);
      below_[links[0].end].body = kNone;  // it is not the layer below's any more
      ++end_count_;
      return true;
    }
  }
  end.body = new_body(voxels);
  if (end.body == kNone) return false;
  if (links.empty()) {
    if (!new_joint(kPlate, end.body, {newtons, place, true})) return false;
    end.holds = newtons;
  }
  for (const Link& link : links) {
    const End& under = below_[link.end];
    const bool goes_on = links.size() == 1 && under.links == 1;
    if (!new_joint(under.body, end.body, {link.newtons, place, !goes_on})) return false;
    end.holds += std::min(link.newtons, under.holds * link.share);
  }
  ++end_count_;
  return true;
}

/// A region below which nothing else is, and which has nothing else below it: of such a chain only the weakest joint matters.
void HoldNetwork::extend(End& end, const Link& link, const Place& place, std::uint64_t voxels) {
  Body& body = bodies_[end.body];
  const std::uint32_t arc = body.first_arc;
  Joint& joint = joints_[arc / 2];
  if (link.newtons < joint.newtons || (joint.yields && link.newtons <= joint.newtons)) {
    bodies_[arcs_[arc].to].voxels += std::exchange(body.voxels, 0);
    joint = {link.newtons, place, false};
  }
  body.voxels += voxels;
}

void HoldNetwork::end_layer() {
  for (const End& end : below_.first(below_count_)) {
    if (end.body == kNone) continue;
    bodies_[end.body].is_end = false;
    list(end.body);
  }
  below_count_ = 0;
  reduce_listed();
}

void HoldNetwork::pull(std::span<const double> newtons,
                       FunctionRef<void(const Tear&, std::span<const std::uint32_t>)> on_tear) {
  bool all_hold = true;
  for (std::uint32_t i = 0; i < end_count_; ++i) {
    load_[i] = newtons[i];
    all_hold = all_hold && newtons[i] <= ends_[i].holds;
  }
  if (all_hold) return;
  // More than is asked first: if that holds, the next look is due when some load has grown as much.
  const auto hold = [&](auto target) {
    for (std::uint32_t i = 0; i < end_count_; ++i) rest_[i] = target(i);
    if (!carry_rest()) return false;
    for (std::uint32_t i = 0; i < end_count_; ++i) ends_[i].holds = target(i);
    return true;
  };
  if (hold([&](std::uint32_t i) { return newtons[i] <= ends_[i].holds ? ends_[i].holds : 4 * newtons[i]; })) return;
  if (hold([&](std::uint32_t i) { return 2 * newtons[i]; })) return;
  while (!hold([&](std::uint32_t i) { return load_[i]; })) {
    std::uint32_t worst = 0;
    while (rest_[worst] <= kNothing) ++worst;
    std::uint32_t torn_count = 0;
    const Tear tear = tear_from(ends_[worst].body, torn_count);
    on_tear(tear, torn_.first(torn_count));
  }
}

/// Sends rest_ to the plate, as far as the joints can carry it.
/// @returns whether all arrived; else rest_ has what did not
bool HoldNetwork::carry_rest() {
  for (Arc& arc : arcs_.first(2 * joint_count_)) arc.flow = 0;
  return carry(rest_.first(end_count_), [&](std::uint32_t i) { return ends_[i].body; });
}

/// Takes off the piece that a load which did not arrive can still reach.
HoldNetwork::Tear HoldNetwork::tear_from(std::uint32_t body, std::uint32_t& torn_count) {
  const auto piece = reach_from(body);
  Tear tear;
  double strongest = -1;
  for (const std::uint32_t here : piece) {
    tear.voxels += bodies_[here].voxels;
    for (std::uint32_t arc = bodies_[here].first_arc; arc != kNone; arc = bodies_[here].first_arc) {
      const Joint& joint = joints_[arc / 2];
      const std::uint32_t there = arcs_[arc].to;
      if (!reached(there)) {
        tear.held_n += joint.newtons;
        if (joint.newtons > strongest) {
          strongest = joint.newtons;
          tear.place = joint.place;
        }
        list(there);
      }
      remove_joint(arc / 2);
    }
    remove_body(here);
  }
  for (std::uint32_t i = 0; i < end_count_; ++i) {
    if (ends_[i].body == kNone || !reached(ends_[i].body)) continue;
    tear.asked_n += std::exchange(load_[i], 0);
    ends_[i].body = kNone;
    torn_[torn_count++] = i;
  }
  reduce_listed();
  return tear;
}

}  // namespace plumbline::inline slicer
