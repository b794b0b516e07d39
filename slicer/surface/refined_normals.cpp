#include "slicer/surface/refined_normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slicer/cloud/neighbourhood.hpp"
#include "slicer/cloud/tangent_plane.hpp"
#include "slicer/core/loop_progress.hpp"
#include "slicer/core/numbers/lanes.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/surface/sparse_surface.hpp"

namespace plumbline::inline slicer {
namespace {

// Points of a plane: more average noise out, fewer keep detail.
constexpr float kPlanePoints = 26;  ///< for a scanner's normal; best IoU of the test scans: slicer/EXPERIMENTS.md
constexpr float kPlaneSupports = 5.0F / 3;  ///< for an estimated normal, as a multiple of support_points
constexpr std::uint32_t kMinPoints = 6;     ///< of a plane; it has three unknowns
constexpr float kMinSide = 0.2F;  ///< least mean inner product with the normals around, or the side is not sure
constexpr float kMaxTilt = 1;     ///< tangent of the largest tilt; points of a steeper plane are another sheet
/// Least ratio of the two variances' product to their sum's square: 0.25 for a disc, 0 for a line, which has no plane.
constexpr float kMinWidth2 = 0.05F;
// Distance from the plane of the points that face the same way, beyond which a point is beside the sheet. A third of the points of a
// noisy sheet are farther from it than the noise, and each that is beside costs a search of its own. Walls of bores need it.
constexpr float kMaxOffset = 0.1F;  ///< in epsilons; the noise if that is more
constexpr float kAloneOffset = 2;   ///< times the noise, if hardly any point faces another way
/// Weight of the points that face another way, over that of those that face the same way, up to which it is hardly any.
constexpr float kOtherShare = 0.05F;
/// sum w^2 u^2 / sum w u^2 over a disc with the weights w above; u is the coordinate along one axis of the plane.
constexpr float kWeightsSpread = 0.4F;

/// Weighted moments of the points around one point.
struct Moments {
  std::uint32_t count = 0;
  float weight = 0;
  float others = 0;  ///< weight of the points that face another way, which are in none of the other moments
  Vec3f first = Vec3f::Zero();
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  /// Weighted covariance of the coordinates along a and b, times the weight.
  float covariance(const Vec3f& a, const Vec3f& b) const {
    const Vec3f scatter_b(xx * b[0] + xy * b[1] + xz * b[2], xy * b[0] + yy * b[1] + yz * b[2],
                          xz * b[0] + yz * b[1] + zz * b[2]);
    return a.dot(scatter_b) - first.dot(a) * first.dot(b) / weight;
  }
};

PLUMBLINE_WIDE void add_all(const Member& m, float radius2, const Neighbourhood& batch, Moments& moments) {
  const float inverse2 = 1 / radius2;
  IntLanes count{};
  Lanes weight{};
  Lanes others{};
  Lanes sum_x{}, sum_y{}, sum_z{};
  Lanes xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
  for (std::uint32_t j = 0; j < batch.size; j += kLanes) {
    NeighbourLanes p;
    load(p, batch, j);
    const Lanes x = p.x - m.position[0];
    const Lanes y = p.y - m.position[1];
    const Lanes z = p.z - m.position[2];
    const Lanes t = 1.0F - (x * x + y * y + z * z) * inverse2;
    if (!any(t > 0.0F)) continue;  // most: they are near other points of the block
    const Lanes cosine = p.nx * m.normal[0] + p.ny * m.normal[1] + p.nz * m.normal[2];
    const IntLanes near = (t > 0.0F) & (p.type != static_cast<std::int32_t>(PointClass::kNoise));
    const IntLanes counts = near & (cosine >= kOneWay);
    Lanes all, w;
    choose(all, near, t * t, Lanes{});
    choose(w, counts, all, Lanes{});
    others += all - w;
    const Lanes wx = w * x;
    const Lanes wy = w * y;
    const Lanes wz = w * z;
    count -= counts;
    weight += w;
    sum_x += wx;
    sum_y += wy;
    sum_z += wz;
    xx += wx * x;
    xy += wx * y;
    xz += wx * z;
    yy += wy * y;
    yz += wy * z;
    zz += wz * z;
  }
  moments.count += static_cast<std::uint32_t>(sum(count));
  moments.weight += sum(weight);
  moments.others += sum(others);
  moments.first += Vec3f(sum(sum_x), sum(sum_y), sum(sum_z));
  moments.xx += sum(xx);
  moments.xy += sum(xy);
  moments.xz += sum(xz);
  moments.yy += sum(yy);
  moments.yz += sum(yz);
  moments.zz += sum(zz);
}

/// The normal of the points around a point whose own can't be used, on the side that most of their normals face.
/// @returns the point's own normal if it is an outlier, with fewer than kMinPoints points within kSparseRadius * epsilon; or if the
///          others lie on no plane, don't agree on a side, or are those of a wall's other side
Vec3f fit_normal(TangentPlanes& planes, const Cloud& cloud, const KdTree3& tree, std::uint32_t i, float epsilon) {
  Vec3f own = cloud.normal[i].unpack();
  const float search_radius = kSparseRadius * epsilon;
  std::array<Neighbour, kMinPoints> near;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const auto any = [](std::uint32_t) { return true; };
  if (tree.nearest(cloud.position[i], near, any, search_radius * search_radius) < kMinPoints) return own;
  planes.look_at(i);
  const auto normal = planes.normal();
  if (!normal) return own;
  float side = 0;
  for (const Neighbour& n : planes.points()) side += normal->dot(cloud.normal[n.index].unpack());
  if (std::abs(side) < kMinSide * static_cast<float>(planes.points().size())) return own;
  Vec3f fitted = side > 0 ? *normal : Vec3f(-*normal);
  // A plane that would turn the normal over is that of a wall's other side if the point lies on a sheet as it is.
  if (fitted.dot(own) < -kOneWay && sparse_share(cloud, tree, i, epsilon)) return own;
  return fitted;
}

/// Whether the points that face the same way as a point's normal n lie too far to one side of the point.
bool is_beside(const Vec3f& n, const Moments& moments, const ClusteringResult& clustering) {
  const bool alone = !(moments.others > kOtherShare * moments.weight);
  const float limit = std::max(kMaxOffset * clustering.epsilon, (alone ? kAloneOffset : 1) * clustering.noise);
  return moments.count >= kMinPoints && std::abs(moments.first.dot(n)) > limit * moments.weight;
}

/// How far a plane is tilted against a normal n.
struct Tilt {
  Vec3f by = Vec3f::Zero();  ///< a t + b s of refine_normals()
  float square = 0;          ///< of `by`
  float of_noise = 0;        ///< expected square from noise alone
};

/// @param noise  mm; 0 to take the whole tilt
/// @returns no tilt if the points lie on no plane, or on another sheet's
Tilt measure_tilt(const Vec3f& n, const Moments& moments, float noise) {
  if (moments.count < kMinPoints) return {};
  const auto [t, s] = Frame(n);
  const float tt = moments.covariance(t, t);
  const float ss = moments.covariance(s, s);
  const float ts = moments.covariance(t, s);
  const float determinant = tt * ss - ts * ts;
  if (!(determinant > kMinWidth2 * (tt + ss) * (tt + ss))) return {};
  const float tn = moments.covariance(t, n);
  const float sn = moments.covariance(s, n);
  const float a = (tn * ss - sn * ts) / determinant;
  const float b = (sn * tt - tn * ts) / determinant;
  const float square = a * a + b * b;
  if (!(square < kMaxTilt * kMaxTilt)) return {};
  return {t * a + s * b, square, kWeightsSpread * noise * noise * (tt + ss) / (tt * ss)};
}

}  // namespace

Status refine_normals(const Cloud& cloud, const KdTree3& tree, const ClusteringResult& clustering, NormalSource source,
                      std::span<PackedNormal> refined, const StageProgress& progress) {
  const bool measured = source == NormalSource::kScanner;
  const float share = std::sqrt(measured ? kPlanePoints / cloud.support_points : kPlaneSupports);
  const float explained = measured ? clustering.noise : 0;
  const auto refine_block = [&](std::uint32_t first, std::uint32_t last) {
    TangentPlanes planes(cloud, tree);
    std::array<Moments, kSharedSearch> moments{};
    float search_radius = 0;
    for (std::uint32_t i = first; i < last; ++i) search_radius = std::max(search_radius, share * cloud.radius[i]);
    for_neighbourhood(cloud, tree, first, last, search_radius, [&](const Neighbourhood& batch) {
      for (std::uint32_t i = first; i < last; ++i) {
        const float radius = share * cloud.radius[i];
        add_all(member(cloud, i), radius * radius, batch, moments[i - first]);
      }
    });
    std::array<Tilt, kSharedSearch> tilts{};
    float squares = 0;
    float of_noise = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      refined[i] = cloud.normal[i];
      const Vec3f n = cloud.normal[i].unpack();
      if (!cloud.is_surface(i) || is_beside(n, moments[i - first], clustering)) {
        refined[i].set(fit_normal(planes, cloud, tree, i, clustering.epsilon));
        continue;
      }
      const Tilt& own = tilts[i - first] = measure_tilt(n, moments[i - first], explained);
      squares += own.square;
      of_noise += own.of_noise;
    }
    for (std::uint32_t i = first; i < last; ++i) {
      const Tilt& own = tilts[i - first];
      const float all = own.square + squares;
      const float noise = own.of_noise + of_noise;
      if (own.square > 0 && noise < all) refined[i].set(cloud.normal[i].unpack() - own.by * (1 - noise / all));
      if (cloud.is_surface(i)) refined[i].point_class = orientation_of(refined[i]);
    }
  };
  if (for_blocks(cloud.size, kSharedSearch, progress, refine_block)) return {};
  return fail(ErrorCode::kCancelled, "cancelled while normals were refined");
}

}  // namespace plumbline::inline slicer
