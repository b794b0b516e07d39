#include "slicer/views/registration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/views/find_views.hpp"
#include "slicer/views/local_form.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "views";

constexpr std::uint32_t kPlaces = 16384;
constexpr std::uint32_t kChunk = 256;    ///< places that are looked at before they are added up
constexpr std::uint32_t kMostHere = 24;  ///< views of a place; more are left out
constexpr int kRounds = 3;
constexpr float kLeastCosine = 0.8F;     ///< of two normals of one smooth place
constexpr float kMostBent = 0.05F;       ///< of a place's points: about an edge a paraboloid tells nothing
constexpr float kFacingAway = -0.5F;     ///< cosine: the other side of a wall
constexpr double kLeastIncidence = 0.5;  ///< cosine: noise along a grazing ray puts points outside of what is curved;
constexpr double kGrazing = 0.05;        ///< weight of these, which may be all that tells where their view is
constexpr double kWhole = 0.25;          ///< of the mean view's points: a part of a view says less of where the scan is
constexpr double kFirstMotion = 2;       ///< spacings: standard deviation of what views are moved by, until it is seen
constexpr double kOfMedian = 1.4826;     ///< standard deviation over the median of the magnitudes
constexpr double kSamePlace = 10;        ///< points that err together: so much less do places say of a view's motion
constexpr double kLeastGain = 0.03;      ///< of the mean square, or views stay where they are

/// What one place says: for its views v and w, products[v][w] of <lever, motion of v> with that of w, and residuals[v].
struct Place {
  Vec6d lever;
  std::uint32_t views = 0;
  double mean_square = 0;  ///< of the residuals, mm^2
  std::array<std::uint8_t, kMostHere> view;
  std::array<double, kMostHere> residuals;
  std::array<std::array<double, kMostHere>, kMostHere> products;
};

/// Solves a x = b for a symmetric positive definite a (n x n, row after row; the lower half is used and lost) in place of b.
bool solve_in_place(std::span<double> a, std::span<double> b) {
  const std::size_t n = b.size();
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
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= a[i * n + k] * b[k];
    b[i] /= a[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) b[i] -= a[k * n + i] * b[k];
    b[i] /= a[i * n + i];
  }
  return true;
}

class Registrar {
 public:
  Registrar(Cloud& cloud, const KdTree3& tree, const Views& views) : cloud_(cloud), tree_(tree), views_(views) {}

