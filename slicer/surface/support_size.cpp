#include "slicer/surface/support_size.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "slicer/cloud/neighbourhood.hpp"
#include "slicer/implicit/mls.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "support size";

constexpr float kStep = 1.25F;         ///< ratio of one number of points to the one before
constexpr float kMaxPoints = 160;      ///< of a support; the time of the rays grows with it
constexpr std::size_t kMaxSizes = 10;  ///< tried, from the present number of points to 1.25^9 = 7.5 times as many
// Each place needs enough samples for a mean, and there must be enough places to show all of the object. Together they
// set the time.
constexpr std::uint32_t kPlaces = 128;
constexpr std::uint32_t kTogether = 16;  ///< places measured at once, in parallel, between two reports of progress
constexpr std::uint32_t kSamples = 32;   ///< points of a place, spread evenly over a part of the tree
constexpr double kRiskTolerance = 1.02;  ///< times the least risk: the narrowest supports up to this are taken
constexpr float kProjectionPoints = 60;  ///< points of the supports with which a sample is moved onto the surface
constexpr int kProjectionSteps = 2;
constexpr float kRadiusMargin = 1.2F;          ///< largest ratio of a neighbour's radius to the sample's
constexpr std::uint32_t kHalfCapacity = 1024;  ///< points of a half around a sample; samples with more are left out

/// The points around a sample that belong to one half.
struct Half {
  struct Point {
    Vec3f position;
    Vec3f normal;
    float h;  ///< present support radius, mm
  };
  std::span<Point> points;
  std::uint32_t size = 0;
  RayPoints columns;                  ///< those whose supports may contain the place
  std::span<float> present_inverse2;  ///< 1 / h^2 of these, mm^-2
  float most_h = 0;                   ///< mm
  float depth = 0;                    ///< z of the place, mm

  /// Goes to a place, with support radii up to `growth` times the present.
  void go_to(const Vec3f& x, float growth) {
    columns.size = 0;
    most_h = 0;
    depth = x[2];
    for (const Point& p : points.first(size)) {
      const Vec3f d = x - p.position;
      if (d.dot(d) >= growth * growth * p.h * p.h) continue;
      present_inverse2[columns.size] = 1 / (p.h * p.h);
      columns.add(d[0], d[1], p.position[2], p.normal, 0);
      most_h = std::max(most_h, p.h);
    }
    columns.close();
  }

  /// F at the place, mm, with support radii `growth` times the present. Nothing if no point is within its radius of the place.
  std::optional<float> distance(float growth) {
    for (std::uint32_t j = 0; j < columns.size; ++j) {
      columns.inverse_radius2[j] = present_inverse2[j] / (growth * growth);
    }
    columns.reach = growth * most_h;
    const MlsValue value = mls_value(columns, {0, columns.size}, depth);
    if (!(value.weight > 0)) return std::nullopt;
    return value.distance;
  }
};

/// The numbers of points that are tried for a support.
struct Sizes {
  Sizes(float present_size, float least) : present(present_size), least_growth(std::sqrt(least / present)) {
    for (float size = present; count < kMaxSizes && size <= kMaxPoints; size *= kStep) size_of[count++] = size;
  }
  float growth(std::size_t k) const { return std::sqrt(size_of[k] / present); }

  float present;
  float least_growth;
  std::array<float, kMaxSizes> size_of{};
  std::size_t count = 0;
};

/// Of each size, at one place; 0 if none of its samples has surface around it.
using Risks = std::array<double, kMaxSizes>;

/// Measures places, in one thread.
class RiskMeter {
 public:
  static std::size_t bytes() {
    return 2 * (Arena::rounded(kHalfCapacity * sizeof(Half::Point)) + Arena::rounded(kHalfCapacity * sizeof(float)) +
                RayPoints::bytes_needed(kHalfCapacity));
  }
  static Expected<RiskMeter> create(const Cloud& cloud, const KdTree3& tree, const Sizes& sizes, Arena& arena) {
    RiskMeter meter(cloud, tree, sizes);
    for (Half& half : meter.halves_) {
      PLUMBLINE_TRY(arena.take_top(half.points, kHalfCapacity, kStage));
      PLUMBLINE_TRY(arena.take_top(half.present_inverse2, kHalfCapacity, kStage));
      const auto columns = RayPoints::create(kHalfCapacity, arena, kStage);
      PLUMBLINE_TRY(columns);
      half.columns = *columns;
    }
    return meter;
  }

  Risks measure_place(std::uint32_t place) {
    std::array<double, kMaxSizes> variance{};
    std::array<double, kMaxSizes> bias2{};
    std::uint32_t used = 0;
    for (std::uint32_t s = place * kSamples; s < (place + 1) * kSamples; ++s) {
      const std::uint32_t i = cloud_->sampled(s, kPlaces * kSamples);
      if (!cloud_->is_surface(i) || !collect(i)) continue;
      const auto x = project(i);
      if (!x || !measure(*x)) continue;
      ++used;
      const auto [least_a, least_b] = least_;
      for (std::size_t k = 0; k < sizes_->count; ++k) {
        const auto [a, b] = values_[k];
        variance[k] += (a - b) * (a - b) / 4;
        bias2[k] += (a - least_a) * (b - least_b);
      }
    }
    Risks risk{};
    for (std::size_t k = 0; used > 0 && k < sizes_->count; ++k) {
      risk[k] = std::sqrt((variance[k] + std::max(0.0, bias2[k])) / used);
    }
    return risk;
  }

