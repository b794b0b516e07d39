#include "slicer/surface/support_size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "slicer/cloud/neighbourhood.hpp"
#include "slicer/implicit/mls.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "support size";

constexpr float kStep = 1.25F;          ///< from size to size
constexpr float kMostPoints = 160;      ///< of a support: the time that rays take grows with it
constexpr std::size_t kSizes = 10;      ///< steps from the narrowest supports to the widest
constexpr std::uint32_t kPlaces = 128;  ///< as few as a place needs to have a mean, as many as make one of all
constexpr std::uint32_t kSamples = 32;  ///< a place: points that are evenly spread over a part of the tree
constexpr double kAsGood = 1.02;        ///< times the least risk
constexpr float kProjection = 60;       ///< points of the supports by which a sample is put on the surface
constexpr int kProjections = 2;
constexpr float kReachMargin = 1.2F;   ///< radii of neighbours differ by less
constexpr std::uint32_t kRoom = 1024;  ///< points of half a scan round a sample; where there are more it is left out

/// Every other point round a sample.
struct Half {
  struct Point {
    Vec3f position;
    Vec3f normal;
    float h;  ///< mm, of the present support
  };
  std::span<Point> points;
  RayPoints columns;
  std::uint32_t size = 0;

  /// F at x, mm, with supports `growth` times as wide as now. Nothing where there is no weight.
  std::optional<float> distance(const Vec3f& x, float growth) {
    columns.size = 0;
    columns.reach = 0;
    for (const Point& p : points.first(size)) {
      const Vec3f d = x - p.position;
      const float h = growth * p.h;
      if (d.dot(d) >= h * h) continue;
      columns.reach = std::max(columns.reach, h);
      columns.add(d[0], d[1], p.position[2], p.normal, 1 / (h * h));
    }
    columns.close();
    const MlsValue value = mls_value(columns, {0, columns.size}, x[2]);
    if (!(value.weight > 0)) return std::nullopt;
    return value.distance;
  }
};

class RiskOfSizes {
 public:
  RiskOfSizes(const Cloud& cloud, const KdTree3& tree, float present, float least, std::array<Half, 2>& halves)
      : cloud_(cloud), tree_(tree), present_(present), halves_(halves) {
    for (float size = present; count_ < kSizes && size <= kMostPoints; size *= kStep) sizes_[count_++] = size;
    least_growth_ = std::sqrt(least / present);
  }

  /// @returns whether the samples of this place had surface round them
  bool add_place(std::uint32_t place) {
    std::array<double, kSizes> variance{};
    std::array<double, kSizes> bias2{};
    std::uint32_t used = 0;
    for (std::uint32_t s = place * kSamples; s < (place + 1) * kSamples; ++s) {
      const auto i = static_cast<std::uint32_t>(std::uint64_t{s} * cloud_.size / (kPlaces * kSamples));
      if (cloud_.normal[i].point_class == PointClass::kNoise || !gather(i)) continue;
      const auto x = projected(i);
      if (!x) continue;
      const auto least_a = halves_[0].distance(*x, least_growth_);
      const auto least_b = halves_[1].distance(*x, least_growth_);
      if (!least_a || !least_b) continue;
      ++used;
      for (std::size_t k = 0; k < count_; ++k) {
        const float growth = std::sqrt(sizes_[k] / present_);
        const double a = *halves_[0].distance(*x, growth);
        const double b = *halves_[1].distance(*x, growth);
        variance[k] += (a - b) * (a - b) / 4;
        bias2[k] += (a - static_cast<double>(*least_a)) * (b - static_cast<double>(*least_b));
      }
    }
    if (used == 0) return false;
    for (std::size_t k = 0; k < count_; ++k) risk_[k] += std::sqrt((variance[k] + std::max(0.0, bias2[k])) / used);
    return true;
  }

  /// @returns points
  float best_size() const {
    const double least = *std::min_element(risk_.begin(), risk_.begin() + static_cast<std::ptrdiff_t>(count_));
    std::size_t k = 0;
    while (risk_[k] > kAsGood * least) ++k;
    return sizes_[k];
  }

 private:
  /// Fills the halves with all points whose widest supports may reach point i.
  bool gather(std::uint32_t i) {
    const float reach = kReachMargin * std::sqrt(kMostPoints / present_) * cloud_.radius[i];
    for (Half& half : halves_) half.size = 0;
    bool room = true;
    for_neighbourhood(cloud_, tree_, i, i + 1, reach, [&](const Neighbourhood& batch) {
      for (std::uint32_t j = 0; j < batch.size; ++j) {
        if (batch.type[j] == static_cast<std::int32_t>(PointClass::kNoise)) continue;
        Half& half = halves_[batch.index[j] % 2];
        if (half.size == kRoom) {
          room = false;
          continue;
        }
        half.points[half.size++] = {Vec3f(batch.x[j], batch.y[j], batch.z[j]),
                                    Vec3f(batch.nx[j], batch.ny[j], batch.nz[j]), cloud_.radius[batch.index[j]]};
      }
    });
    return room;
  }

  /// Point i on the surface of both halves.
  std::optional<Vec3f> projected(std::uint32_t i) {
    const Vec3f n = cloud_.normal[i].unpack();
    const float growth = std::sqrt(kProjection / present_);
    Vec3f x = cloud_.position[i];
    for (int step = 0; step < kProjections; ++step) {
      const auto a = halves_[0].distance(x, growth);
      const auto b = halves_[1].distance(x, growth);
      if (!a || !b) return std::nullopt;
      x = x - n * (0.5F * (*a + *b));
    }
    return x;
  }

  const Cloud& cloud_;
  const KdTree3& tree_;
  float present_;
  float least_growth_ = 1;
  std::array<Half, 2>& halves_;
  std::array<float, kSizes> sizes_{};
  std::size_t count_ = 0;
  std::array<double, kSizes> risk_{};
};

}  // namespace

std::size_t support_size_bytes() {
  return 2 * (Arena::rounded(kRoom * sizeof(Half::Point)) + RayPoints::bytes_needed(kRoom));
}

Status widen_supports(Cloud& cloud, const KdTree3& tree, const ClusteringSettings& settings,
                      ClusteringResult& clustering, Arena& arena, const StageProgress& progress) {
  const float present = clustering.support_points;
  if (!(present > settings.least_support) || cloud.size < kPlaces * kSamples) return {};
  const ArenaScope scope(arena);
  std::array<Half, 2> halves;
  for (Half& half : halves) {
    const auto points = arena.take_top<Half::Point>(kRoom, kStage);
    PLUMBLINE_TRY(points);
    half.points = *points;
    const auto columns = RayPoints::create(kRoom, arena, kStage);
    PLUMBLINE_TRY(columns);
    half.columns = *columns;
  }
  RiskOfSizes risk(cloud, tree, present, settings.least_support, halves);
  bool any = false;
  for (std::uint32_t place = 0; place < kPlaces; ++place) {
    if (!progress.advance(1.0 * place / kPlaces))
      return fail(ErrorCode::kCancelled, "cancelled while supports were sized");
    any |= risk.add_place(place);
  }
  if (!any) return {};
  clustering.support_points = risk.best_size();
  const float growth = std::sqrt(clustering.support_points / present);
  for (float& radius : cloud.radius.first(cloud.size)) radius *= growth;
  return {};
}

}  // namespace plumbline
