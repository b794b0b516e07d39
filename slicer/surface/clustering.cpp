#include "slicer/surface/clustering.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "slicer/cloud/nearest_by_radius.hpp"
#include "slicer/cloud/neighbourhood.hpp"
#include "slicer/core/loop_progress.hpp"
#include "slicer/core/numbers/lanes.hpp"
#include "slicer/core/numbers/median.hpp"
#include "slicer/surface/sparse_surface.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "clustering";

/// Least number of points within epsilon that measure a density. With fewer, the distances of the nearest points do.
constexpr std::int32_t kFewNeighbours = 8;
// Noise over epsilon, without curvature, between which supports grow from the least to the most points.
constexpr float kCleanNoise = 0.02F;
constexpr float kFullNoise = 0.096F;

constexpr float kUsualSupport = 1.15F;  ///< epsilons
constexpr float kUsualPoints = 40;      ///< of a support of .8 epsilon; wider ones may be wider in proportion

/// Share of the 2 minPts points within epsilon of the median point that face its way where there is a surface. Scans
/// have 0.6 to 1, a sphere of 150 points 0.43; random normals have 1/8 by the metric, normals fitted to random points
/// 0.3.
constexpr float kFacingShare = 0.4F;

/// Kept apart from the classes: a point's type must not change while others compare with it.
enum Flag : std::uint8_t { kCore = 1, kDense = 2, kNoisePoint = 4, kSparse = 8 };

/// For the pass in which other threads mark noise in the same byte.
bool is_core(std::uint8_t& flag) { return (std::atomic_ref(flag).load(std::memory_order_relaxed) & kCore) != 0; }

Within compare(const Member& m, const Neighbourhood& batch, std::uint32_t j) {
  const float dx = batch.x[j] - m.position[0];
  const float dy = batch.y[j] - m.position[1];
  const float dz = batch.z[j] - m.position[2];
  return {dx * dx + dy * dy + dz * dz,
          batch.nx[j] * m.normal[0] + batch.ny[j] * m.normal[1] + batch.nz[j] * m.normal[2]};
}

struct Counts {
  std::int32_t near = 0;       ///< points within epsilon by the thesis' metric
  std::int32_t same_type = 0;  ///< those of the same type
  std::int32_t sheet = 0;      ///< points within epsilon by the Euclidean metric that face the same way
  float offset = 0;            ///< sum over `near` of the point's height above their tangent planes, mm
  float depth = 0;             ///< sum over `near` of their depth below the point's own tangent plane, mm

  float mean(float sum) const { return std::abs(sum) / static_cast<float>(std::max(1, near)); }
};

PLUMBLINE_WIDE void count(const Member& m, const Neighbourhood& batch, float epsilon2, Counts& counts) {
  IntLanes near{};
  IntLanes same_type{};
  IntLanes sheet{};
  Lanes offset{};
  Lanes depth{};
  for (std::uint32_t j = 0; j < batch.size; j += kLanes) {
    NeighbourLanes p;
    load(p, batch, j);
    const Lanes dx = m.position[0] - p.x;
    const Lanes dy = m.position[1] - p.y;
    const Lanes dz = m.position[2] - p.z;
    const Lanes distance2 = dx * dx + dy * dy + dz * dz;
    const Lanes cosine = p.nx * m.normal[0] + p.ny * m.normal[1] + p.nz * m.normal[2];
    const Lanes height = dx * p.nx + dy * p.ny + dz * p.nz;
    const Lanes below = dx * m.normal[0] + dy * m.normal[1] + dz * m.normal[2];
    const IntLanes facing = cosine > 0.0F;
    const IntLanes is_near = facing & (distance2 <= epsilon2 * cosine * cosine);
    near -= is_near;
    Lanes near_height, near_depth;
    choose(near_height, is_near, height, Lanes{});
    choose(near_depth, is_near, below, Lanes{});
    offset += near_height;
    depth += near_depth;
    same_type -= is_near & (p.type == m.type);
    sheet -= facing & (distance2 <= epsilon2);
  }
  counts.near += sum(near);
  counts.same_type += sum(same_type);
  counts.sheet += sum(sheet);
  counts.offset += sum(offset);
  counts.depth += sum(depth);
}

class Clusterer {
 public:
  Clusterer(Cloud& cloud, const KdTree3& tree, float epsilon, SparseSurface sparse)
      : cloud_(cloud), tree_(tree), epsilon_(epsilon), sparse_(sparse), noise_step_(cloud.size / kMedianSample + 1) {}

