#include "slicer/views/find_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "slicer/views/grid_growth.hpp"
#include "slicer/views/patch_spectrum.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

// Patches, of points that are of no view yet:
constexpr std::uint32_t kPatch = 4096;   ///< points
constexpr std::uint32_t kEnough = 2560;  ///< or a larger patch is tried, too
constexpr std::uint32_t kFewest = 512;
constexpr std::array<float, 3> kReaches = {36, 50, 70};  ///< spacings

// Pairs of peaks that may be the two frequencies of a grid:
constexpr float kLeastSine2 = 0.5F;       ///< of the angle between them, squared
constexpr float kLeastRatio2 = 0.4F;      ///< of their lengths, squared
constexpr float kLeastIncidence = 0.15F;  ///< cosine of the angle that their ray meets the patch at
constexpr float kLeastSum = 10;           ///< power at their sum and their difference

// When to give up:
constexpr std::uint32_t kMostSeeds = 400;
constexpr std::uint32_t kMostFailures = 16;  ///< patches one after the other in which no view was found
constexpr std::uint32_t kMostTries = 16;     ///< pairs of a patch that were no grid

constexpr std::uint32_t kFewestOfView = 400;  ///< points
constexpr std::uint32_t kMostLikely = 500;    ///< no view has less than this part of all points

constexpr std::uint32_t kMostRestarts = 5;
constexpr float kRestartReach = 50;  ///< spacings
constexpr double kExact = 0.01;      ///< pixels

constexpr double kSearch = 0.8;  ///< of the time

struct Candidate {
  float distance2;
  std::uint32_t index;
};

class ViewFinder {
 public:
  ViewFinder(const Cloud& cloud, const KdTree3& tree, float spacing, std::span<std::uint8_t> view_of)
      : cloud_(cloud), tree_(tree), spacing_(spacing), view_of_(view_of) {}

  Expected<FoundViews> run(Arena& arena, const StageProgress& progress) {
    const ArenaScope scope(arena);
    auto spectrum = PatchSpectrum::create(arena);
    PLUMBLINE_TRY(spectrum);
    auto growth = GridGrowth::create(cloud_, tree_, view_of_, arena);
    PLUMBLINE_TRY(growth);
    auto candidates = arena.take_top<Candidate>(kPatch * 4, kStage);
    PLUMBLINE_TRY(candidates);
    auto patch = arena.take_top<Vec3f>(kPatch, kStage);
    PLUMBLINE_TRY(patch);
    auto grids = arena.take_top<GrownGrid>(kMostViews, kStage);
    PLUMBLINE_TRY(grids);
    growth_ = *growth;
    candidates_ = *candidates;
    patch_ = *patch;
    grids_ = *grids;
    std::fill(view_of_.begin(), view_of_.end(), kNoView);
    if (!search(*spectrum, progress.part(0, kSearch)) || !polish(progress.part(kSearch, 1))) {
      return fail(ErrorCode::kCancelled, "cancelled while views were looked for");
    }
    FoundViews found;
    found.count = views_;
    found.points = assign();
    for (std::uint32_t v = 0; v < views_; ++v) found.grids[v] = grids_[v].grid;
    return found;
  }

 private:
  bool search(PatchSpectrum& spectrum, const StageProgress& progress) {
    std::uint32_t failures = 0;
    std::uint64_t seed = 0;
    double done = 0;
    for (std::uint32_t s = 0; s < kMostSeeds && failures < kMostFailures && views_ < kMostViews; ++s) {
      done = std::max({done, static_cast<double>(claimed_) / cloud_.size, 1.0 * failures / kMostFailures});
      if (!progress.advance(done)) return false;
      seed += 0x9E3779B97F4A7C15U;  // the golden ratio: each seed as far from the others as can be
      const auto i = static_cast<std::uint32_t>((seed >> 32U) * cloud_.size >> 32U);
      if (view_of_[i] != kNoView) continue;
      const std::uint32_t before = views_;
      look_at(i, spectrum);
      failures = views_ > before ? 0 : failures + 1;
    }
    return true;
  }

