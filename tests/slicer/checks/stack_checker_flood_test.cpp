/// The checks against floods of the whole volume.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "slicer/checks/stack_checker.hpp"
#include "tests/slicer/checks/checked_stack.hpp"
#include "tests/slicer/support/hanging.hpp"
#include "tests/slicer/support/surfaces.hpp"

namespace plumbline {
namespace {

using namespace testing;

struct Place {
  int c, r, k;
};

/// A volume of marks, and floods in it.
class Volume {
 public:
  explicit Volume(const std::vector<Pixels>& masks)
      : masks_(masks),
        columns_(static_cast<int>(masks[0].columns())),
        rows_(static_cast<int>(masks[0].rows())),
        layers_(static_cast<int>(masks.size())),
        marks_(static_cast<std::size_t>(columns_ * rows_ * layers_), 0) {}

  bool inside(const Place& p) const {
    return p.c >= 0 && p.r >= 0 && p.k >= 0 && p.c < columns_ && p.r < rows_ && p.k < layers_;
  }
  bool white(const Place& p) const { return masks_[static_cast<std::size_t>(p.k)].at(p.c, p.r); }
  int& mark(const Place& p) { return marks_[static_cast<std::size_t>((p.k * rows_ + p.r) * columns_ + p.c)]; }
  bool at_border(const Place& p) const { return p.c == 0 || p.r == 0 || p.c == columns_ - 1 || p.r == rows_ - 1; }
  int layers() const { return layers_; }

  template <class Visit>
  void for_each(Visit visit) const {
    for (int k = 0; k < layers_; ++k) {
      for (int r = 0; r < rows_; ++r) {
        for (int c = 0; c < columns_; ++c) visit(Place{c, r, k});
      }
    }
  }

