#include "slicer/mesh/shells.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "mesh";
/// Different faces of an edge, at most: more are not joined over it.
constexpr std::size_t kMostFaces = 32;
/// Shells on one ray, at most: a ray through more is not asked.
constexpr std::size_t kMostOnRay = 128;
/// Of all hits of a shell: if votes are fewer, its faces had no side.
constexpr std::int64_t kClearVote = 8;
/// Of all hits: so many may cancel in a mesh of which nothing is there twice.
constexpr std::size_t kFewCancelled = 20;

/// The shells that a ray passes.
class RayShells {
 public:
  struct Entry {
    std::uint32_t shell = 0;
    int sum = 0;  ///< of all hits: 0 if the shell is closed on the ray
    int winding = 0;
    int before = 0;     ///< winding before the layer that is looked at
    bool here = false;  ///< it has a hit in that layer
    std::int64_t volume = 0;
    bool is_around() const { return sum == 0 && (before != 0 || winding != 0); }
  };

  RayShells(std::span<const PackedHit> hits, const HitPacking& packing) {
    for (const PackedHit& hit : hits) {
      Entry* const entry = find(hit.body());
      if (entry == nullptr) return;
      entry->sum += packing.winding(hit);
      entry->volume -= packing.winding(hit) * std::int64_t{packing.layer(hit)};
    }
  }
  bool is_full() const { return full_; }
  Entry* find(std::uint32_t shell) {
    const auto used = entries();
    const auto at = std::ranges::find(used, shell, &Entry::shell);
    if (at != used.end()) return &*at;
    full_ = count_ == entries_.size();
    if (full_) return nullptr;
    entries_[count_] = {};
    entries_[count_].shell = shell;
    return &entries_[count_++];
  }
  std::span<Entry> entries() { return std::span(entries_).first(count_); }

 private:
  std::array<Entry, kMostOnRay> entries_;
  std::size_t count_ = 0;
  bool full_ = false;
};

std::int64_t size_of(const Shell& shell) { return std::abs(shell.volume); }

/// Keeps of the shells around one those that are around it here, too.
void look_around(std::span<Shell> shells, std::uint32_t looking, RayShells& ray) {
  Shell& shell = shells[looking];
  const auto is_around = [&](const RayShells::Entry& entry) {
    const Shell& other = shells[entry.shell];
    return entry.is_around() && other.body == shell.body && size_of(other) > size_of(shell);
  };
  if (shell.seen) {
    std::uint8_t kept = 0;
    for (std::uint8_t i = 0; i < shell.count; ++i) {
      const auto entries = ray.entries();
      const auto at = std::ranges::find(entries, shell.around[i], &RayShells::Entry::shell);
      if (at != entries.end() && is_around(*at)) shell.around[kept++] = shell.around[i];
    }
    shell.count = kept;
    return;
  }
  shell.seen = true;
  for (const RayShells::Entry& entry : ray.entries()) {
    if (!is_around(entry)) continue;
    if (shell.count < shell.around.size()) {
      shell.around[shell.count++] = entry.shell;
      continue;
    }
    const auto largest =
        std::ranges::max_element(shell.around, {}, [&](std::uint32_t s) { return size_of(shells[s]); });
    if (size_of(shells[entry.shell]) < size_of(shells[*largest])) *largest = entry.shell;
  }
}

void find_shells_around(const HitList& hits, std::span<Shell> shells) {
  const HitPacking packing = hits.packing();
  hits.for_each_ray([&](std::span<const PackedHit> all) {
    RayShells ray(all, packing);
    if (ray.is_full()) return;
    for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
      for (RayShells::Entry& entry : ray.entries()) {
        entry.before = entry.winding;
        entry.here = false;
      }
      for (; end < all.size() && packing.layer(all[end]) == packing.layer(all[begin]); ++end) {
        RayShells::Entry& entry = *ray.find(all[end].body());
        entry.winding += packing.winding(all[end]);
        entry.here = true;
      }
      for (const RayShells::Entry& entry : ray.entries()) {
        if (entry.here) look_around(shells, entry.shell, ray);
      }
    }
  });
}

}  // namespace

std::size_t ShellJoiner::bytes_needed(std::uint64_t triangles) {
  const auto count = static_cast<std::size_t>(triangles);
  return Arena::rounded(count * sizeof(std::uint32_t)) + Arena::rounded(count);
}

