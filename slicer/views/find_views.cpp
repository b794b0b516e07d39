#include "slicer/views/find_views.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/views/patch_grids.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

/// Radii of patches, in spacings, tried from the smallest. That one holds 4072 evenly spread points, about as many as a
/// patch takes. The larger ones are for places where other views have taken most points.
constexpr std::array<float, 3> kPatchRadii = {36, 50, 70};

// Limits of the search. They trade time for small views that may be missed.
constexpr std::uint32_t kMaxSeeds = 400;         ///< patches in all
constexpr std::uint32_t kMaxFailedPatches = 16;  ///< patches in a row that show no view
constexpr std::uint32_t kMaxFailedEarly = 40;    ///< the same while many points belong to no view
constexpr double kManyPoints = 0.25;             ///< share of the scan's points
constexpr std::uint32_t kMaxFailedFirst = 6;     ///< the same while nothing tells that the scan is made of views
constexpr std::uint32_t kMaxFailedPairs = 16;    ///< pairs of peaks of one patch that turn out not to be a grid
constexpr std::uint32_t kJudgedViews = 8;        ///< the first views, which tell whether the scan is made of views

// Least number of points of a view. Fewer may lie on a grid by chance, and hardly determine the view's position.
constexpr std::uint32_t kMinViewPoints = 400;
constexpr std::uint32_t kMinViewShare = 500;  ///< or 1 / kMinViewShare of the scan's points
constexpr std::uint32_t kRoughly = 4;         ///< less than 1 / kRoughly of that in some blocks of the cloud is too few

// A grid that is known only to a coarse tolerance is grown again from other places.
constexpr std::uint32_t kMaxRestarts = 5;
constexpr std::uint32_t kMaxVainRestarts = 2;  ///< restarts in a row that find hardly more points
constexpr std::uint32_t kHardlyMore = 64;      ///< less than 1 / kHardlyMore more
constexpr float kRestartRadius = 50;           ///< spacings; that of a middle-sized patch
constexpr double kFine = 0.01;                 ///< pixels: a well-found grid has a tolerance up to this

constexpr std::uint32_t kBlock = 128;      ///< points whose distances are measured together; places fit a byte
constexpr std::uint32_t kCounted = 65536;  ///< points that are enough to compare two grids by

constexpr double kSearched = 0.8;  ///< progress when the search ends, 0 to 1

class ViewFinder {
 public:
  ViewFinder(const Cloud& cloud, const KdTree3& tree, float spacing, std::span<std::uint8_t> view_of)
      : cloud_(cloud),
        tree_(tree),
        spacing_(spacing),
        view_of_(view_of),
        thinning_(std::max(1U, cloud.size / kCounted)) {}

  Expected<FoundViews> run(Arena& arena, const StageProgress& progress) {
    const ArenaScope scope(arena);
    std::fill(view_of_.begin(), view_of_.end(), kNoView);
    auto patch = PatchGrids::create(cloud_, tree_, view_of_, spacing_, arena);
    PLUMBLINE_TRY(patch);
    auto growth = GridGrowth::create(cloud_, tree_, view_of_, arena);
    PLUMBLINE_TRY(growth);
    PLUMBLINE_TRY(arena.take_top(grids_, kMaxViews, kStage));
    growth_ = *growth;
    if (!search(*patch, progress.part(0, kSearched))) return cancelled();
    if (!is_made_of_views()) {
      std::fill(view_of_.begin(), view_of_.end(), kNoView);
      return FoundViews{};
    }
    if (!refine(progress.part(kSearched, 1))) return cancelled();
    FoundViews found;
    found.count = views_;
    found.points = assign_points();
    for (std::uint32_t v = 0; v < views_; ++v) found.grids[v] = grids_[v].grid;
    return found;
  }

 private:
  static tl::unexpected<Error> cancelled() {
    return fail(ErrorCode::kCancelled, "cancelled while views were looked for");
  }

