#include "slicer/views/registration.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/views/depth_image.hpp"
#include "slicer/views/find_views.hpp"
#include "slicer/views/moved_views.hpp"
#include "slicer/views/shared_place.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

/// Number of places that are measured before each Gauss-Newton step. Most of the time goes into measuring them, and only the last
/// step has to be exact.
constexpr std::array<std::uint32_t, 5> kPlaces = {4096, 4096, 8192, 8192, 16384};
/// The same after the last step. They show how much closer the views have come, which decides whether the views are moved.
constexpr std::uint32_t kLastPlaces = kPlaces.front();
/// Places whose points are kept. Each step measures them, or a part of them that is evenly spread.
constexpr std::uint32_t kKept = 4096;
constexpr std::uint32_t kMotionSample = 65536;  ///< points, at least, whose motions are averaged
constexpr std::uint32_t kChunk = 64;            ///< places measured in parallel before they are summed up in order
constexpr std::size_t kStepsWithoutRipple = 2;  ///< first steps: the residuals of misaligned views look like ripple
/// A view with at least this share of the mean view's points counts fully in holding the scan in place.
constexpr double kWholeView = 0.25;
/// Standard deviation of the motions before the first round, in spacings. Later rounds use the variance found.
constexpr double kFirstMotion = 2;
/// Number of points with correlated errors: the data counts that much less against the prior.
constexpr double kCorrelatedPoints = 10;
/// Views are moved if the RMS distance from the surface falls to this share of what it was, or below.
constexpr float kMaxRemaining = 0.985F;
/// Most RMS motion, in RMS distances from the surface before it. A third of a motion's square is along the normal, and two views
/// that meet are each off by half of what they are apart: the distances are sqrt(1/3 * 1/2) of the motions or, with noise, more.
/// Views that moved farther have slid along the surface, where nothing holds them. So do the pieces of range images whose
/// grid is not a camera's.
constexpr float kMaxMoved = 2.5F;

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
    set_shares();
    Registration result;
    constexpr std::size_t kSteps = kPlaces.size();
    for (std::size_t step = 0; step <= kSteps; ++step) {
      const double done = static_cast<double>(step);
      const auto mean_square =
          measure_places(step < kSteps ? kPlaces[step] : kLastPlaces,
                         {.equations = step < kSteps, .images = step < kSteps && step >= kStepsWithoutRipple},
                         progress.part(done / (kSteps + 1), (done + 1) / (kSteps + 1)));
      PLUMBLINE_TRY(mean_square);
      if (!(*mean_square > 0)) return Registration{};
      result.after = static_cast<float>(std::sqrt(*mean_square));
      if (step == 0) result.before = result.after;
      if (step == kSteps || !improve()) break;
      if (step < kStepsWithoutRipple) continue;
      improve_ripples();
    }
    measure_motion(result);
    if (result.after <= kMaxRemaining * result.before && result.moved <= kMaxMoved * result.before) {
      move();
    } else {
      result = {.before = result.before, .after = result.before};
    }
    return result;
  }

 private:
  Status allocate(Arena& arena) {
    const std::size_t views = views_.size();
    PLUMBLINE_TRY(arena.take_top(products_, 36 * views * views, kStage));
    PLUMBLINE_TRY(arena.take_top(residuals_, 6 * views, kStage));
    PLUMBLINE_TRY(arena.take_top(places_, kChunk, kStage));
    PLUMBLINE_TRY(arena.take_top(kept_, kKept, kStage));
    for (PlacePoints& kept : kept_) kept.size = PlacePoints::kUnknown;
    PLUMBLINE_TRY(arena.take_top(frames_, views, kStage));
    PLUMBLINE_TRY(arena.take_top(cells_, views * DepthImage::kCells, kStage));
    PLUMBLINE_TRY(arena.take_top(searches_, static_cast<std::size_t>(omp_get_max_threads()), kStage));
    for (WaveSearch& search : searches_) {
      const auto created = WaveSearch::create(arena);
      PLUMBLINE_TRY(created);
      search = *created;
    }
    views_.set_image_frames(frames_);
    return {};
  }

  void set_shares() {
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (views_.view_of(i) != kNoView) shares_[views_.view_of(i)] += static_cast<double>(views_.size()) / cloud_.size;
    }
    for (double& x : shares_) x = std::min(1.0, x / kWholeView);
  }

  DepthImage image_of(std::size_t view) {
    return {frames_[view], cells_.subspan(view * DepthImage::kCells, DepthImage::kCells)};
  }

  struct Wanted {
    bool equations, images;
  };
  /// @param most    places to measure
  /// @param wanted  what to sum up
  Expected<double> measure_places(std::uint32_t most, const Wanted& wanted, const StageProgress& progress) {
    std::fill(products_.begin(), products_.end(), 0);
    std::fill(residuals_.begin(), residuals_.end(), 0);
    std::fill(cells_.begin(), cells_.end(), DepthImage::Cell{});
    double sum = 0;
    std::uint32_t count = 0;
    const std::uint32_t places = std::min(most, cloud_.size);
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
          if (place.views < 2) continue;
          if (wanted.equations) add_equations(place, share);
          if (wanted.images) add_offsets(place, share);
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
    PlacePoints here;
    const bool is_kept = std::uint64_t{k} * kKept % places == 0;
    PlacePoints& near = is_kept ? kept_[static_cast<std::size_t>(std::uint64_t{k} * kKept / places)] : here;
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

  void add_offsets(const SharedPlace& place, const ViewShare& share) {
    for (std::uint32_t k = 0; k < place.points; ++k) {
      if (!share.has(place.view_of[k])) continue;
      image_of(place.view_of[k]).add(views_.seen_position(place.point[k]), place.offset[k], place.weight[k]);
    }
  }

  void improve_ripples() {
#pragma omp parallel for schedule(dynamic)
    for (std::size_t v = 0; v < views_.size(); ++v) {
      DepthImage image = image_of(v);
      searches_[static_cast<std::size_t>(omp_get_thread_num())].improve(views_.ripples[v], image);
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
      // Holds the sum of all motions at 0, since the points don't determine where the scan as a whole lies.
      for (std::size_t j = i % 6; j <= i; j += 6) products_[i * n + j] += anchor * shares_[i / 6] * shares_[j / 6];
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
    return (views_.moved_position(point, views_.ray(point)) + views_.middle()).cast<float>();
  }

  void measure_motion(Registration& result) const {
    double sum = 0;
    double ripple = 0;
    std::uint32_t count = 0;
    const std::uint32_t stride = std::max(1U, cloud_.size / kMotionSample);
    for (std::uint32_t i = 0; i < cloud_.size; i += stride) {
      if (views_.view_of(i) == kNoView) continue;
      const double depth = views_.ripples[views_.view_of(i)].depth(views_.seen_position(i));
      const Vec3f by = moved_position(i) - cloud_.position[i];
      sum += static_cast<double>(by.dot(by));
      ripple += depth * depth;
      ++count;
    }
    result.moved = static_cast<float>(std::sqrt(sum / std::max(1U, count)));
    result.ripple = static_cast<float>(std::sqrt(ripple / std::max(1U, count)));
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
  std::span<PlacePoints> kept_;
  std::span<DepthFrame> frames_;
  std::span<DepthImage::Cell> cells_;  ///< of each view's image
  std::span<WaveSearch> searches_;     ///< a thread's each
  /// Variance of one component of a view's motion, mm^2: the sum of all squared components over the number of
  /// components that the scan determines (MacKay, Bayesian interpolation, 1992). The others stay small.
  double motion2_;
  std::array<double, kMaxViews> shares_ = {};  ///< of each view in holding the scan in place: 1, less for small views
};

}  // namespace

std::size_t register_views_bytes(std::uint32_t views, std::uint32_t threads) {
  const std::size_t unknowns = 6 * std::size_t{views};
  return MovedViews::bytes(views) + threads * (WaveSearch::bytes() + sizeof(WaveSearch)) +
         unknowns * (unknowns + 1) * sizeof(double) + kChunk * sizeof(SharedPlace) + kKept * sizeof(PlacePoints) +
         views * (sizeof(DepthFrame) + std::size_t{DepthImage::kCells} * sizeof(DepthImage::Cell));
}

Expected<Registration> register_views(Cloud& cloud, const KdTree3& tree, const Views& views, Arena& arena,
                                      const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto moved = MovedViews::create(cloud, views, arena);
  PLUMBLINE_TRY(moved);
  return Registrar(cloud, tree, *moved).run(arena, progress);
}

}  // namespace plumbline