Expected<ShellJoiner> ShellJoiner::create(std::uint64_t triangles, Arena& arena) {
  ShellJoiner joiner;
  const auto count = static_cast<std::size_t>(triangles);
  PLUMBLINE_TRY(arena.take_bottom(joiner.links_, count, kStage));
  PLUMBLINE_TRY(arena.take_bottom(joiner.marks_, count, kStage));
  for (std::size_t i = 0; i < count; ++i) joiner.links_[i] = static_cast<std::uint32_t>(i) << 1U;
  std::ranges::fill(joiner.marks_, std::uint8_t{0});
  return joiner;
}

/// Roots are the first triangles of their shells. Paths are halved, so that they stay short.
ShellJoiner::Root ShellJoiner::find(std::uint32_t triangle) {
  std::uint32_t turned = 0;
  for (;;) {
    const std::uint32_t link = links_[triangle];
    const std::uint32_t parent = link >> 1U;
    if (parent == triangle) return {triangle, turned};
    const std::uint32_t next = links_[parent];
    links_[triangle] = next ^ (link & 1U);
    turned ^= links_[triangle] & 1U;
    triangle = next >> 1U;
  }
}

/// @param turned  1 if one of the two is turned over relative to the other
void ShellJoiner::link(std::uint32_t a, std::uint32_t b, std::uint32_t turned) {
  Root first = find(a);
  Root second = find(b);
  if (first.triangle == second.triangle) return;  // a surface with one side only stays as it is
  if (first.triangle > second.triangle) std::swap(first, second);
  links_[second.triangle] = first.triangle << 1U | (first.turned ^ second.turned ^ turned);
}

void ShellJoiner::join(std::span<EdgeUse> uses, bool others) {
  std::sort(uses.begin(), uses.end());
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && uses[end].edge == uses[begin].edge) ++end;
    join_edge(uses.subspan(begin, end - begin), others);
  }
}

void ShellJoiner::join_edge(std::span<const EdgeUse> uses, bool others) {
  // Of each face its first triangle: of those that are there an odd number of times, and of the others.
  std::array<std::uint32_t, kMostFaces> single;
  std::array<std::uint32_t, kMostFaces> even;
  std::size_t singles = 0;
  std::size_t evens = 0;
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && uses[end].face == uses[begin].face) ++end;
    const std::uint32_t first = uses[begin].use;
    for (std::size_t i = begin + 1; i < end && !others; ++i) {
      marks_[uses[i].use >> 1U] |= kCopy;
      link(first >> 1U, uses[i].use >> 1U, (first ^ uses[i].use) & 1U);
    }
    if (singles == kMostFaces || evens == kMostFaces) return;
    if ((end - begin) % 2 == 1) {
      single[singles++] = first;
    } else {
      even[evens++] = first;
      marks_[first >> 1U] |= kEven;
    }
  }
  const auto join_two = [&](std::uint32_t a, std::uint32_t b) { link(a >> 1U, b >> 1U, (~(a ^ b)) & 1U); };
  if (others) {
    if (singles > 2) join_rest(std::span(single).first(singles));
    return;
  }
  has_others_ |= singles > 2;
  if (singles == 2) join_two(single[0], single[1]);
  if (singles == 0 && evens == 2) join_two(even[0], even[1]);
  if (singles % 2 == 1 && evens == 1) {
    if (singles == 1) join_two(single[0], even[0]);
    marks_[even[0] >> 1U] |= kNeeded;
  } else if (singles > 0 && singles % 2 == 0) {
    for (std::size_t i = 0; i < evens; ++i) marks_[even[i] >> 1U] |= kNotNeeded;
  }
}

/// Joins what is not closed by itself along an edge of more than two faces: so that it is closed, if two pieces are left; else with the
/// sides that the faces had, if it is closed with these.
void ShellJoiner::join_rest(std::span<const std::uint32_t> singles) {
  std::array<Root, kMostFaces> root;
  std::array<std::uint32_t, kMostFaces> left;
  std::size_t count = 0;
  for (std::size_t i = 0; i < singles.size(); ++i) root[i] = find(singles[i] >> 1U);
  int as_they_were = 0;
  for (std::size_t i = 0; i < singles.size(); ++i) {
    int sum = 0;
    bool first = true;
    for (std::size_t k = 0; k < singles.size(); ++k) {
      if (root[k].triangle != root[i].triangle) continue;
      first &= k >= i;
      sum += ((singles[k] ^ root[k].turned) & 1U) != 0 ? -1 : 1;
    }
    if (sum == 0) continue;
    as_they_were += (singles[i] & 1U) != 0 ? -1 : 1;
    if (!first) continue;
    left[count++] = singles[i];
  }
  if (count == 2) {
    link(left[0] >> 1U, left[1] >> 1U, (~(left[0] ^ left[1])) & 1U);
  } else if (as_they_were == 0) {
    for (std::size_t i = 1; i < count; ++i) link(left[0] >> 1U, left[i] >> 1U, 0);
  }
}