  Expected<Registration> run(Arena& arena, const StageProgress& progress) {
    const ArenaScope scope(arena);
    const std::size_t unknowns = 6 * std::size_t{views_.grids.size()};
    auto motions = arena.take_top<Vec6d>(views_.grids.size(), kStage);
    PLUMBLINE_TRY(motions);
    auto products = arena.take_top<double>(unknowns * unknowns, kStage);
    PLUMBLINE_TRY(products);
    auto residuals = arena.take_top<double>(unknowns, kStage);
    PLUMBLINE_TRY(residuals);
    auto places = arena.take_top<Place>(kChunk, kStage);
    PLUMBLINE_TRY(places);
    motions_ = *motions;
    products_ = *products;
    residuals_ = *residuals;
    places_ = *places;
    std::fill(motions_.begin(), motions_.end(), Vec6d::Zero());
    std::fill(shares_.begin(), shares_.end(), 0);
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (views_.of[i] != kNoView) shares_[views_.of[i]] += static_cast<double>(views_.grids.size()) / cloud_.size;
    }
    for (double& x : shares_) x = std::min(1.0, x / kWhole);
    const Box3f bounds = cloud_.bounds();
    middle_ = bounds.centre().cast<double>();
    extent_ = 0.5 * static_cast<double>(bounds.size().maxCoeff());
    Registration result;
    for (int round = 0; round <= kRounds; ++round) {
      const auto mean_square =
          look_at_places(progress.part(1.0 * round / (kRounds + 1), (round + 1.0) / (kRounds + 1)));
      PLUMBLINE_TRY(mean_square);
      if (!(*mean_square > 0)) return Registration{};
      const auto rms = static_cast<float>(std::sqrt(*mean_square));
      if (round == 0) result.before = rms;
      result.after = rms;
      if (round < kRounds && !improve()) return Registration{result.before, result.before, 0};
    }
    const double gain = 1 - static_cast<double>(result.after) * static_cast<double>(result.after) /
                                (static_cast<double>(result.before) * static_cast<double>(result.before));
    if (!(gain >= kLeastGain)) return Registration{result.before, result.before, 0};
    result.moved = move();
    return result;
  }

 private:
  Vec3d moved(std::uint32_t i) const {
    const Vec3d x = cloud_.position[i].cast<double>() - middle_;
    const Vec6d& m = motions_[views_.of[i]];
    return x + m.head<3>() + m.tail<3>().cross(x) / extent_;
  }

  Expected<double> look_at_places(const StageProgress& progress) {
    std::fill(products_.begin(), products_.end(), 0);
    std::fill(residuals_.begin(), residuals_.end(), 0);
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
        if (!look_at(i, places_[k])) places_[k].views = 0;
      }
      for (const Place& place : places_.first(here)) {
        if (place.views < 2) continue;
        add(place);
        sum += place.mean_square;
        ++count;
      }
    }
    return count > 0 ? sum / count : 0;
  }

  bool look_at(std::uint32_t i, Place& place) const {
    if (views_.of[i] == kNoView) return false;
    std::array<Neighbour, LocalForm::kMostPoints> found = {};
    const std::uint32_t count =
        tree_.nearest(cloud_.position[i], found, [this](std::uint32_t other) { return views_.of[other] != kNoView; });
    const Vec3f facing = cloud_.normal[i].unpack();
    std::array<Vec3d, LocalForm::kMostPoints> points;
    std::array<std::uint32_t, LocalForm::kMostPoints> index = {};
    std::uint32_t size = 0;
    std::uint32_t bent = 0;
    for (const Neighbour& n : std::span(found).first(count)) {
      const float alike = cloud_.normal[n.index].unpack().dot(facing);
      if (alike < kFacingAway) continue;
      if (alike < kLeastCosine) {
        ++bent;
        continue;
      }
      points[size] = moved(n.index);
      index[size++] = n.index;
    }
    if (static_cast<float>(bent) > kMostBent * static_cast<float>(count)) return false;
    LocalForm form;
    if (!form.fit(std::span(points).first(size))) return false;
    double weights = 0;
    for (std::uint32_t k = 0; k < form.size; ++k) {
      const std::uint32_t at = index[form.point[k]];
      const double incidence = std::abs(views_.grids[views_.of[at]].ray(cloud_.position[at]).dot(form.normal));
      form.weight[k] = incidence < kLeastIncidence ? kGrazing : 1;
      weights += form.weight[k];
    }
    form.solve();
    place.views = 0;
    place.mean_square = 0;
    std::array<Vec6d, kMostHere> sums;
    std::array<double, kMostHere> counts = {};
    for (std::uint32_t k = 0; k < form.size; ++k) {
      place.mean_square += form.weight[k] * form.residual[k] * form.residual[k] / weights;
      const std::uint8_t of = views_.of[index[form.point[k]]];
      std::uint32_t v = 0;
      while (v < place.views && place.view[v] != of) ++v;
      if (v == kMostHere) continue;
      if (v == place.views) {
        place.view[v] = of;
        place.residuals[v] = 0;
        sums[v].setZero();
        ++place.views;
      }
      place.residuals[v] += form.weight[k] * form.residual[k];
      sums[v] += form.weight[k] * form.terms[k];
      counts[v] += form.weight[k];
    }
    const double weight = 1 / (form.deviation * form.deviation);
    const auto factors = form.gram.ldlt();
    for (std::uint32_t v = 0; v < place.views; ++v) {
      const Vec6d solved = factors.solve(sums[v]);
      for (std::uint32_t w = 0; w < place.views; ++w) {
        place.products[v][w] = weight * ((v == w ? counts[v] : 0) - solved.dot(sums[w]));
      }
      place.residuals[v] *= weight;
    }
    place.lever.head<3>() = form.normal;
    place.lever.tail<3>() = form.mean.cross(form.normal) / extent_;
    return true;
  }

  void add(const Place& place) {
    const std::size_t n = residuals_.size();
    for (std::uint32_t v = 0; v < place.views; ++v) {
      const std::size_t row = 6 * std::size_t{place.view[v]};
      for (int a = 0; a < 6; ++a) residuals_[row + a] -= place.residuals[v] * place.lever[a];
      for (std::uint32_t w = 0; w < place.views; ++w) {
        const std::size_t column = 6 * std::size_t{place.view[w]};
        if (column > row) continue;
        for (int a = 0; a < 6; ++a) {
          const double factor = place.products[v][w] * place.lever[a];
          for (int b = 0; b < 6; ++b) products_[(row + a) * n + column + b] += factor * place.lever[b];
        }
      }
    }
  }

  bool improve() {
    const std::size_t n = residuals_.size();
    double trace = 0;
    for (std::size_t k = 0; k < n; ++k) trace += products_[k * n + k];
    const double together = trace / static_cast<double>(n);
    const double motion = likely_motion();
    const double alone = kSamePlace / (motion * motion);
    for (std::size_t i = 0; i < n; ++i) {
      products_[i * n + i] += alone;
      // The mean motion of the points is held at nought: the scan as a whole says nothing of where it is.
      for (std::size_t j = i % 6; j <= i; j += 6) products_[i * n + j] += together * shares_[i / 6] * shares_[j / 6];
      residuals_[i] -= alone * motions_[i / 6][static_cast<Eigen::Index>(i % 6)];
    }
    if (!solve_in_place(products_, residuals_)) return false;
    for (std::size_t i = 0; i < n; ++i) motions_[i / 6][static_cast<Eigen::Index>(i % 6)] += residuals_[i];
    return true;
  }

  /// Standard deviation of what a view has to be moved by, mm: as the median of all motions so far tells it.
  double likely_motion() const {
    std::array<double, 6 * std::size_t{kMostViews}> all;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const auto end = all.begin() + static_cast<std::ptrdiff_t>(residuals_.size());
    auto next = all.begin();
    for (const Vec6d& m : motions_) {
      for (const double a : m) *next++ = std::abs(a);
    }
    const auto middle = all.begin() + (end - all.begin()) / 2;
    std::nth_element(all.begin(), middle, end);
    return *middle > 0 ? kOfMedian * *middle : kFirstMotion * static_cast<double>(views_.spacing);
  }

  float move() {
    double sum = 0;
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if (views_.of[i] == kNoView) continue;
      const Vec3f to = (moved(i) + middle_).cast<float>();
      const Vec3f by = to - cloud_.position[i];
      sum += static_cast<double>(by.dot(by));
      ++count;
      cloud_.position[i] = to;
    }
    return static_cast<float>(std::sqrt(sum / std::max(1U, count)));
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  const Views& views_;
  std::span<Vec6d> motions_;
  std::span<double> products_;
  std::span<double> residuals_;
  std::span<Place> places_;
  std::array<double, kMostViews> shares_ = {};  ///< of the points, 1 for a view like the others
  Vec3d middle_ = Vec3d::Zero();
  double extent_ = 0;
};

}  // namespace

std::size_t register_views_bytes() {
  constexpr std::size_t kUnknowns = 6 * std::size_t{kMostViews};
  return kUnknowns * (kUnknowns + 2) * sizeof(double) + kChunk * sizeof(Place);
}

Expected<Registration> register_views(Cloud& cloud, const KdTree3& tree, const Views& views, Arena& arena,
                                      const StageProgress& progress) {
  return Registrar(cloud, tree, views).run(arena, progress);
}

}  // namespace plumbline