 private:
  RiskMeter(const Cloud& cloud, const KdTree3& tree, const Sizes& sizes)
      : cloud_(&cloud), tree_(&tree), sizes_(&sizes) {}

  /// Fills the halves with all points whose widest supports may contain point i.
  /// @returns false if there are too many
  bool collect(std::uint32_t i) {
    const float search_radius = kRadiusMargin * std::sqrt(kMaxPoints / sizes_->present) * cloud_->radius[i];
    for (Half& half : halves_) half.size = 0;
    bool room = true;
    for_neighbourhood(*cloud_, *tree_, i, i + 1, search_radius, [&](const Neighbourhood& batch) {
      for (std::uint32_t j = 0; j < batch.size; ++j) {
        if (batch.type[j] == static_cast<std::int32_t>(PointClass::kNoise)) continue;
        Half& half = halves_[batch.index[j] % 2];
        if (half.size == kHalfCapacity) {
          room = false;
          continue;
        }
        half.points[half.size++] = {Vec3f(batch.x[j], batch.y[j], batch.z[j]),
                                    Vec3f(batch.nx[j], batch.ny[j], batch.nz[j]), cloud_->radius[batch.index[j]]};
      }
    });
    return room;
  }

  /// F of both halves at x, mm, with supports of all sizes and of the least.
  /// @returns false if the least supports contain no point
  bool measure(const Vec3f& x) {
    for (std::size_t h = 0; h < halves_.size(); ++h) {
      halves_[h].go_to(x, sizes_->growth(sizes_->count - 1));
      for (std::size_t k = 0; k < sizes_->count; ++k)
        values_[k][h] = halves_[h].distance(sizes_->growth(k)).value_or(0);
      const auto least = halves_[h].distance(sizes_->least_growth);
      if (!least) return false;
      least_[h] = *least;
    }
    return true;
  }

  /// Moves point i onto the mean of the surfaces of both halves.
  std::optional<Vec3f> project(std::uint32_t i) {
    const Vec3f n = cloud_->normal[i].unpack();
    const float growth = std::sqrt(kProjectionPoints / sizes_->present);
    Vec3f x = cloud_->position[i];
    for (int step = 0; step < kProjectionSteps; ++step) {
      for (Half& half : halves_) half.go_to(x, growth);
      const auto a = halves_[0].distance(growth);
      const auto b = halves_[1].distance(growth);
      if (!a || !b) return std::nullopt;
      x = x - n * (0.5F * (*a + *b));
    }
    return x;
  }

  const Cloud* cloud_;
  const KdTree3* tree_;
  const Sizes* sizes_;
  std::array<Half, 2> halves_;
  std::array<std::array<double, 2>, kMaxSizes> values_{};  ///< by size and half, mm
  std::array<double, 2> least_{};
};

}  // namespace

std::size_t support_size_bytes(std::uint32_t threads) {
  return Arena::rounded(threads * sizeof(RiskMeter)) + threads * RiskMeter::bytes();
}

Status widen_supports(Cloud& cloud, const KdTree3& tree, Arena& arena, const StageProgress& progress) {
  const float present = cloud.support_points;
  if (!(present > kCleanSupport) || cloud.size < kPlaces * kSamples) return {};
  const ArenaScope scope(arena);
  const Sizes sizes(present, kCleanSupport);
  const auto meters = arena.take_top<RiskMeter>(static_cast<std::size_t>(omp_get_max_threads()), kStage);
  PLUMBLINE_TRY(meters);
  for (RiskMeter& meter : *meters) {
    const auto created = RiskMeter::create(cloud, tree, sizes, arena);
    PLUMBLINE_TRY(created);
    meter = *created;
  }
  Risks sum{};
  for (std::uint32_t first = 0; first < kPlaces; first += kTogether) {
    if (!progress.advance(1.0 * first / kPlaces)) {
      return fail(ErrorCode::kCancelled, "cancelled while supports were sized");
    }
    std::array<Risks, kTogether> risks;
#pragma omp parallel for schedule(dynamic, 1)
    for (std::uint32_t k = 0; k < kTogether; ++k) {
      risks[k] = (*meters)[static_cast<std::size_t>(omp_get_thread_num())].measure_place(first + k);
    }
    // Always in the order of the places.
    for (const Risks& risk : risks) {
      for (std::size_t k = 0; k < sizes.count; ++k) sum[k] += risk[k];
    }
  }
  const double least = *std::min_element(sum.begin(), sum.begin() + sizes.count);
  std::size_t best = 0;
  while (sum[best] > kRiskTolerance * least) ++best;
  cloud.set_support_points(sizes.size_of[best]);
  return {};
}

}  // namespace plumbline
