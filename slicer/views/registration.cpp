#include "slicer/views/registration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "slicer/core/numbers/median.hpp"
#include "slicer/views/moved_views.hpp"
#include "slicer/views/shared_place.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "views";

constexpr std::uint32_t kPlaces = 4096;  ///< that are measured before each step; twice as many find the same motions
constexpr std::uint32_t kSteps = 5;      ///< of Gauss-Newton
constexpr std::uint32_t kMotionSample = 65536;  ///< points, at least, whose motions are averaged
constexpr std::uint32_t kChunk = 256;           ///< places measured in parallel before they are summed up in order
/// Fewest points of a scan that is divided into runs.
constexpr std::uint32_t kFewestInRuns = 256 * kRuns;
/// Noise over spacing. Below it, runs that are off are not the scan's largest error, and looking for them would only take time.
constexpr float kLeastNoise = 0.2F;
/// Standard deviation of the motions before the first round, in spacings. Later rounds use the variance found.
constexpr double kFirstMotion = 2;
/// Number of points that share one error: those of a place, each of which is in some four places. The data counts that much less against
/// the prior. Less lets real views that agree as well as they can drift by twice their distance from the surface.
constexpr double kCorrelatedPoints = 300;
/// Views are moved if the RMS distance from the surface falls to this share of what it was, or below. It falls to .99 on the raw bunny as
/// it was published, whose views agree; to .75 on the raw dragon.
constexpr float kMaxRemaining = 0.95F;
/// The same after the first step, which finds most. Above it the others are not tried.
constexpr float kMaxFirstRemaining = 0.98F;
/// Most RMS motion of runs, in RMS distances from the surface before it: those that move farther have slid along it, as sections of a ball
/// do by 8. The raw dragon's move by 2.
constexpr float kMaxRunMoved = 4;

/// Replaces the lower half of a symmetric positive definite matrix (row after row) by its Cholesky factor.
/// @returns false if it is not positive definite
bool factorize(std::span<double> a, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    double* const row = &a[i * n];
    for (std::size_t j = 0; j <= i; ++j) {
      const double* const other = &a[j * n];
      double sum = row[j];
      for (std::size_t k = 0; k < j; ++k) sum -= row[k] * other[k];
      if (j < i) {
        row[j] = sum / other[j];
      } else {
        if (!(sum > 0)) return false;
        row[i] = std::sqrt(sum);
      }
    }
  }
  return true;
}

/// Solves l x = b in place of b, whose entries before `first` are 0.
void solve_lower(std::span<const double> l, std::span<double> b, std::size_t first) {
  const std::size_t n = b.size();
  for (std::size_t i = first; i < n; ++i) {
    for (std::size_t k = first; k < i; ++k) b[i] -= l[i * n + k] * b[k];
    b[i] /= l[i * n + i];
  }
}

/// Solves l^T x = b in place of b.
void solve_upper(std::span<const double> l, std::span<double> b) {
  const std::size_t n = b.size();
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) b[i] -= l[k * n + i] * b[k];
    b[i] /= l[i * n + i];
  }
}

struct ScanNoise {
  float spacing = 0;  ///< side of a square of one point's share of the surface
  float noise = 0;    ///< standard deviation of points off the surface
};

/// Medians over the scan.
ScanNoise measure_noise(const Cloud& cloud, const KdTree3& tree) {
  constexpr std::uint32_t kSample = 64;
  std::array<float, kSample> spacings = {};
  std::array<float, kSample> noises = {};
  for (std::uint32_t k = 0; k < kSample; ++k) {
    const Vec3f& at = cloud.position[cloud.sampled(k, kSample)];
    std::array<Neighbour, LocalParaboloid::kMaxPoints> found = {};
    const std::uint32_t near = tree.nearest(at, found);
    std::array<Vec3d, LocalParaboloid::kMaxPoints> points;
    for (std::uint32_t n = 0; n < near; ++n) points[n] = (cloud.position[found[n].index] - at).cast<double>();
    spacings[k] = std::sqrt(std::numbers::pi_v<float> * found[near - 1].distance2 / static_cast<float>(near));
    LocalParaboloid surface;
    if (surface.fit(std::span(points).first(near))) noises[k] = static_cast<float>(surface.deviation);
  }
  return {median(std::span<float>(spacings)), median(std::span<float>(noises))};
}

class Registrar {
 public:
  Registrar(Cloud& cloud, const KdTree3& tree, const MovedViews& views)
      : cloud_(cloud),
        tree_(tree),
        views_(views),
        motion2_(kFirstMotion * kFirstMotion * views.spacing() * views.spacing()) {}

