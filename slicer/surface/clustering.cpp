#include "slicer/surface/clustering.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "slicer/cloud/neighbourhood.hpp"
#include "slicer/core/disjoint_sets.hpp"
#include "slicer/core/loop_progress.hpp"
#include "slicer/core/median.hpp"
#include "slicer/surface/sparse_surface.hpp"

namespace plumbline {
namespace {

constexpr std::uint32_t kBlock = kSharedSearch;

constexpr const char* kStage = "clustering";

constexpr std::int32_t kFewNeighbours = 8;  ///< fewer within epsilon do not measure a density
/// A point is on the sheet of its neighbours if its mean height over their planes is at most this share of epsilon.
constexpr float kOnSheet = 0.2F;
constexpr std::uint32_t kNoiseSample = 16384;
constexpr float kCleanNoise = 0.02F;  ///< of epsilon: below, what looks like noise is mostly curvature
constexpr float kFullNoise = 0.1F;    ///< of epsilon: from here on the support has its full size

/// Of the 2 minPts neighbours that epsilon holds round the median point this share faces the same way where there is a
/// surface: scans have 0.6 to 1, a sphere of 150 points 0.43. Of normals at random, weighed by the metric, it is an
/// eighth; of normals fitted to points at random 0.3.
constexpr float kFacingShare = 0.4F;

/// Kept beside the classes, because a point's type must not change while others still compare with it.
enum Flag : std::uint8_t { kCore = 1, kDense = 2, kOutlier = 4, kThin = 8 };

/// For the pass in which other threads mark outliers in the same byte.
bool is_core(std::uint8_t& flag) { return (std::atomic_ref(flag).load(std::memory_order_relaxed) & kCore) != 0; }

Within compare(const Member& m, const Neighbourhood& batch, std::uint32_t j) {
  const float dx = batch.x[j] - m.position[0];
  const float dy = batch.y[j] - m.position[1];
  const float dz = batch.z[j] - m.position[2];
  return {dx * dx + dy * dy + dz * dz,
          batch.nx[j] * m.normal[0] + batch.ny[j] * m.normal[1] + batch.nz[j] * m.normal[2]};
}

struct Counts {
  std::int32_t near = 0;       ///< within epsilon by the thesis' metric
  std::int32_t same_type = 0;  ///< of those, of the same type
  std::int32_t sheet = 0;      ///< within epsilon by the plain metric, facing the same way
  float offset = 0;            ///< sum over `near` of the point's height above their tangent planes, mm
};

void count(const Member& m, const Neighbourhood& batch, float epsilon2, Counts& counts) {
  std::int32_t near = 0;
  std::int32_t same_type = 0;
  std::int32_t sheet = 0;
  std::array<float, 8> offset{};  // partial sums in a fixed order, for vector units
  for (std::uint32_t j = 0; j < batch.size; ++j) {
    const Within w = compare(m, batch, j);
    const float height = (m.position[0] - batch.x[j]) * batch.nx[j] + (m.position[1] - batch.y[j]) * batch.ny[j] +
                         (m.position[2] - batch.z[j]) * batch.nz[j];
    const std::int32_t facing = static_cast<std::int32_t>(w.cosine > 0);
    const std::int32_t is_near = facing & static_cast<std::int32_t>(w.distance2 <= epsilon2 * w.cosine * w.cosine);
    near += is_near;
    offset[j % 8] += is_near != 0 ? height : 0.0F;
    same_type += is_near & static_cast<std::int32_t>(batch.type[j] == m.type);
    sheet += facing & static_cast<std::int32_t>(w.distance2 <= epsilon2);
  }
  counts.near += near;
  counts.same_type += same_type;
  counts.sheet += sheet;
  for (const float part : offset) counts.offset += part;
}

tl::unexpected<Error> cancelled() { return fail(ErrorCode::kCancelled, "cancelled while clusters were found"); }

}  // namespace

PointClass orientation_of(const PackedNormal& normal) {
  const float along = static_cast<float>(normal.z) / PackedNormal::kScale;
  if (along > kNeutralSine) return PointClass::kExiting;
  if (along < -kNeutralSine) return PointClass::kEntering;
  return PointClass::kNeutral;
}

std::uint32_t points_of_surface(const ClusteringResult& clustering) {
  std::uint32_t points = 0;
  for (const PointClass c : {PointClass::kEntering, PointClass::kExiting, PointClass::kNeutral}) {
    points += clustering.points[static_cast<std::size_t>(c)];
  }
  return points;
}

bool hardly_any(const ClusteringResult& clustering, PointClass point_class) {
  constexpr std::uint64_t kOneIn = 1000;
  return kOneIn * clustering.points[static_cast<std::size_t>(point_class)] <= points_of_surface(clustering);
}

Expected<float> density_epsilon(const Cloud& cloud, const KdTree3& tree, const ClusteringSettings& settings,
                                Arena& arena) {
  const ArenaScope scope(arena);
  const std::uint32_t wanted = std::min(2 * settings.min_points + 1, cloud.size);  // the point itself comes first
  const std::uint32_t samples = std::min(settings.epsilon_sample, cloud.size);
  if (wanted < 2) return 0.0F;
  auto distances = arena.take_top<float>(samples, kStage);
  if (!distances) return tl::unexpected<Error>(distances.error());
  std::span<float> d2 = *distances;
#pragma omp parallel for schedule(dynamic, 64)
  for (std::uint32_t s = 0; s < samples; ++s) {
    std::array<Neighbour, 256> found;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const auto i = static_cast<std::uint32_t>(std::uint64_t{s} * cloud.size / samples);
    const std::uint32_t k = tree.nearest(cloud.position[i], std::span(found).first(std::min<std::size_t>(wanted, 256)));
    d2[s] = found[k - 1].distance2;
  }
  std::sort(d2.begin(), d2.end());
  return (std::sqrt(d2[samples / 2]) + std::sqrt(d2[(samples - 1) / 2])) / 2;
}

Expected<ClusteringResult> cluster(Cloud& cloud, const KdTree3& tree, float epsilon, const ClusteringSettings& settings,
                                   std::span<std::uint32_t> cluster, Arena& arena, const StageProgress& progress) {
  const ArenaScope scope(arena);
  const std::uint32_t size = cloud.size;
  auto parent = arena.take_top<std::uint32_t>(size, kStage);
  if (!parent) return tl::unexpected<Error>(parent.error());
  auto flag_bytes = arena.take_top<std::uint8_t>(size, kStage);
  if (!flag_bytes) return tl::unexpected<Error>(flag_bytes.error());
  std::span<std::uint8_t> flags = *flag_bytes;
  DisjointSets sets(*parent);
  sets.start_all();

  const float epsilon2 = epsilon * epsilon;
  const std::uint32_t blocks = (size + kBlock - 1) / kBlock;
  const auto min_points = static_cast<std::int32_t>(settings.min_points);
  for (std::uint32_t i = 0; i < size; ++i) cloud.normal[i].point_class = orientation_of(cloud.normal[i]);

  const std::uint32_t noise_step = size / kNoiseSample + 1;
  auto height_block = arena.take_top<float>((size + noise_step - 1) / noise_step, kStage);
  if (!height_block) return tl::unexpected<Error>(height_block.error());
  std::span<float> heights = *height_block;
  auto near_block = arena.take_top<std::int32_t>(heights.size(), kStage);
  if (!near_block) return tl::unexpected<Error>(near_block.error());
  std::span<std::int32_t> sampled_near = *near_block;

  // Who is core, how dense the surface is, and how far its points lie off it. radius[] is that of one point's share first.
  LoopProgress counting(progress.part(0, 0.5), blocks);
#pragma omp parallel for schedule(dynamic, 64)
  for (std::uint32_t b = 0; b < blocks; ++b) {
    if (!counting.step(b)) continue;
    const std::uint32_t first = b * kBlock;
    const std::uint32_t last = std::min(size, first + kBlock);
    std::array<Counts, kBlock> counts{};
    for_neighbourhood(cloud, tree, first, last, epsilon, [&](const Neighbourhood& batch) {
      for (std::uint32_t i = first; i < last; ++i) count(member(cloud, i), batch, epsilon2, counts[i - first]);
    });
    for (std::uint32_t i = first; i < last; ++i) {
      const Counts& c = counts[i - first];
      const bool dense = c.near >= min_points;
      const bool core = c.near > min_points && c.same_type > settings.same_type_share * c.near;
      flags[i] = static_cast<std::uint8_t>((core ? kCore : 0) | (dense ? kDense : 0));
      cloud.radius[i] = epsilon / std::sqrt(static_cast<float>(std::max(1, c.sheet)));
      if (i % noise_step == 0) {
        heights[i / noise_step] = std::abs(c.offset) / static_cast<float>(std::max(1, c.near));
        sampled_near[i / noise_step] = c.near;
      }
      if (c.near >= kFewNeighbours) {
        // Beside a sheet, not on it: a stray or a flying pixel, however many neighbours the sheet lends it.
        const bool on_sheet = std::abs(c.offset) < kOnSheet * epsilon * static_cast<float>(c.near);
        if (settings.thin_reach > 0 && on_sheet) flags[i] |= kThin;
      } else {
        // The surface is thinly scanned here or there is none: the nearest points tell how far apart they lie.
        const auto radius = thin_surface_radius(cloud, tree, i, epsilon, settings);
        if (radius) {
          flags[i] |= kThin;
          cloud.radius[i] = std::max(cloud.radius[i], *radius);
        }
      }
    }
  }

  if (counting.stopped()) return cancelled();
  const bool coherent =
      static_cast<float>(median(std::span(sampled_near))) >= kFacingShare * 2 * static_cast<float>(settings.min_points);
  // Thin surface is a part of one. Among strays a few always happen to face the same way: no reason to keep them.
  const int kept_flags = coherent ? kDense | kThin : kDense;

  // Core points within epsilon of one another are one cluster.
  const std::uint32_t blocks_to_join = cluster.empty() ? 0 : blocks;
  LoopProgress joining(progress.part(0.5, 0.8), blocks);
#pragma omp parallel for schedule(dynamic, 64)
  for (std::uint32_t b = 0; b < blocks_to_join; ++b) {
    if (!joining.step(b)) continue;
    const std::uint32_t first = b * kBlock;
    const std::uint32_t last = std::min(size, first + kBlock);
    for_neighbourhood(cloud, tree, first, last, epsilon, [&](const Neighbourhood& batch) {
      for (std::uint32_t i = first; i < last; ++i) {
        if ((flags[i] & kCore) == 0) continue;
        const Member m = member(cloud, i);
        std::array<std::uint8_t, Neighbourhood::kMost> near;  // NOLINT(cppcoreguidelines-pro-type-member-init)
        for (std::uint32_t j = 0; j < batch.size; ++j) {
          const Within w = compare(m, batch, j);
          near[j] = static_cast<std::uint8_t>(w.near(epsilon2) & (batch.type[j] == m.type));
        }
        for (std::uint32_t j = 0; j < batch.size; ++j) {
          const std::uint32_t other = batch.index[j];
          if (near[j] != 0 && other < i && (flags[other] & kCore) != 0) sets.unite_shared(i, other);
        }
      }
    });
  }

  if (joining.stopped()) return cancelled();

  // The others join the nearest core point of their type.
  LoopProgress assigning(progress.part(0.8, 1), blocks);
#pragma omp parallel for schedule(dynamic, 64)
  for (std::uint32_t b = 0; b < blocks; ++b) {
    if (!assigning.step(b)) continue;
    const std::uint32_t first = b * kBlock;
    const std::uint32_t last = std::min(size, first + kBlock);
    const bool all_core =
        std::all_of(flags.begin() + first, flags.begin() + last, [](std::uint8_t f) { return (f & kCore) != 0; });
    std::array<std::uint32_t, kBlock> nearest;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    nearest.fill(kNoCluster);
    if (!all_core) {
      std::array<float, kBlock> best{};
      for_neighbourhood(cloud, tree, first, last, epsilon, [&](const Neighbourhood& batch) {
        for (std::uint32_t i = first; i < last; ++i) {
          if ((flags[i] & kCore) != 0) continue;
          const Member m = member(cloud, i);
          for (std::uint32_t j = 0; j < batch.size; ++j) {
            const Within w = compare(m, batch, j);
            if (!w.near(epsilon2) || batch.type[j] != m.type || !is_core(flags[batch.index[j]])) continue;
            const float distance2 = w.distance2 / (w.cosine * w.cosine);
            std::uint32_t& at = nearest[i - first];
            float& least = best[i - first];
            if (at == kNoCluster || distance2 < least || (distance2 == least && batch.index[j] < at)) {
              at = batch.index[j];
              least = distance2;
            }
          }
        }
      });
    }
    for (std::uint32_t i = first; i < last; ++i) {
      const std::uint32_t core = (flags[i] & kCore) != 0 ? i : nearest[i - first];
      if (!cluster.empty()) cluster[i] = core == kNoCluster ? kNoCluster : sets.root(core);
      if (core == kNoCluster && (flags[i] & kept_flags) == 0)
        std::atomic_ref(flags[i]).fetch_or(kOutlier, std::memory_order_relaxed);
    }
  }

  if (assigning.stopped()) return cancelled();

  ClusteringResult result;
  result.epsilon = epsilon;
  result.coherent = coherent;
  result.noise = static_cast<float>(kMedianToDeviation) * median(std::span(heights));
  const float noisy = std::clamp((result.noise / epsilon - kCleanNoise) / (kFullNoise - kCleanNoise), 0.0F, 1.0F);
  result.support_points = settings.least_support + noisy * (settings.most_support - settings.least_support);
  const float growth = std::sqrt(result.support_points);
  for (float& radius : cloud.radius.first(size)) radius *= growth;
  for (std::uint32_t i = 0; i < size; ++i) {
    const bool core = (flags[i] & kCore) != 0;
    if ((flags[i] & kOutlier) != 0) cloud.normal[i].point_class = PointClass::kNoise;
    ++result.points[static_cast<std::size_t>(cloud.normal[i].point_class)];
    if (core) ++result.core_points;
    if (core && !cluster.empty() && sets.is_root(i)) ++result.clusters;
  }
  return result;
}

}  // namespace plumbline