  Expected<ClusteringResult> run(Arena& arena, const StageProgress& progress) {
    PLUMBLINE_TRY(allocate(arena));
    for (PackedNormal& normal : cloud_.normal.first(cloud_.size)) normal.point_class = orientation_of(normal);
    if (!measure(progress.part(0, 0.6)) || !find_noise(progress.part(0.6, 1))) {
      return fail(ErrorCode::kCancelled, "cancelled while clusters were found");
    }
    return finish();
  }

 private:
  Status allocate(Arena& arena) {
    PLUMBLINE_TRY(arena.take_top(flags_, cloud_.size, kStage));
    PLUMBLINE_TRY(arena.take_top(heights_, (cloud_.size + noise_step_ - 1) / noise_step_, kStage));
    PLUMBLINE_TRY(arena.take_top(level_heights_, heights_.size(), kStage));
    PLUMBLINE_TRY(arena.take_top(near_, heights_.size(), kStage));
    return {};
  }

  /// Finds core points, and the density and noise of the surface around each point. Sets radius[] to that of one
  /// point's share.
  bool measure(const StageProgress& progress) {
    cloud_.support_points = 1;
    const auto measure_block = [&](std::uint32_t begin, std::uint32_t end) {
      const float epsilon2 = epsilon_ * epsilon_;
      std::array<Counts, kSharedSearch> counts{};
      for_neighbourhood(cloud_, tree_, begin, end, epsilon_, [&](const Neighbourhood& batch) {
        for (std::uint32_t i = begin; i < end; ++i) count(member(cloud_, i), batch, epsilon2, counts[i - begin]);
      });
      for (std::uint32_t i = begin; i < end; ++i) evaluate(i, counts[i - begin]);
    };
    if (!for_blocks(cloud_.size, kSharedSearch, progress, measure_block)) return false;
    coherent_ = static_cast<float>(median(near_)) >= kFacingShare * 2 * static_cast<float>(kMinPts);
    return true;
  }

  void evaluate(std::uint32_t i, const Counts& c) {
    constexpr auto kMinNear = static_cast<std::int32_t>(kMinPts);
    const bool dense = c.near >= kMinNear;
    const bool core = c.near > kMinNear && c.same_type > kSameTypeShare * c.near;
    flags_[i] = static_cast<std::uint8_t>((core ? kCore : 0) | (dense ? kDense : 0));
    cloud_.radius[i] = epsilon_ / std::sqrt(static_cast<float>(std::max(1, c.sheet)));
    if (i % noise_step_ == 0) {
      heights_[i / noise_step_] = c.mean(c.offset);
      level_heights_[i / noise_step_] = c.mean(0.5F * (c.offset + c.depth));
      near_[i / noise_step_] = c.near;
    }
    if (sparse_ == SparseSurface::kNoise) return;
    if (c.near >= kFewNeighbours) {
      // A point beside a sheet is an outlier, such as a flying pixel, however many neighbours it has on the sheet.
      const bool on_sheet = std::abs(c.offset) < kMostHeight * epsilon_ * static_cast<float>(c.near);
      if (on_sheet) flags_[i] |= kSparse;
    } else if (const auto share = sparse_share(cloud_, tree_, i, epsilon_)) {
      flags_[i] |= kSparse;
      cloud_.radius[i] = std::max(cloud_.radius[i], *share);
    }
  }

  /// Finds the points that are neither dense, nor sparse surface, nor within epsilon of a core point of their type.
  bool find_noise(const StageProgress& progress) {
    // Sparse surface belongs to a dense one. Among outliers a few always happen to face the same way.
    const int kept = coherent_ ? kCore | kDense | kSparse : kCore | kDense;
    const auto is_kept = [&](std::uint32_t i) { return (flags_[i] & kept) != 0; };
    return for_blocks(cloud_.size, kSharedSearch, progress, [&](std::uint32_t begin, std::uint32_t end) {
      Box3f box;
      for (std::uint32_t i = begin; i < end; ++i) {
        if (!is_kept(i)) box.extend(cloud_.position[i]);
      }
      if (box.empty()) return;
      std::array<bool, kSharedSearch> joins{};
      for_neighbourhood(cloud_, tree_, box, epsilon_, [&](const Neighbourhood& batch) {
        for (std::uint32_t i = begin; i < end; ++i) {
          if (is_kept(i)) continue;
          const Member m = member(cloud_, i);
          for (std::uint32_t j = 0; j < batch.size && !joins[i - begin]; ++j) {
            joins[i - begin] = batch.type[j] == m.type && compare(m, batch, j).near(epsilon_ * epsilon_) &&
                               is_core(flags_[batch.index[j]]);
          }
        }
      });
      for (std::uint32_t i = begin; i < end; ++i) {
        if (is_kept(i) || joins[i - begin]) continue;
        std::atomic_ref(flags_[i]).fetch_or(kNoisePoint, std::memory_order_relaxed);
      }
    });
  }