std::uint32_t ShellJoiner::number() {
  for (std::uint32_t i = 0; i < links_.size(); ++i) {
    const Root root = find(i);
    links_[i] = root.triangle << 1U | root.turned;
  }
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < links_.size(); ++i) {
    const std::uint32_t root = links_[i] >> 1U;  // it has its number already, unless it is this one
    const std::uint32_t shell = root == i ? count++ : links_[root] >> 1U;
    links_[i] = shell << 1U | (links_[i] & 1U);
  }
  return count;
}

ShellJoiner::Side ShellJoiner::of(std::size_t triangle) const {
  const std::uint8_t mark = marks_[triangle];
  return {links_[triangle] >> 1U, (links_[triangle] & 1U) != 0, (mark & (kCopy | kCancelled)) != 0,
          (mark & kEven) != 0};
}

void ShellJoiner::drop_cancelled(std::span<std::int32_t> balance) {
  std::ranges::fill(balance, 0);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if ((marks_[i] & kNeeded) != 0) ++balance[links_[i] >> 1U];
    if ((marks_[i] & kNotNeeded) != 0) --balance[links_[i] >> 1U];
  }
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if ((marks_[i] & kEven) != 0 && balance[links_[i] >> 1U] < 0) marks_[i] |= kCancelled;
  }
}

Expected<TriangleSides> TriangleSides::create(std::uint64_t triangles, Arena& arena) {
  TriangleSides sides;
  PLUMBLINE_TRY(arena.take_top(sides.words_, words(triangles), kStage));
  std::ranges::fill(sides.words_, 0);
  return sides;
}

bool has_doubtful_sides(const HitList& hits) {
  const HitPacking packing = hits.packing();
  bool over = false;
  bool under = false;
  std::size_t cancelled = 0;
  hits.for_each_ray([&](std::span<const PackedHit> ray) {
    int winding = 0;
    for (std::size_t begin = 0, end = 0; begin < ray.size(); begin = end) {
      int change = 0;
      for (; end < ray.size() && packing.layer(ray[end]) == packing.layer(ray[begin]); ++end) {
        change += packing.winding(ray[end]);
      }
      winding += change;
      cancelled += end - begin - static_cast<std::size_t>(std::abs(change));
      over |= winding > 0;
      under |= winding < 0;
    }
  });
  return (over && under) || kFewCancelled * cancelled > hits.size();
}

void orient_shells(const HitList& hits, std::span<Shell> shells, std::span<std::uint32_t> order) {
  const HitPacking packing = hits.packing();
  hits.for_each_ray([&](std::span<const PackedHit> all) {
    RayShells ray(all, packing);
    for (const RayShells::Entry& entry : ray.entries()) {
      if (entry.sum == 0 && !ray.is_full()) shells[entry.shell].volume += entry.volume;
    }
  });
  find_shells_around(hits, shells);
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return size_of(shells[a]) != size_of(shells[b]) ? size_of(shells[a]) > size_of(shells[b]) : a < b;
  });
  // From the largest one: what is around a shell has been decided before it.
  for (const std::uint32_t i : order) {
    Shell& shell = shells[i];
    const auto around = std::span(shell.around).first(shell.count);
    const auto smallest = std::ranges::min_element(around, {}, [&](std::uint32_t s) { return size_of(shells[s]); });
    const bool apart = smallest == around.end();
    const std::int64_t outside = apart ? 0 : shells[*smallest].inside;
    const bool clear = kClearVote * std::abs(shell.votes) >= static_cast<std::int64_t>(shell.hits);
    const bool faced_out = (shell.volume >= 0) == (shell.votes >= 0);
    bool faces_out = apart ? faced_out : faced_out != shells[*smallest].reversed;
    if (outside <= 0 || !clear) faces_out = outside <= 0;
    shell.turns = faces_out != (shell.volume >= 0);
    shell.reversed = clear && faces_out != faced_out;
    shell.inside = outside + (faces_out ? 1 : -1);
  }
}

}  // namespace plumbline::inline slicer