  Expected<Registration> run(Arena& arena, const StageProgress& progress) {
    const auto taken = allocate(arena);
    PLUMBLINE_TRY(taken);
    Registration result{.views = views_.count()};
    for (std::uint32_t step = 0; step <= kSteps; ++step) {
      const auto mean_square = measure_places(progress.part(1.0 * step / (kSteps + 1), (step + 1.0) / (kSteps + 1)));
      PLUMBLINE_TRY(mean_square);
      if (!(*mean_square > 0)) return Registration{.views = views_.count()};
      result.after = static_cast<float>(std::sqrt(*mean_square));
      if (step == 0) result.before = result.after;
      const bool in_vain = step == 1 && result.after > kMaxFirstRemaining * result.before;
      if (step == kSteps || in_vain || !improve()) break;
    }
    hold_in_place();
    measure_motion(result);
    const bool have_slid = cloud_.views.are_runs && result.moved > kMaxRunMoved * result.before;
    if (result.after <= kMaxRemaining * result.before && !have_slid) {
      move();
    } else {
      result = {.views = views_.count(), .before = result.before, .after = result.before};
    }
    return result;
  }

 private:
  Status allocate(Arena& arena) {
    const std::size_t views = views_.count();
    PLUMBLINE_TRY(arena.take_top(products_, 36 * views * views, kStage));
    PLUMBLINE_TRY(arena.take_top(residuals_, 6 * views, kStage));
    PLUMBLINE_TRY(arena.take_top(places_, kChunk, kStage));
    PLUMBLINE_TRY(arena.take_top(points_, kPlaces, kStage));
    for (PlacePoints& points : points_) points.size = PlacePoints::kUnknown;
    return {};
  }

  /// @returns mean square of the points' distances from the surfaces; 0: no place is shared by two views
  Expected<double> measure_places(const StageProgress& progress) {
    std::fill(products_.begin(), products_.end(), 0);
    std::fill(residuals_.begin(), residuals_.end(), 0);
    double sum = 0;
    std::uint32_t count = 0;
    const std::uint32_t places = std::min(kPlaces, cloud_.size);
    for (std::uint32_t first = 0; first < places; first += kChunk) {
      if (!progress.advance(1.0 * first / places))
        return fail(ErrorCode::kCancelled, "cancelled while views were registered");
      const std::uint32_t here = std::min(kChunk, places - first);
#pragma omp parallel
      {
#pragma omp for schedule(dynamic)
        for (std::uint32_t k = 0; k < here; ++k) {
          if (!measure_place(places_[k], first + k, places)) places_[k].views = 0;
        }
        // Each thread sums up for views of its own, always in the order of the places.
        const ViewShare share = ViewShare::of_thread();
        for (const SharedPlace& place : places_.first(here)) {
          if (place.views >= 2) add_equations(place, share);
        }
      }
      for (const SharedPlace& place : places_.first(here)) {
        if (place.views < 2) continue;
        sum += place.mean_square;
        ++count;
      }
    }
    return count > 0 ? sum / count : 0;
  }

  /// Measures place `k` of so many.
  bool measure_place(SharedPlace& place, std::uint32_t k, std::uint32_t places) {
    PlacePoints& near = points_[k];
    if (near.size == PlacePoints::kUnknown) near.find(cloud_, tree_, views_, cloud_.sampled(k, places));
    return place.measure(views_, near);
  }

  void add_equations(const SharedPlace& place, const ViewShare& share) {
    const std::size_t n = residuals_.size();
    std::array<double, 6> lever;
    std::copy(place.lever.begin(), place.lever.end(), lever.begin());
    for (std::uint32_t v = 0; v < place.views; ++v) {
      if (!share.has(place.view[v])) continue;
      const std::size_t row = 6 * std::size_t{place.view[v]};
      for (std::size_t a = 0; a < 6; ++a) residuals_[row + a] -= place.residuals[v] * lever[a];
      for (std::uint32_t w = 0; w < place.views; ++w) {
        const std::size_t column = 6 * std::size_t{place.view[w]};
        if (column > row) continue;
        for (std::size_t a = 0; a < 6; ++a) {
          const double factor = place.products[v][w] * lever[a];
          for (std::size_t b = 0; b < 6; ++b) products_[(row + a) * n + column + b] += factor * lever[b];
        }
      }
    }
  }