  ClusteringResult finish() {
    ClusteringResult result;
    result.epsilon = epsilon_;
    result.coherent = coherent_;
    result.noise = static_cast<float>(kMedianToDeviation) * median(heights_);
    const float level_noise = static_cast<float>(kMedianToDeviation) * median(level_heights_);
    const float noisy = std::clamp((level_noise / epsilon_ - kCleanNoise) / (kFullNoise - kCleanNoise), 0.0F, 1.0F);
    cloud_.set_support_points(kCleanSupport + noisy * (kNoisySupport - kCleanSupport));
    for (std::uint32_t i = 0; i < cloud_.size; ++i) {
      if ((flags_[i] & kNoisePoint) != 0) cloud_.normal[i].point_class = PointClass::kNoise;
      if ((flags_[i] & kCore) != 0) ++result.core_points;
    }
    result.points = count_classes(cloud_.normal.first(cloud_.size));
    return result;
  }

  Cloud& cloud_;
  const KdTree3& tree_;
  float epsilon_;
  SparseSurface sparse_;
  std::uint32_t noise_step_;  ///< step between points at which the noise is measured
  std::span<std::uint8_t> flags_;
  std::span<float> heights_;  ///< of the samples, over the planes of their neighbours, mm
  // Means of the height over the neighbours' planes and of their depth below the sample's own, mm. Curvature cancels; noise does not.
  // Where points are few, most of a height is curvature, and supports widened by it bridge gaps.
  std::span<float> level_heights_;
  std::span<std::int32_t> near_;  ///< points near the samples
  bool coherent_ = true;
};

}  // namespace

float usual_support(float epsilon, float support_points) {
  return kUsualSupport * epsilon * std::sqrt(std::max(1.0F, support_points / kUsualPoints));
}

Expected<float> density_epsilon(const Cloud& cloud, const KdTree3& tree, Arena& arena, std::uint32_t most_samples) {
  const ArenaScope scope(arena);
  constexpr std::uint32_t kMost = std::tuple_size_v<NearestRoom> / 2;
  const std::uint32_t wanted = std::min({2 * kMinPts + 1, cloud.size, kMost});  // the point itself is one
  const std::uint32_t samples = std::min(most_samples, cloud.size);
  if (wanted < 2) return 0.0F;
  std::span<float> d2;
  PLUMBLINE_TRY(arena.take_top(d2, samples, kStage));
#pragma omp parallel
  {
    NearestRoom room;
    float radius = 0;
#pragma omp for schedule(dynamic, 64)
    for (std::uint32_t s = 0; s < samples; ++s) {
      const std::uint32_t i = cloud.sampled(s, samples);
      const auto nearest = nearest_by_radius(tree, cloud.position[i], radius, wanted, room, NearestOrder::kOfSearch,
                                             [](std::uint32_t) { return true; });
      d2[s] = std::max_element(nearest.begin(), nearest.end())->distance2;
      radius = 1.3F * std::sqrt(d2[s]);  // the next sample lies near, where the density is about the same
    }
  }
  std::sort(d2.begin(), d2.end());
  return (std::sqrt(d2[samples / 2]) + std::sqrt(d2[(samples - 1) / 2])) / 2;
}

std::size_t clustering_bytes(std::uint32_t points) {
  const std::size_t samples = std::min(points, kMedianSample);
  return Arena::rounded(points) + 2 * Arena::rounded(samples * sizeof(float)) +
         Arena::rounded(samples * sizeof(std::int32_t));
}

Expected<ClusteringResult> cluster(Cloud& cloud, const KdTree3& tree, float epsilon, Arena& arena,
                                   const StageProgress& progress, SparseSurface sparse) {
  const ArenaScope scope(arena);
  return Clusterer(cloud, tree, epsilon, sparse).run(arena, progress);
}

}  // namespace plumbline::inline slicer
