#include "slicer/mesh/open/open_edges.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "slicer/core/numbers/mix64.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "mesh";
constexpr std::size_t kFewestSlots = 1U << 10U;

std::uint64_t hash_of(const OpenEdge& edge) {
  const auto word = [](std::int32_t i) { return std::uint64_t{static_cast<std::uint32_t>(i)}; };
  const auto of = [&](const LatticePoint& p) { return (word(p.x) | word(p.y) << 32U) + word(p.z) * kGoldenStep64; };
  return mix64(of(edge.low) * kGoldenStep64 + of(edge.high));
}

/// An edge of a triangle, with +1 or -1 as its surplus; 0: it has no length.
OpenEdge edge_between(const LatticePoint& from, const LatticePoint& to) {
  if (from == to) return {};
  return from < to ? OpenEdge{.low = from, .high = to, .surplus = 1} : OpenEdge{.low = to, .high = from, .surplus = -1};
}

/// Of length 1; 0 of a triangle without area.
Vec3f normal_of(const LatticeTriangle& t, const Vec3d& steps) {
  const auto from_first = [&](const LatticePoint& p) {
    return Vec3d(steps[0] * (double{1} * p.x - t[0].x), steps[1] * (double{1} * p.y - t[0].y),
                 steps[2] * (double{1} * p.z - t[0].z));
  };
  const Vec3d directed = from_first(t[1]).cross(from_first(t[2]));
  const double area = std::sqrt(directed.dot(directed));
  return area > 0 ? Vec3f((directed / area).cast<float>()) : Vec3f::Zero();
}

template <class Visit>
void for_each_edge(const LatticeTriangle& triangle, Visit visit) {
  for (std::size_t i = 0; i < 3; ++i) visit(edge_between(triangle[i], triangle[(i + 1) % 3]));
}

}  // namespace

Expected<OpenEdges> OpenEdges::create(Arena& arena) {
  OpenEdges edges;
  edges.arena_ = &arena;
  edges.mark_ = arena.bottom_mark();
  edges.most_ = arena.available() / 4 / sizeof(OpenEdge);
  const auto slots = arena.take_bottom<OpenEdge>(kFewestSlots, kStage);
  PLUMBLINE_TRY(slots);
  std::ranges::fill(*slots, OpenEdge{});
  edges.slots_ = *slots;
  return edges;
}

/// The slot where the search for an edge begins.
std::size_t OpenEdges::slot_of(const OpenEdge& edge) const {
  return static_cast<std::size_t>(hash_of(edge)) & (slots_.size() - 1);
}

/// The slot of an edge, or the empty one where it belongs.
std::size_t OpenEdges::find(const OpenEdge& edge) const {
  std::size_t slot = slot_of(edge);
  while (slots_[slot].surplus != 0 && !(slots_[slot].low == edge.low && slots_[slot].high == edge.high)) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slot;
}

/// Empties a slot, and moves those up that a search would no longer reach (Knuth, vol. 3, algorithm 6.4 R).
void OpenEdges::remove(std::size_t slot) {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t next = (slot + 1) & mask; slots_[next].surplus != 0; next = (next + 1) & mask) {
    const std::size_t home = slot_of(slots_[next]);
    if (((next - home) & mask) < ((next - slot) & mask)) continue;
    slots_[slot] = slots_[next];
    slot = next;
  }
  slots_[slot] = {};
  --used_;
}

/// Doubles the table in place. An edge's new slot is at most as far from its home as the old one was, or as far in the new half. So
/// no edge meets one that has not been moved, if the first one to move lies behind an empty slot.
Status OpenEdges::grow() {
  const std::size_t half = slots_.size();
  full_ = 2 * half > most_;
  if (full_) return {};
  std::size_t empty = 0;
  while (slots_[empty].surplus != 0) ++empty;
  arena_->release_bottom(mark_);
  const auto doubled = arena_->take_bottom<OpenEdge>(2 * half, kStage);
  PLUMBLINE_TRY(doubled);
  slots_ = *doubled;
  std::ranges::fill(slots_.subspan(half), OpenEdge{});
  for (std::size_t i = 1; i < half; ++i) {
    const OpenEdge edge = std::exchange(slots_[(empty + i) % half], OpenEdge{});
    if (edge.surplus != 0) slots_[find(edge)] = edge;
  }
  return {};
}

/// Moves all edges to a smaller table.
Status OpenEdges::shrink(std::size_t slots) {
  const std::span<OpenEdge> old = slots_;
  // The new table is filled above the old one, then moved down to its place.
  const auto above = arena_->take_bottom<OpenEdge>(slots, kStage);
  PLUMBLINE_TRY(above);
  slots_ = *above;
  std::ranges::fill(slots_, OpenEdge{});
  for (const OpenEdge& edge : old) {
    if (edge.surplus != 0) slots_[find(edge)] = edge;
  }
  arena_->release_bottom(mark_);
  const auto moved = arena_->take_bottom<OpenEdge>(slots, kStage);
  PLUMBLINE_TRY(moved);
  std::copy(slots_.begin(), slots_.end(), moved->begin());
  slots_ = *moved;
  return {};
}

Status OpenEdges::begin_users() {
  const std::size_t enough = std::max(kFewestSlots, std::bit_ceil(2 * std::size_t{used_}));
  if (enough < slots_.size()) PLUMBLINE_TRY(shrink(enough));
  const auto users = arena_->take_bottom<EdgeUsers>(slots_.size(), kStage);
  PLUMBLINE_TRY(users);
  std::ranges::fill(*users, EdgeUsers{});
  users_ = *users;
  return {};
}

Status OpenEdges::add(const LatticeTriangle& triangle) {
  if (4 * (used_ + std::size_t{3}) > 3 * slots_.size()) PLUMBLINE_TRY(grow());
  if (full_) return {};
  for_each_edge(triangle, [&](const OpenEdge& edge) {
    if (edge.surplus == 0) return;
    const std::size_t slot = find(edge);
    OpenEdge& kept = slots_[slot];
    if (kept.surplus == 0) {
      kept = edge;
      ++used_;
    } else if (kept.surplus + edge.surplus == 0) {
      remove(slot);
    } else {
      kept.surplus += edge.surplus;
    }
  });
  return {};
}

void OpenEdges::add_user(const LatticeTriangle& triangle, std::uint64_t number, const Vec3d& steps) {
  for_each_edge(triangle, [&](const OpenEdge& edge) {
    if (edge.surplus == 0) return;
    const std::size_t slot = find(edge);
    if (slots_[slot].surplus == 0) return;
    users_[slot].numbers += static_cast<std::uint32_t>(mix64(number + 1));
    users_[slot].outward += normal_of(triangle, steps);
  });
}

std::uint64_t OpenEdges::runs() const {
  std::uint64_t sum = 0;
  for (const OpenEdge& edge : slots_) sum += static_cast<std::uint64_t>(std::abs(edge.surplus));
  return sum;
}

}  // namespace plumbline::inline slicer
