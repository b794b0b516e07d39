#include "slicer/views/registration.hpp"

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

constexpr std::uint32_t kPlaces = 16384;
constexpr std::uint32_t kChunk = 64;  ///< places that are looked at before they are added up
constexpr int kRounds = 5;
constexpr int kSmooth = 2;           ///< rounds before ripple is looked for: views that are off look like ripple, too
constexpr double kWhole = 0.25;      ///< of the mean view's points: a part of a view says less of where the scan is
constexpr double kFirstMotion = 2;   ///< spacings: standard deviation of what views are moved by, until it is seen
constexpr double kSamePlace = 10;    ///< points that err together: so much less do places say of a view's motion
constexpr float kMostLeft = 0.985F;  ///< of the distances from the surface, or views stay where they are

/// A symmetric positive definite matrix, row after row, of which the lower half is used, becomes its Cholesky factor.
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

/// Solves l x = b in place of b, of which all before `first` is nought.
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
    const auto taken = take(arena);
    PLUMBLINE_TRY(taken);
    auto waves = WaveSearch::create(arena);
    PLUMBLINE_TRY(waves);
    weigh_views();
    Registration result;
    for (int round = 0; round <= kRounds; ++round) {
      const auto mean_square =
          look_at_places(progress.part(1.0 * round / (kRounds + 1), (round + 1.0) / (kRounds + 1)));
      PLUMBLINE_TRY(mean_square);
      if (!(*mean_square > 0)) return Registration{};
      result.after = static_cast<float>(std::sqrt(*mean_square));
      if (round == 0) result.before = result.after;
      if (round == kRounds || !improve()) break;
      if (round < kSmooth) continue;
      for (std::size_t v = 0; v < views_.size(); ++v) {
        DepthImage image = image_of(v);
        waves->improve(views_.ripples[v], image);
      }
    }
    if (result.after <= kMostLeft * result.before) {
      move(result);
    } else {
      result.after = result.before;
    }
    return result;
  }

 private:
  Status take(Arena& arena) {
    const std::size_t views = views_.size();
    auto products = arena.take_top<double>(36 * views * views, kStage);
    PLUMBLINE_TRY(products);
    auto residuals = arena.take_top<double>(6 * views, kStage);
    PLUMBLINE_TRY(residuals);
    auto places = arena.take_top<SharedPlace>(kChunk, kStage);
    PLUMBLINE_TRY(places);
    auto frames = arena.take_top<DepthFrame>(views, kStage);
    PLUMBLINE_TRY(frames);
    auto cells = arena.take_top<DepthImage::Cell>(views * DepthImage::kCells, kStage);
    PLUMBLINE_TRY(cells);
    products_ = *products;
    residuals_ = *residuals;
    places_ = *places;
    frames_ = *frames;
    cells_ = *cells;
    for (std::size_t v = 0; v < views; ++v) frames_[v] = views_.frame(static_cast<std::uint8_t>(v));
    return {};
  }

  void weigh_views() {
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (views_.view_of(i) != kNoView) shares_[views_.view_of(i)] += static_cast<double>(views_.size()) / cloud_.size;
    }
    for (double& x : shares_) x = std::min(1.0, x / kWhole);
  }

  DepthImage image_of(std::size_t view) {
    return {frames_[view], cells_.subspan(view * DepthImage::kCells, DepthImage::kCells)};
  }

  Expected<double> look_at_places(const StageProgress& progress) {
    std::fill(products_.begin(), products_.end(), 0);
    std::fill(residuals_.begin(), residuals_.end(), 0);
    std::fill(cells_.begin(), cells_.end(), DepthImage::Cell{});
    double sum = 0;
    std::uint32_t count = 0;
    const std::uint32_t places = std::min(kPlaces, cloud_.size);
    for (std::uint32_t first = 0; first < places; first += kChunk) {
      if (!progress.advance(1.0 * first / places))
        return fail(ErrorCode::kCancelled, "cancelled while views were registered");
      const std::uint32_t here = std::min(kChunk, places - first);
#pragma omp parallel for schedule(dynamic, 8)
      for (std::uint32_t k = 0; k < here; ++k) {
        const auto i = static_cast<std::uint32_t>(std::uint64_t{first + k} * cloud_.size / places);
        if (!places_[k].look_at(cloud_, tree_, views_, i)) places_[k].views = 0;
      }
      for (const SharedPlace& place : places_.first(here)) {
        if (place.views < 2) continue;
        add(place);
        sum += place.mean_square;
        ++count;
      }
    }
    return count > 0 ? sum / count : 0;
  }

  void add(const SharedPlace& place) {
    const std::size_t n = residuals_.size();
    const double* lever = place.lever.data();
    for (std::uint32_t v = 0; v < place.views; ++v) {
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
    for (std::uint32_t k = 0; k < place.points; ++k) {
      const std::uint32_t i = place.point[k];
      image_of(views_.view_of(i)).add(views_.seen(i), place.off[k], place.weight[k]);
    }
  }

  bool improve() {
    const std::size_t n = residuals_.size();
    double trace = 0;
    for (std::size_t k = 0; k < n; ++k) trace += products_[k * n + k];
    const double together = trace / static_cast<double>(n);
    const double alone = kSamePlace / motion2_;
    for (std::size_t i = 0; i < n; ++i) {
      products_[i * n + i] += alone;
      // The sum of all motions is held at nought: the scan as a whole says nothing of where it is.
      for (std::size_t j = i % 6; j <= i; j += 6) products_[i * n + j] += together * shares_[i / 6] * shares_[j / 6];
      residuals_[i] -= alone * views_.motions[i / 6][static_cast<Eigen::Index>(i % 6)];
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
    const double told = static_cast<double>(n) - alone * trace_of_inverse();
    if (square > 0 && told > 0) motion2_ = square / told;
    return true;
  }

  /// Of the normal equations, which have been factorized.
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

  void move(Registration& result) {
    double sum = 0;
    double ripple = 0;
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (views_.view_of(i) == kNoView) continue;
      const double depth = views_.ripples[views_.view_of(i)].depth(views_.seen(i));
      const Vec3f to = (views_.moved(i) + views_.middle()).cast<float>();
      const Vec3f by = to - cloud_.position[i];
      sum += static_cast<double>(by.dot(by));
      ripple += depth * depth;
      ++count;
      cloud_.position[i] = to;
    }
    result.moved = static_cast<float>(std::sqrt(sum / std::max(1U, count)));
    result.ripple = static_cast<float>(std::sqrt(ripple / std::max(1U, count)));
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  MovedViews views_;
  std::span<double> products_;
  std::span<double> residuals_;
  std::span<SharedPlace> places_;
  std::span<DepthFrame> frames_;
  std::span<DepthImage::Cell> cells_;  ///< of each view's image
  /// Variance of a component of what a view has to be moved by, mm^2: the squares of all motions over the number of those
  /// that the scan tells of (MacKay, Bayesian interpolation, 1992); of the others it tells nothing, and they stay small.
  double motion2_;
  std::array<double, kMostViews> shares_ = {};  ///< of each view in where the scan is: 1, less for a part of a view
};

}  // namespace

std::size_t register_views_bytes() {
  constexpr std::size_t kUnknowns = 6 * std::size_t{kMostViews};
  return MovedViews::bytes(kMostViews) + WaveSearch::bytes() + kUnknowns * (kUnknowns + 1) * sizeof(double) +
         kChunk * sizeof(SharedPlace) +
         kMostViews * (sizeof(DepthFrame) + std::size_t{DepthImage::kCells} * sizeof(DepthImage::Cell));
}

Expected<Registration> register_views(Cloud& cloud, const KdTree3& tree, const Views& views, Arena& arena,
                                      const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto moved = MovedViews::create(cloud, views, arena);
  PLUMBLINE_TRY(moved);
  return Registrar(cloud, tree, *moved).run(arena, progress);
}

}  // namespace plumbline