  bool search(PatchGrids& patch, const StageProgress& progress) {
    std::uint32_t failures = 0;
    std::uint64_t seed = 0;
    double done = 0;
    const auto claimed = [&] { return static_cast<double>(claimed_) / cloud_.size; };
    const auto most_failures = [&] {
      if (views_ == 0 || !is_made_of_views()) return kMaxFailedFirst;
      return claimed() < 1 - kManyPoints ? kMaxFailedEarly : kMaxFailedPatches;
    };
    for (std::uint32_t s = 0; s < kMaxSeeds && failures < most_failures() && views_ < kMaxViews; ++s) {
      done = std::max({done, claimed(), 1.0 * failures / most_failures()});
      if (!progress.advance(done)) return false;
      seed += kGoldenStep64;  // spreads any number of seeds evenly
      const auto i = static_cast<std::uint32_t>((seed >> 32U) * cloud_.size >> 32U);
      if (view_of_[i] != kNoView) continue;
      const std::uint32_t before = views_;
      search_around(i, patch);
      failures = views_ > before ? 0 : failures + 1;
      if (!is_made_of_views() && views_ >= kJudgedViews) break;
    }
    return true;
  }

  /// Searches patches around a point, larger ones while they have few points and show no grid.
  void search_around(std::uint32_t seed, PatchGrids& patch) {
    const std::uint32_t before = views_;
    for (const float radius : kPatchRadii) {
      if (!patch.take(seed, radius * spacing_)) continue;
      search_patch(patch);
      if (views_ > before || patch.is_full()) return;
    }
  }

  void search_patch(const PatchGrids& patch) {
    std::uint32_t failures = 0;
    for (std::size_t a = 0; a < patch.peaks(); ++a) {
      for (std::size_t b = a + 1; b < patch.peaks() && views_ < kMaxViews && failures < kMaxFailedPairs; ++b) {
        const auto start = patch.grid(a, b);
        if (!start) continue;
        const auto grown = growth_->grow(*start, static_cast<double>(patch.radius()), patch.points());
        if (grown && claim(views_, *grown)) {
          if (views_ < kJudgedViews) facing_ += count_facing(views_);
          ++views_;
        } else {
          ++failures;
        }
      }
    }
  }

  /// Gives the free points on a grid to `view`, if there are enough of them.
  bool claim(std::uint32_t view, const GrownGrid& grid) {
    const std::uint32_t least = std::max(kMinViewPoints, cloud_.size / kMinViewShare);
    // Most grids that fail are those of views that have their points already: a part of the blocks tells.
    if (count_free_on(grid) * thinning_ < least / kRoughly) return false;
    std::uint32_t count = 0;
#pragma omp parallel for schedule(static) reduction(+ : count)
    for (std::uint32_t first = 0; first < cloud_.size; first += kBlock) {
      count += claim_block(static_cast<std::uint8_t>(view), grid, first);
    }
    if (count < least) {
      relabel(view, kNoView);
      return false;
    }
    claimed_ += count;
    grids_[view] = grid;
    radial_ += count * grid.grid.lens.radial[0];
    growth_->expect_lens(radial_ / static_cast<double>(claimed_));
    return true;
  }