  bool improve() {
    const std::size_t n = residuals_.size();
    double trace = 0;
    for (std::size_t k = 0; k < n; ++k) trace += products_[k * n + k];
    const double anchor = trace / static_cast<double>(n);
    const double prior = kCorrelatedPoints / motion2_;
    for (std::size_t i = 0; i < n; ++i) {
      products_[i * n + i] += prior;
      // The points don't determine where the scan as a whole lies. Here the sum of all motions is 0; see hold_in_place().
      for (std::size_t j = i % 6; j <= i; j += 6) products_[i * n + j] += anchor;
      residuals_[i] -= prior * views_.motions[i / 6][static_cast<Eigen::Index>(i % 6)];
    }
    if (!factorize(products_, n)) return false;
    solve_lower(products_, residuals_, 0);
    solve_upper(products_, residuals_);
    double square = 0;
    for (std::size_t i = 0; i < n; ++i) {
      double& motion = views_.motions[i / 6][static_cast<Eigen::Index>(i % 6)];
      motion += residuals_[i];
      square += motion * motion;
    }
    const double determined = static_cast<double>(n) - prior * trace_of_inverse();
    if (square > 0 && determined > 0) motion2_ = square / determined;
    return true;
  }

  /// Trace of the inverse of the normal equations, which must have been factorized. Overwrites the residuals.
  double trace_of_inverse() {
    const std::size_t n = residuals_.size();
    double trace = 0;
    for (std::size_t i = 0; i < n; ++i) {
      std::fill(residuals_.begin(), residuals_.end(), 0);
      residuals_[i] = 1;
      solve_lower(products_, residuals_, i);
      for (std::size_t k = i; k < n; ++k) trace += residuals_[k] * residuals_[k];
    }
    return trace;
  }

  Vec3f moved_position(std::uint32_t point) const {
    return (views_.moved_position(point) + views_.middle()).cast<float>();
  }

  template <class Visit>
  void for_each_sample(Visit visit) const {
    const std::uint32_t stride = std::max(1U, cloud_.size / kMotionSample);
    for (std::uint32_t i = 0; i < cloud_.size; i += stride) {
      if (views_.view_of(i) != kNoView) visit(i);
    }
  }

  /// Subtracts the one rigid motion of the whole scan that leaves its points as near as can be to where they were.
  void hold_in_place() {
    Mat6d products = Mat6d::Zero();
    Vec6d right = Vec6d::Zero();
    for_each_sample([&](std::uint32_t i) {
      const Vec3d x = views_.seen_position(i) / views_.extent();
      Eigen::Matrix<double, 3, 6> by;  // of a motion
      by << 1, 0, 0, 0, x[2], -x[1],   //
          0, 1, 0, -x[2], 0, x[0],     //
          0, 0, 1, x[1], -x[0], 0;
      products += by.transpose() * by;
      right += by.transpose() * (views_.moved_position(i) - views_.seen_position(i));
    });
    const Vec6d whole = products.ldlt().solve(right);
    if (!whole.allFinite()) return;
    for (Vec6d& motion : views_.motions) motion -= whole;
  }

  void measure_motion(Registration& result) const {
    double sum = 0;
    std::uint32_t count = 0;
    for_each_sample([&](std::uint32_t i) {
      sum += (views_.moved_position(i) - views_.seen_position(i)).squaredNorm();
      ++count;
    });
    result.moved = static_cast<float>(std::sqrt(sum / std::max(1U, count)));
  }

  void move() {
#pragma omp parallel for schedule(static)
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (views_.view_of(i) != kNoView) cloud_.position[i] = moved_position(i);
    }
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  MovedViews views_;
  std::span<double> products_;
  std::span<double> residuals_;
  std::span<SharedPlace> places_;
  std::span<PlacePoints> points_;  ///< of each place
  /// Variance of one component of a view's motion, mm^2: the sum of all squared components over the number of
  /// components that the scan determines (MacKay, Bayesian interpolation, 1992). The others stay small.
  double motion2_;
};

}  // namespace

std::size_t register_views_bytes(std::uint32_t views) {
  if (views < 2) return 0;
  views = MovedViews::count(views);
  const std::size_t unknowns = 6 * std::size_t{views};
  return MovedViews::bytes(views) + unknowns * (unknowns + 1) * sizeof(double) + kChunk * sizeof(SharedPlace) +
         kPlaces * sizeof(PlacePoints);
}

Expected<Registration> register_views(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress) {
  if (cloud.views.count < 2 || cloud.size < (cloud.views.are_runs ? kFewestInRuns : LocalParaboloid::kMinPoints)) {
    return Registration{};
  }
  const ScanNoise scan = measure_noise(cloud, tree);
  if (cloud.views.are_runs && !(scan.noise > kLeastNoise * scan.spacing)) return Registration{};
  const ArenaScope scope(arena);
  const auto moved = MovedViews::create(cloud, scan.spacing, arena);
  PLUMBLINE_TRY(moved);
  return Registrar(cloud, tree, *moved).run(arena, progress);
}

}  // namespace plumbline::inline slicer