  /// Marks what is joined face to face with the marked places, in layers below `end`.
  void flood(std::vector<Place> open, int value, bool colour, int end) {
    while (!open.empty()) {
      const Place p = open.back();
      open.pop_back();
      for (const auto& [dc, dr, dk] : {std::array{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}) {
        const Place q{p.c + dc, p.r + dr, p.k + dk};
        if (!inside(q) || q.k >= end || white(q) != colour || mark(q) != 0) continue;
        mark(q) = value;
        open.push_back(q);
      }
    }
  }

 private:
  const std::vector<Pixels>& masks_;
  int columns_, rows_, layers_;
  std::vector<int> marks_;
};

/// Voxels of each resin trap: air that neither the sides, the top nor the plate's underside reach.
std::vector<std::uint64_t> traps_of(const std::vector<Pixels>& masks) {
  Volume volume(masks);
  std::vector<Place> open;
  volume.for_each([&](const Place& p) {
    const bool leads_out = volume.at_border(p) || p.k == 0 || p.k == volume.layers() - 1;
    if (volume.white(p) || !leads_out) return;
    volume.mark(p) = 1;
    open.push_back(p);
  });
  volume.flood(open, 1, false, volume.layers());
  std::vector<std::uint64_t> sizes;
  int next = 2;
  volume.for_each([&](const Place& p) {
    if (volume.white(p) || volume.mark(p) != 0) return;
    volume.mark(p) = next;
    volume.flood({p}, next++, false, volume.layers());
  });
  sizes.resize(static_cast<std::size_t>(next - 2));
  volume.for_each([&](const Place& p) {
    if (volume.mark(p) >= 2) ++sizes[static_cast<std::size_t>(volume.mark(p) - 2)];
  });
  return sizes;
}

/// Air of each layer that the sides don't reach through this layer and those below, all layers together, traps included.
std::uint64_t enclosed_while_printed(const std::vector<Pixels>& masks) {
  std::uint64_t sum = 0;
  for (int k = 0; k < static_cast<int>(masks.size()); ++k) {
    Volume volume(masks);
    std::vector<Place> open;
    volume.for_each([&](const Place& p) {
      if (p.k > k || volume.white(p) || !volume.at_border(p)) return;
      volume.mark(p) = 1;
      open.push_back(p);
    });
    volume.flood(open, 1, false, k + 1);
    volume.for_each([&](const Place& p) { sum += p.k == k && !volume.white(p) && volume.mark(p) == 0 ? 1 : 0; });
  }
  return sum;
}

/// What is joined to `start` at sides in `mask`, `start` itself left out where it is not white there.
Pixels joined_to(const Pixels& start, const Pixels& mask) {
  Pixels all(mask.columns(), mask.rows());
  std::vector<std::pair<std::int64_t, std::int64_t>> open;
  const auto add = [&](std::int64_t c, std::int64_t r) {
    if (!mask.at(c, r) || all.at(c, r)) return;
    all.set(static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(r), true);
    open.emplace_back(c, r);
  };
  for (std::uint32_t r = 0; r < mask.rows(); ++r) {
    for (std::uint32_t c = 0; c < mask.columns(); ++c) {
      if (start.at(c, r)) add(c, r);
    }
  }
  while (!open.empty()) {
    const auto [c, r] = open.back();
    open.pop_back();
    add(c + 1, r);
    add(c - 1, r);
    add(c, r + 1);
    add(c, r - 1);
  }
  return all;
}

/// Of two images of a size: where `a` is white and `b` is not.
Pixels less(const Pixels& a, const Pixels& b) {
  Pixels rest = a;
  for (std::uint32_t r = 0; r < a.rows(); ++r) {
    for (std::uint32_t c = 0; c < a.columns(); ++c) rest.set(c, r, a.at(c, r) && !b.at(c, r));
  }
  return rest;
}

struct Fallen {
  std::uint64_t voxels = 0;    ///< of regions of which nothing stays
  std::uint64_t shadowed = 0;  ///< of the others
};

/// Each layer keeps what gets light and touches a kept pixel below, itself or through its own layer. What gets light and is not kept
/// lies on the film, which is dark from then on.
Fallen what_falls(const std::vector<Pixels>& masks) {
  Fallen fallen;
  Pixels kept = masks[0];
  Pixels film(kept.columns(), kept.rows());
  for (std::size_t k = 1; k < masks.size(); ++k) {
    const Pixels lit = less(masks[k], film);
    kept = joined_to(kept, lit);
    for (std::uint32_t r = 0; r < film.rows(); ++r) {
      for (std::uint32_t c = 0; c < film.columns(); ++c) {
        if (lit.at(c, r) && !kept.at(c, r)) film.set(c, r, true);
      }
    }
    const Pixels held = joined_to(kept, masks[k]);
    fallen.voxels += masks[k].count() - held.count();
    fallen.shadowed += held.count() - kept.count();
  }
  return fallen;
}

std::vector<Pixels> random_stack(Random& random, std::uint32_t solid_of_16) {
  const std::uint32_t columns = 3 + random.below(90);
  const std::uint32_t rows = 3 + random.below(14);
  const std::uint32_t layers = 2 + random.below(9);
  std::vector<Pixels> masks(layers, Pixels(columns, rows));
  for (std::uint32_t k = 0; k < layers; ++k) {
    for (std::uint32_t r = 0; r < rows; ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        // Half of the pixels are those of the layer below, so that columns grow high.
        const bool as_below = k > 0 && random.below(2) == 0;
        masks[k].set(c, r, as_below ? masks[k - 1].at(c, r) : random.below(16) < solid_of_16);
      }
    }
  }
  return masks;
}

TEST(StackCheckerAgainstAFlood, FindsTheSameInRandomStacks) {
  Random random(26);
  CheckLimits limits = strict_limits();
  limits.island.held_divisor = 1U << 20U;  // only regions above nothing are islands
  limits.island.held_pixels = 0;
  std::uint64_t traps_seen = 0;
  std::uint64_t cups_seen = 0;
  std::uint64_t pieces_seen = 0;
  std::uint64_t shadow_seen = 0;
  for (int i = 0; i < 400; ++i) {
    const auto masks = random_stack(random, 2 + random.below(13));
    const StackFindings findings = check(masks, limits);
    std::uint64_t white = 0;
    for (const Pixels& mask : masks) white += mask.count();
    EXPECT_EQ(findings.voxels, white);
    EXPECT_EQ(findings.unchecked_layers, 0U);

    auto traps = traps_of(masks);
    std::sort(traps.rbegin(), traps.rend());
    const IssueGroup& found = findings.of(IssueKind::kResinTrap);
    EXPECT_EQ(found.count, traps.size());
    std::uint64_t in_traps = 0;
    for (const std::uint64_t trap : traps) in_traps += trap;
    EXPECT_EQ(found.voxels, in_traps);
    for (std::size_t t = 0; t < found.kept_count; ++t) EXPECT_EQ(found.kept[t].voxels, traps[t]);

    EXPECT_EQ(findings.of(IssueKind::kSuctionCup).voxels + in_traps, enclosed_while_printed(masks));
    const Fallen fallen = what_falls(masks);
    EXPECT_EQ(findings.of(IssueKind::kFreePiece).voxels, fallen.voxels);
    EXPECT_EQ(findings.shadowed_voxels, fallen.shadowed);
    traps_seen += traps.size();
    cups_seen += findings.count(IssueKind::kSuctionCup);
    pieces_seen += findings.count(IssueKind::kFreePiece);
    shadow_seen += fallen.shadowed;
    // An issue's place belongs to it.
    for (const IssueGroup& group : findings.groups) {
      for (const Issue& issue : group.all_kept()) {
        if (issue.kind == IssueKind::kEmptyLayer) continue;
        const bool air = issue.kind == IssueKind::kResinTrap || issue.kind == IssueKind::kSuctionCup ||
                         issue.kind == IssueKind::kPlateTrap;
        EXPECT_EQ(masks[issue.layer].at(issue.column, issue.row), !air) << words_of(issue.kind).key;
      }
    }
  }
  EXPECT_GT(traps_seen, 1000U);
  EXPECT_GT(cups_seen, 1000U);
  EXPECT_GT(pieces_seen, 1000U);
  EXPECT_GT(shadow_seen, 1000U);
}

TEST(StackCheckerAgainstAFlood, FindsTheIslandsOfUvtoolsRule) {
  Random random(27);
  const CheckLimits limits;  // no overhang of 40 pixels fits into these stacks
  std::uint32_t seen = 0;
  for (int i = 0; i < 300; ++i) {
    const auto masks = random_stack(random, 2 + random.below(13));
    std::uint32_t islands = 0;
    for (std::size_t k = 1; k < masks.size(); ++k) {
      Pixels done(masks[k].columns(), masks[k].rows());
      for (std::uint32_t r = 0; r < done.rows(); ++r) {
        for (std::uint32_t c = 0; c < done.columns(); ++c) {
          if (!masks[k].at(c, r) || done.at(c, r)) continue;
          std::vector<std::pair<std::int64_t, std::int64_t>> open{{c, r}};
          done.set(c, r, true);
          double area = 0;
          double held = 0;
          while (!open.empty()) {
            const auto [x, y] = open.back();
            open.pop_back();
            area += 1;
            held += masks[k - 1].at(x, y) ? 1 : 0;
            for (const auto& [nx, ny] :
                 {std::pair{x + 1, y}, std::pair{x - 1, y}, std::pair{x, y + 1}, std::pair{x, y - 1}}) {
              if (!masks[k].at(nx, ny) || done.at(nx, ny)) continue;
              done.set(static_cast<std::uint32_t>(nx), static_cast<std::uint32_t>(ny), true);
              open.emplace_back(nx, ny);
            }
          }
          const double required = std::max(1.0, 0.25 * area);
          if (held >= required) continue;
          if (held >= 10 && held >= required / 4) continue;
          ++islands;
        }
      }
    }
    EXPECT_EQ(check(masks, limits).count(IssueKind::kIsland), islands);
    seen += islands;
  }
  EXPECT_GT(seen, 1000U);
}

TEST(StackCheckerAgainstAFlood, FindsNoIslandWhereTheOtherFinderFindsNone) {
  Random random(28);
  CheckLimits limits = strict_limits();
  limits.island.held_divisor = 1U << 20U;
  limits.island.held_pixels = 0;
  for (int i = 0; i < 200; ++i) {
    const auto masks = random_stack(random, 2 + random.below(13));
    EXPECT_EQ(check(masks, limits).count(IssueKind::kIsland), floating_islands(masks));
  }
}

}  // namespace
}  // namespace plumbline