  /// Points of a view whose surface was seen from the front, less those where it was seen from behind. In a camera's
  /// view the second kind are on its grid by chance. Points on a lattice are as often one as the other.
  std::uint64_t count_facing(std::uint32_t view) const {
    std::int64_t sum = 0;
#pragma omp parallel for schedule(static) reduction(+ : sum)
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (view_of_[i] != view) continue;
      const Vec3d ray = grids_[view].grid.ray(cloud_.position[i]);
      sum += ray.dot(cloud_.normal[i].unpack().cast<double>()) > 0 ? 1 : -1;
    }
    return static_cast<std::uint64_t>(std::abs(sum));
  }
  /// Whether the first views are as large as those of a scan that is made of kMaxViews views at most.
  bool is_made_of_views() const {
    return facing_ * kMaxViews >= std::uint64_t{std::min(views_, kJudgedViews)} * cloud_.size;
  }

  std::span<std::uint8_t> views_of_block(std::uint32_t first) const {
    return view_of_.subspan(first, std::min(kBlock, cloud_.size - first));
  }
  /// Finds the points of a view that lie on a grid, in the block that begins with point `first`. Measures only those of the view:
  /// while one of many views is looked for, that is most of the saving.
  /// @param on  out: their places in the block, ascending
  /// @returns how many they are
  std::uint32_t find_on(const GrownGrid& grid, std::uint32_t view, std::uint32_t first,
                        std::array<std::uint8_t, kBlock>& on) const {
    const auto of = views_of_block(first);
    if (std::memchr(of.data(), static_cast<int>(view), of.size()) == nullptr) return 0;
    std::uint32_t size = 0;
    for (std::uint32_t k = 0; k < of.size(); ++k) {  // without a branch, as below
      on[size] = static_cast<std::uint8_t>(k);
      size += of[k] == view ? 1 : 0;
    }
    std::array<Vec3f, kBlock> position;
    for (std::uint32_t n = 0; n < size; ++n) position[n] = cloud_.position[first + on[n]];
    std::array<float, kBlock> distances2;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    distances2_within(grid.grid, grid.radius, std::span(position).first(size), distances2);
    const auto most = static_cast<float>(grid.tolerance * grid.tolerance);
    std::uint32_t count = 0;
    for (std::uint32_t n = 0; n < size; ++n) {
      on[count] = on[n];
      count += distances2[n] <= most ? 1 : 0;
    }
    return count;
  }
  /// Gives the free points on a grid to `view`, in the block that begins with point `first`.
  std::uint32_t claim_block(std::uint8_t view, const GrownGrid& grid, std::uint32_t first) {
    std::array<std::uint8_t, kBlock> on;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const std::uint32_t count = find_on(grid, kNoView, first, on);
    for (const std::uint8_t k : std::span(on).first(count)) view_of_[first + k] = view;
    return count;
  }
  /// Calls `use` for each point of a view that lies on a grid, among every `thinning_`-th block of the cloud.
  template <class Use>
  void for_each_on(const GrownGrid& grid, std::uint32_t view, Use use) const {
    std::array<std::uint8_t, kBlock> on;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    for (std::uint32_t first = 0; first < cloud_.size; first += thinning_ * kBlock) {
      const std::uint32_t count = find_on(grid, view, first, on);
      for (const std::uint8_t k : std::span(on).first(count)) use(first + k);
    }
  }
  /// How many free points for_each_on() would use.
  std::uint32_t count_free_on(const GrownGrid& grid) const {
    std::uint32_t sum = 0;
#pragma omp parallel for schedule(static) reduction(+ : sum)
    for (std::uint32_t first = 0; first < cloud_.size; first += thinning_ * kBlock) {
      std::array<std::uint8_t, kBlock> on;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      sum += find_on(grid, kNoView, first, on);
    }
    return sum;
  }

  void relabel(std::uint32_t from, std::uint32_t to) {
    // Without a branch, unlike std::replace().
#pragma omp parallel for schedule(static)
    for (std::uint32_t first = 0; first < cloud_.size; first += kBlock) {
      for (std::uint8_t& v : views_of_block(first)) v = v == from ? static_cast<std::uint8_t>(to) : v;
    }
  }

  /// Grows each view again without the points of all others, and joins parts of one view.
  bool refine(const StageProgress& progress) {
    for (std::uint32_t v = 0; v < views_; ++v) {
      if (!progress.advance(1.0 * v / views_)) return false;
      grow_again(v);
    }
    for (std::uint32_t v = 0; v < views_; ++v) {
      const std::uint32_t before = views_;
      ViewPoints points = count_on_each(grids_[v]);
      for (std::uint32_t w = 0; w < views_;) {
        if (w == v || points.on[w] * 2 <= points.all[w]) {
          ++w;
          continue;
        }
        remove(w);
        points.on[w] = points.on[views_];
        points.all[w] = points.all[views_];
        if (v == views_) v = w;
      }
      if (views_ < before) grow_again(v);
    }
    return true;
  }

  /// Of each view, in every `thinning_`-th block of the cloud: its points, and those of them that lie on a grid.
  struct ViewPoints {
    std::array<std::uint32_t, kNoView + 1> all = {}, on = {};
  };
  ViewPoints count_on_each(const GrownGrid& grid) const {
    ViewPoints points;
    const auto most = static_cast<float>(grid.tolerance * grid.tolerance);
    std::uint32_t* const all = points.all.data();
    std::uint32_t* const on = points.on.data();
#pragma omp parallel for schedule(static) reduction(+ : all[:kNoView + 1], on[:kNoView + 1])
    for (std::uint32_t first = 0; first < cloud_.size; first += thinning_ * kBlock) {
      const auto of = views_of_block(first);
      std::array<float, kBlock> distances2;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      distances2_within(grid.grid, grid.radius, cloud_.positions().subspan(first, of.size()), distances2);
      for (std::size_t k = 0; k < of.size(); ++k) {
        ++all[of[k]];
        on[of[k]] += distances2[k] <= most ? 1 : 0;
      }
    }
    return points;
  }

  /// Removes a view. The last view takes over its number.
  void remove(std::uint32_t view) {
    relabel(view, kNoView);
    --views_;
    if (view == views_) return;
    grids_[view] = grids_[views_];
    relabel(views_, view);
  }

  void grow_again(std::uint32_t view) {
    relabel(view, kNoView);
    GrownGrid best = grids_[view];
    std::uint32_t most = count_free_on(best);
    const auto try_from = [&](const ViewGrid& grid, double radius) {
      const auto grown = growth_->grow(grid, radius);
      if (!grown) return;
      const std::uint32_t count = count_free_on(*grown);
      if (count <= most) return;
      most = count;
      best = *grown;
    };
    try_from(best.grid, best.radius);
    // A grid fitted to flat faces alone may be off by whole pixels between them. Growing it from another place corrects
    // that.
    std::uint32_t vain = 0;
    for (std::uint32_t k = 1; k <= kMaxRestarts && vain < kMaxVainRestarts && best.tolerance > kFine; ++k) {
      const std::uint32_t before = most;
      std::uint32_t left = most * k / (kMaxRestarts + 1);
      std::uint32_t start = cloud_.size;
      for_each_on(best, kNoView, [&](std::uint32_t i) {
        if (left-- == 0) start = i;
      });
      if (start == cloud_.size) break;
      try_from(best.grid.around(cloud_.position[start]), static_cast<double>(kRestartRadius * spacing_));
      vain = most - before < before / kHardlyMore ? vain + 1 : 0;
    }
    if (!claim(view, best)) grids_[view].tolerance = 0;
  }

  /// Gives each point to the view whose grid is nearest, whichever view was found first.
  /// @returns the number of points that have a view
  std::uint32_t assign_points() {
    std::uint32_t points = 0;
#pragma omp parallel for schedule(static) reduction(+ : points)
    for (std::uint32_t first = 0; first < cloud_.size; first += kBlock) {
      const std::uint32_t size = std::min(kBlock, cloud_.size - first);
      std::array<float, kBlock> distances2;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      std::array<float, kBlock> least;       // NOLINT(cppcoreguidelines-pro-type-member-init)
      least.fill(1);
      std::fill_n(view_of_.begin() + first, size, kNoView);
      for (std::uint32_t v = 0; v < views_; ++v) {
        const GrownGrid& grid = grids_[v];
        if (grid.tolerance == 0) continue;
        const auto inverse = static_cast<float>(1 / (grid.tolerance * grid.tolerance));
        distances2_within(grid.grid, grid.radius, cloud_.positions().subspan(first, size), distances2);
        for (std::uint32_t k = 0; k < size; ++k) {
          const float relative = distances2[k] * inverse;
          if (relative > least[k]) continue;
          least[k] = relative;
          view_of_[first + k] = static_cast<std::uint8_t>(v);
        }
      }
      for (std::uint32_t k = 0; k < size; ++k) points += view_of_[first + k] != kNoView ? 1 : 0;
    }
    return points;
  }

  const Cloud& cloud_;
  const KdTree3& tree_;
  float spacing_;
  std::span<std::uint8_t> view_of_;
  std::optional<GridGrowth> growth_;
  std::span<GrownGrid> grids_;
  std::uint32_t thinning_;  ///< every how many-th block is enough to count
  std::uint32_t views_ = 0;
  double radial_ = 0;          ///< sum of the lens's first coefficient over the claimed points
  std::uint64_t facing_ = 0;   ///< sum of count_facing() over the first views, as they were when found
  std::uint64_t claimed_ = 0;  ///< points given to views; counted again when a view is grown again
};

}  // namespace

std::size_t find_views_bytes(std::uint32_t threads) {
  return PatchGrids::bytes(threads) + GridGrowth::bytes(threads) + kMaxViews * sizeof(GrownGrid);
}

Expected<FoundViews> find_views(const Cloud& cloud, const KdTree3& tree, float spacing, std::span<std::uint8_t> view_of,
                                Arena& arena, const StageProgress& progress) {
  return ViewFinder(cloud, tree, spacing, view_of).run(arena, progress);
}

}  // namespace plumbline