  std::uint32_t gather(const Vec3f& middle, float radius) {
    std::uint32_t count = 0;
    const Vec3f reach = Vec3f::Constant(radius);
    tree_.visit_box(middle - reach, middle + reach, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t i = first; i < last; ++i) {
        if (view_of_[i] != kNoView || cloud_.normal[i].weight != 1) continue;
        const Vec3f d = cloud_.position[i] - middle;
        const float d2 = d.dot(d);
        if (d2 <= radius * radius && count < candidates_.size()) candidates_[count++] = {d2, i};
      }
    });
    return count;
  }

  /// Looks for the grids of views round a point, in larger patches where smaller ones have few points and no grid.
  void look_at(std::uint32_t seed, PatchSpectrum& spectrum) {
    const std::uint32_t before = views_;
    for (const float reach : kReaches) {
      const float radius = reach * spacing_;
      const std::uint32_t count = gather(cloud_.position[seed], radius);
      if (count < kFewest) continue;
      look_at_patch(seed, count, radius, spectrum);
      if (views_ > before || count >= kEnough) return;
    }
  }

  /// @param count  of the candidates
  void look_at_patch(std::uint32_t seed, std::uint32_t count, float radius, PatchSpectrum& spectrum) {
    const Vec3f middle = cloud_.position[seed];
    if (count > kPatch) {
      std::nth_element(candidates_.begin(), candidates_.begin() + kPatch, candidates_.begin() + count,
                       [](const Candidate& a, const Candidate& b) {
                         return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.index < b.index;
                       });
      radius = std::sqrt(candidates_[kPatch].distance2);
      count = kPatch;
    }
    Vec3f normal = Vec3f::Zero();
    const Vec3f facing = cloud_.normal[seed].unpack();
    for (std::uint32_t k = 0; k < count; ++k) {
      patch_[k] = cloud_.position[candidates_[k].index] - middle;
      const Vec3f n = cloud_.normal[candidates_[k].index].unpack();
      normal += n.dot(facing) < 0 ? Vec3f(-n) : n;
    }
    normal /= std::sqrt(normal.dot(normal));
    const auto points = std::span<const Vec3f>(patch_).first(count);
    const auto peaks = spectrum.peaks(points, normal, radius, spacing_);
    std::uint32_t failures = 0;
    for (std::size_t a = 0; a < peaks.size(); ++a) {
      for (std::size_t b = a + 1; b < peaks.size() && views_ < kMostViews && failures < kMostTries; ++b) {
        if (!may_be_grid(points, normal, peaks[a].frequency, peaks[b].frequency)) continue;
        const ViewGrid start = grid_of(middle, points, peaks[a].frequency, peaks[b].frequency);
        const auto grown = growth_->grow(start, static_cast<double>(radius));
        if (grown && claim(views_, *grown)) {
          ++views_;
        } else {
          ++failures;
        }
      }
    }
  }

  static bool may_be_grid(std::span<const Vec3f> points, const Vec3f& normal, const Vec3f& f, const Vec3f& g) {
    const Vec3f ray = f.cross(g);
    const float ray2 = ray.dot(ray);
    const float f2 = f.dot(f);
    const float g2 = g.dot(g);
    if (ray2 < kLeastSine2 * f2 * g2 || f2 < kLeastRatio2 * g2 || g2 < kLeastRatio2 * f2) return false;
    if (std::abs(ray.dot(normal)) < kLeastIncidence * std::sqrt(ray2)) return false;
    return power_at(points, f + g) >= kLeastSum && power_at(points, f - g) >= kLeastSum;
  }

  /// As the camera sees the patch if it is so far away that all rays are parallel.
  static ViewGrid grid_of(const Vec3f& middle, std::span<const Vec3f> points, const Vec3f& f, const Vec3f& g) {
    ViewGrid grid;
    grid.middle = middle;
    grid.map.setZero();
    grid.map.segment<3>(0) = f.cast<double>();
    grid.map.segment<3>(4) = g.cast<double>();
    grid.map[3] = -static_cast<double>(angle_in_turns(coefficient(points, f)));
    grid.map[7] = -static_cast<double>(angle_in_turns(coefficient(points, g)));
    return grid;
  }

  /// Points of no view yet that lie on a grid become those of `view`, if they are enough.
  bool claim(std::uint32_t view, const GrownGrid& grid) {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (view_of_[i] != kNoView || grid.off(cloud_.position[i]) > 1) continue;
      view_of_[i] = static_cast<std::uint8_t>(view);
      ++count;
    }
    if (count < std::max(kFewestOfView, cloud_.size / kMostLikely)) {
      rename(view, kNoView);
      return false;
    }
    claimed_ += count;
    grids_[view] = grid;
    return true;
  }

  void rename(std::uint32_t from, std::uint32_t to) {
    std::replace(view_of_.begin(), view_of_.end(), static_cast<std::uint8_t>(from), static_cast<std::uint8_t>(to));
  }

  /// Grows each view once more, with all others' points out of its way, and joins parts of one view.
  bool polish(const StageProgress& progress) {
    for (std::uint32_t v = 0; v < views_; ++v) {
      if (!progress.advance(1.0 * v / views_)) return false;
      grow_again(v);
    }
    for (std::uint32_t v = 0; v < views_; ++v) {
      const std::uint32_t before = views_;
      for (std::uint32_t w = 0; w < views_;) {
        if (w == v || !is_part(w, v)) {
          ++w;
          continue;
        }
        remove(w);
        if (v == views_) v = w;
      }
      if (views_ < before) grow_again(v);
    }
    return true;
  }

  /// The last view gets its number.
  void remove(std::uint32_t view) {
    rename(view, kNoView);
    --views_;
    if (view == views_) return;
    grids_[view] = grids_[views_];
    rename(views_, view);
  }

  void grow_again(std::uint32_t view) {
    rename(view, kNoView);
    GrownGrid best = grids_[view];
    std::uint32_t most = growth_->count(best);
    const auto try_from = [&](const ViewGrid& grid, double radius) {
      const auto grown = growth_->grow(grid, radius);
      if (!grown) return;
      const std::uint32_t count = growth_->count(*grown);
      if (count <= most) return;
      most = count;
      best = *grown;
    };
    try_from(best.grid, best.radius);
    // A grid fitted to flat faces alone may be whole pixels off between them: from elsewhere it will not be.
    for (std::uint32_t k = 1; k <= kMostRestarts && best.tolerance > kExact; ++k) {
      std::uint32_t left = most * k / (kMostRestarts + 1);
      const auto thin = growth_->thin();
      const auto start = std::find_if(thin.begin(), thin.end(), [&](std::uint32_t i) {
        return view_of_[i] == kNoView && best.off(cloud_.position[i]) <= 1 && left-- == 0;
      });
      if (start == thin.end()) break;
      try_from(best.grid.around(cloud_.position[*start]), static_cast<double>(kRestartReach * spacing_));
    }
    if (!claim(view, best)) grids_[view].tolerance = 0;
  }

  /// Whether most of a view's points lie on another's grid.
  bool is_part(std::uint32_t part, std::uint32_t view) const {
    std::uint32_t of_part = 0;
    std::uint32_t of_view = 0;
    for (const std::uint32_t i : growth_->thin()) {
      if (view_of_[i] != part) continue;
      ++of_part;
      if (grids_[view].off(cloud_.position[i]) <= 1) ++of_view;
    }
    return of_view * 2 > of_part;
  }

  /// Each point to the view whose grid it is closest to, whatever view came first. How many have one.
  std::uint32_t assign() {
    std::uint32_t points = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      double least = 1;
      view_of_[i] = kNoView;
      for (std::uint32_t v = 0; v < views_; ++v) {
        const double off = grids_[v].off(cloud_.position[i]);
        if (off > least) continue;
        least = off;
        view_of_[i] = static_cast<std::uint8_t>(v);
      }
      if (view_of_[i] != kNoView) ++points;
    }
    return points;
  }

  const Cloud& cloud_;
  const KdTree3& tree_;
  float spacing_;
  std::span<std::uint8_t> view_of_;
  std::optional<GridGrowth> growth_;
  std::span<Candidate> candidates_;
  std::span<Vec3f> patch_;
  std::span<GrownGrid> grids_;
  std::uint32_t views_ = 0;
  std::uint64_t claimed_ = 0;  ///< points, again where they were claimed again
};

}  // namespace

std::size_t find_views_bytes() {
  return PatchSpectrum::bytes() + GridGrowth::bytes() + kPatch * (4 * sizeof(Candidate) + sizeof(Vec3f)) +
         kMostViews * sizeof(GrownGrid);
}

Expected<FoundViews> find_views(const Cloud& cloud, const KdTree3& tree, float spacing, std::span<std::uint8_t> view_of,
                                Arena& arena, const StageProgress& progress) {
  return ViewFinder(cloud, tree, spacing, view_of).run(arena, progress);
}

}  // namespace plumbline
