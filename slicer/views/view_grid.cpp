#include "slicer/views/view_grid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "slicer/core/numbers/lanes.hpp"

namespace plumbline {
namespace {

/// Least q: points closer to the camera than this share of the middle's distance don't belong to its view. Avoids
/// dividing by 0.
constexpr double kMinQ = 0.05;
// Priors of what the points don't determine: a camera stands some extents away, and its lens bends little.
constexpr double kPixelNoise = 0.05;        ///< pixels
constexpr double kLikelyPerspective = 0.6;  ///< standard deviation of c times the extent
constexpr double kLikelyDistortion = 0.1;   ///< standard deviation of the distortion at the extent, as a share of it
constexpr double kRidge = 1e-9;  ///< share of the trace added to the diagonal, which keeps the matrix invertible
constexpr double kOfHigher = 4;  ///< of each higher term, over the one before times the distortion
constexpr double kAlike = 0.2;   ///< share of the first term's deviation between the views of a scan
constexpr double kTiny = 1e-9;   ///< deviation of what shall stay 0
/// Standard deviations of the strength beyond which it tells where the lens's centre is.
constexpr double kSureDeviations = 5;

constexpr int kSize = ViewGrid::kUnknowns;
constexpr std::size_t kProducts = std::size_t{kSize} * (kSize + 1) / 2;

/// A grid's numbers for lanes.
struct FlatGrid {
  std::array<float, 4> a, b, c;
  std::array<float, 3> k;
  float cu, cv, lu, lv;

  explicit FlatGrid(const ViewGrid& grid) {
    for (std::size_t i = 0; i < 4; ++i) {
      const auto n = static_cast<Eigen::Index>(i);
      a[i] = static_cast<float>(grid.map[n]);
      b[i] = static_cast<float>(grid.map[n + 4]);
      c[i] = i < 3 ? static_cast<float>(grid.map[n + 8]) : 1;
    }
    for (std::size_t i = 0; i < 3; ++i) k[i] = static_cast<float>(grid.lens.radial[i]);
    cu = static_cast<float>(grid.lens.centre[0]);
    cv = static_cast<float>(grid.lens.centre[1]);
    lu = static_cast<float>(grid.lens.lean[0]);
    lv = static_cast<float>(grid.lens.lean[1]);
  }
};

struct FlatPixels {
  Lanes q, su, sv;  ///< as in ViewGrid::Pixel
  Lanes wu, wv;     ///< from the lens's centre, in units
  Lanes du, dv;     ///< from the nearest integer pixels
};

constexpr auto kUnit = static_cast<float>(Lens::kUnit);

PLUMBLINE_INLINE void project(FlatPixels& p, const FlatGrid& g, const Lanes& x, const Lanes& y, const Lanes& z) {
  p.q = 1 + (g.c[0] * x + g.c[1] * y + g.c[2] * z);
  const Lanes inverse = 1 / p.q;
  p.su = (g.a[3] + (g.a[0] * x + g.a[1] * y + g.a[2] * z)) * inverse;
  p.sv = (g.b[3] + (g.b[0] * x + g.b[1] * y + g.b[2] * z)) * inverse;
  p.wu = (p.su - g.cu) * (1 / kUnit);
  p.wv = (p.sv - g.cv) * (1 / kUnit);
  const Lanes uu = p.wu * p.wu;
  const Lanes vv = p.wv * p.wv;
  const Lanes uv = p.wu * p.wv;
  const Lanes square = uu + vv;
  const Lanes along = (g.k[0] + (g.k[1] + g.k[2] * square) * square) * square;
  const Lanes u = p.su + kUnit * (along * p.wu - g.lu * (3 * uu + vv) - 2 * g.lv * uv);
  const Lanes v = p.sv + kUnit * (along * p.wv - g.lv * (uu + 3 * vv) - 2 * g.lu * uv);
  round_lanes(p.du, u);
  round_lanes(p.dv, v);
  p.du = u - p.du;
  p.dv = v - p.dv;
}

PLUMBLINE_INLINE void distance2_of(Lanes& distance2, const FlatGrid& grid, const Lanes& x, const Lanes& y,
                                   const Lanes& z) {
  FlatPixels p;
  project(p, grid, x, y, z);
  choose(distance2, p.q < static_cast<float>(kMinQ), Lanes{} + 1, p.du * p.du + p.dv * p.dv);
}

PLUMBLINE_WIDE void measure_within(const FlatGrid& grid, const Vec3f& middle, float radius2, const Vec3f* points,
                                   std::size_t size, float* distances2) {
  float last[3 * kLanes] = {};  // NOLINT(cppcoreguidelines-avoid-c-arrays): the points that don't fill the lanes
  const std::size_t whole = size - size % kLanes;
  std::memcpy(last, static_cast<const void*>(points + whole), (size - whole) * sizeof(Vec3f));
  for (std::size_t i = 0; i < size; i += kLanes) {
    Lanes x{}, y{}, z{}, distance2;
    load_points(x, y, z, i < whole ? points[i].data() : last);
    x -= middle.data()[0];
    y -= middle.data()[1];
    z -= middle.data()[2];
    distance2_of(distance2, grid, x, y, z);
    choose(distance2, x * x + y * y + z * z > radius2, Lanes{} + 1, distance2);
    store(distances2 + i, distance2);
  }
}

/// Of kLanes points, whose coordinates lie one after another.
PLUMBLINE_INLINE void distance2_at(Lanes& distance2, const FlatGrid& grid, const float* x, const float* y,
                                   const float* z) {
  Lanes px, py, pz;
  load(px, x);
  load(py, y);
  load(pz, z);
  distance2_of(distance2, grid, px, py, pz);
}

constexpr std::size_t kMaxWidths = 8;

/// @param limits2  of the distances
PLUMBLINE_WIDE void add_counts(const FlatGrid& grid, const float* x, const float* y, const float* z, std::size_t size,
                               const float* limits2, std::size_t limits, std::uint32_t* counts) {
  IntLanes within[kMaxWidths] = {};  // NOLINT(cppcoreguidelines-avoid-c-arrays)
  for (std::size_t i = 0; i < size; i += kLanes) {
    Lanes distance2;
    distance2_at(distance2, grid, x + i, y + i, z + i);
    for (std::size_t k = 0; k < limits; ++k) within[k] += distance2 < limits2[k];
  }
  for (std::size_t k = 0; k < limits; ++k) counts[k] -= static_cast<std::uint32_t>(sum(within[k]));
}

PLUMBLINE_WIDE void measure_distances2(const FlatGrid& grid, const float* x, const float* y, const float* z,
                                       std::size_t size, float* distances2) {
  for (std::size_t i = 0; i < size; i += kLanes) {
    Lanes distance2;
    distance2_at(distance2, grid, x + i, y + i, z + i);
    store(distances2 + i, distance2);
  }
}

/// Normal equations, of unknowns in the order of ViewGrid::map with lengths over the radius, then the lens's.
template <class Number>
struct Sums {
  std::array<Number, kProducts> products;  ///< lower half, row after row
  std::array<Number, kSize> residuals;
};

constexpr std::size_t kBlock = 1024;         ///< points of which one thread selects those near the grid
constexpr std::size_t kBatch = 32 * kLanes;  ///< points whose sums are kept in single precision

/// Adds the equations of kLanes points.
PLUMBLINE_INLINE void add_lanes(const FlatGrid& g, const Lanes& x, const Lanes& y, const Lanes& z, float scale,
                                float inverse_width2, Lanes* products, Lanes* residuals) {
  FlatPixels p;
  project(p, g, x, y, z);
  const Lanes rest = 1 - (p.du * p.du + p.dv * p.dv) * inverse_width2;
  Lanes weight;
  choose(weight, (rest > 0) & (p.q >= static_cast<float>(kMinQ)), rest * rest, Lanes{});
  const Lanes uu = p.wu * p.wu;
  const Lanes vv = p.wv * p.wv;
  // Of the pixel by where the pinhole shows it.
  const Lanes square = uu + vv;
  const Lanes along = (g.k[0] + (g.k[1] + g.k[2] * square) * square) * square;
  const Lanes growing = 2 * g.k[0] + (4 * g.k[1] + 6 * g.k[2] * square) * square;
  const Lanes by_uu = 1 + along + growing * uu - 6 * g.lu * p.wu - 2 * g.lv * p.wv;
  const Lanes by_uv = growing * (p.wu * p.wv) - 2 * g.lu * p.wv - 2 * g.lv * p.wu;
  const Lanes by_vv = 1 + along + growing * vv - 6 * g.lv * p.wv - 2 * g.lu * p.wu;
  const Lanes one = 1 / p.q;
  const std::array<Lanes, 4> place = {x * (scale * one), y * (scale * one), z * (scale * one), one};
  const Lanes back_u = by_uu * p.su + by_uv * p.sv;
  const Lanes back_v = by_uv * p.su + by_vv * p.sv;
  Lanes u[kSize];  // NOLINT(cppcoreguidelines-avoid-c-arrays): std::array's functions are not inlined in every clone
  Lanes v[kSize];  // NOLINT(cppcoreguidelines-avoid-c-arrays)
  for (int i = 0; i < 4; ++i) {
    const Lanes& at = place[static_cast<std::size_t>(i)];
    u[i] = by_uu * at;
    v[i] = by_uv * at;
    u[i + 4] = by_uv * at;
    v[i + 4] = by_vv * at;
    if (i == 3) break;
    u[i + 8] = -back_u * at;
    v[i + 8] = -back_v * at;
  }
  u[11] = kUnit * square * p.wu;
  v[11] = kUnit * square * p.wv;
  u[12] = square * u[11];
  v[12] = square * v[11];
  u[13] = square * u[12];
  v[13] = square * v[12];
  u[14] = -kUnit * (3 * uu + vv);
  v[14] = -2 * kUnit * (p.wu * p.wv);
  u[15] = v[14];
  v[15] = -kUnit * (uu + 3 * vv);
  std::size_t at = 0;
  for (int i = 0; i < kSize; ++i) {
    const Lanes wu = weight * u[i];
    const Lanes wv = weight * v[i];
    residuals[i] += wu * p.du + wv * p.dv;
    for (int j = 0; j <= i; ++j) products[at++] += wu * u[j] + wv * v[j];
  }
}

/// Copies the points of a block that lie near the grid to the block's place in `near`.
/// @returns how many they are
std::size_t select_near(const FlatGrid& grid, const LocalPoints& points, std::size_t first, std::size_t size,
                        float width2, std::span<float> near) {
  std::array<float, kBlock> distances2;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const float* const x = &points.x[first];
  const float* const y = &points.y[first];
  const float* const z = &points.z[first];
  measure_distances2(grid, x, y, z, size, distances2.data());
  float* const to_x = &near[first];
  float* const to_y = to_x + ViewGridFit::kMaxPoints;
  float* const to_z = to_y + ViewGridFit::kMaxPoints;
  std::size_t count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    to_x[count] = x[i];
    to_y[count] = y[i];
    to_z[count] = z[i];
    count += distances2[i] < width2 ? 1 : 0;
  }
  return count;
}

PLUMBLINE_WIDE void add_batch(const FlatGrid& grid, const float* x, const float* y, const float* z, std::size_t size,
                              float scale, float inverse_width2, Sums<float>& sums) {
  Lanes products[kProducts] = {};  // NOLINT(cppcoreguidelines-avoid-c-arrays)
  Lanes residuals[kSize] = {};     // NOLINT(cppcoreguidelines-avoid-c-arrays)
  for (std::size_t i = 0; i < size; i += kLanes) {
    Lanes px, py, pz;
    load(px, x + i);
    load(py, y + i);
    load(pz, z + i);
    add_lanes(grid, px, py, pz, scale, inverse_width2, products, residuals);
  }
  for (std::size_t i = 0; i < kProducts; ++i) sums.products[i] = sum(products[i]);
  for (std::size_t i = 0; i < kSize; ++i) sums.residuals[i] = sum(residuals[i]);
}

/// Sums up the equations of the points within some distance of the grid, but for the last few that don't fill the lanes.
/// @param points  ViewGridFit::kMaxPoints at most
/// @param near    room for three times as many numbers
Sums<double> sum_equations(const FlatGrid& grid, const LocalPoints& points, float scale, double width,
                           std::span<float> near) {
  constexpr std::size_t kMost = ViewGridFit::kMaxPoints;
  const std::size_t blocks = (points.size() + kBlock - 1) / kBlock;
  std::array<std::size_t, kMost / kBlock> counts;   // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::array<Sums<float>, kMost / kBatch> batches;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::size_t size = 0;
#pragma omp parallel if (blocks > 1)
  {
#pragma omp for schedule(static)
    for (std::size_t block = 0; block < blocks; ++block) {
      const std::size_t first = block * kBlock;
      counts[block] = select_near(grid, points, first, std::min(kBlock, points.size() - first),
                                  static_cast<float>(width * width), near);
    }
    std::array<std::size_t, kMost / kBlock + 1> before = {};  // points near the grid in the blocks before each
    for (std::size_t block = 0; block < blocks; ++block) before[block + 1] = before[block] + counts[block];
    const std::size_t all = before[blocks] - before[blocks] % kLanes;
#pragma omp for schedule(static)
    for (std::size_t batch = 0; batch < (all + kBatch - 1) / kBatch; ++batch) {
      std::array<std::array<float, kBatch>, 3> at;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      const std::size_t first = batch * kBatch;
      const std::size_t last = std::min(first + kBatch, all);
      for (std::size_t block = 0; block < blocks; ++block) {
        const std::size_t from = std::max(first, before[block]);
        const std::size_t to = std::min(last, before[block + 1]);
        if (from >= to) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto of_block = near.subspan(axis * kMost + block * kBlock, kBlock);
          std::copy_n(&of_block[from - before[block]], to - from, &at[axis][from - first]);
        }
      }
      add_batch(grid, at[0].data(), at[1].data(), at[2].data(), last - first, scale,
                static_cast<float>(1 / (width * width)), batches[batch]);
    }
#pragma omp master
    size = all;
  }
  Sums<double> sums = {};
  for (const Sums<float>& batch : std::span(batches).first((size + kBatch - 1) / kBatch)) {
    for (std::size_t i = 0; i < kProducts; ++i) sums.products[i] += static_cast<double>(batch.products[i]);
    for (std::size_t i = 0; i < kSize; ++i) sums.residuals[i] += static_cast<double>(batch.residuals[i]);
  }
  return sums;
}

/// Moves the lens's centre by what the lean stands for, `most` units at most, and the map by the affine part of that.
void settle_centre(ViewGrid& grid, double most) {
  Lens& lens = grid.lens;
  Eigen::Vector2d by = lens.lean / lens.radial[0];
  by *= std::min(1.0, most / std::max(by.norm(), 1e-9));
  const double k = lens.radial[0];
  const double square = by.squaredNorm();
  // s becomes s - A(w) U, A(w) = k |by|^2 w + 2 k <w, by> by - k |by|^2 by.
  using Row = Eigen::Vector4d;
  Row q;
  q << grid.map.segment<3>(8), 1;
  const Row u = grid.map.segment<4>(0);
  const Row v = grid.map.segment<4>(4);
  const Row wu = u - lens.centre[0] * q;
  const Row wv = v - lens.centre[1] * q;
  const Row along = 2 * k * (by[0] * wu + by[1] * wv);
  grid.map.segment<4>(0) = u - k * square * wu - along * by[0] + Lens::kUnit * k * square * by[0] * q;
  grid.map.segment<4>(4) = v - k * square * wv - along * by[1] + Lens::kUnit * k * square * by[1] * q;
  lens.centre += Lens::kUnit * by;
  lens.lean -= k * by;
}

}  // namespace

ViewGrid::Pixel ViewGrid::project(const Vec3f& point) const {
  const Vec3d x = (point - middle).cast<double>();
  const double q = 1 + map.segment<3>(8).dot(x);
  if (q < kMinQ) return {0, 0, 0, 0, 0};
  const double su = (map.segment<3>(0).dot(x) + map[3]) / q;
  const double sv = (map.segment<3>(4).dot(x) + map[7]) / q;
  const double wu = (su - lens.centre[0]) / Lens::kUnit;
  const double wv = (sv - lens.centre[1]) / Lens::kUnit;
  const double square = wu * wu + wv * wv;
  const double along = (lens.radial[0] + (lens.radial[1] + lens.radial[2] * square) * square) * square;
  const double lu = lens.lean[0];
  const double lv = lens.lean[1];
  return {su + Lens::kUnit * (along * wu - lu * (3 * wu * wu + wv * wv) - 2 * lv * wu * wv),
          sv + Lens::kUnit * (along * wv - lv * (wu * wu + 3 * wv * wv) - 2 * lu * wu * wv), su, sv, q};
}

Vec3d ViewGrid::ray(const Vec3f& point) const {
  const Pixel p = project(point);
  const Vec3d along_u = map.segment<3>(0) - p.su * map.segment<3>(8);
  const Vec3d along_v = map.segment<3>(4) - p.sv * map.segment<3>(8);
  return along_u.cross(along_v).normalized();
}

ViewGrid ViewGrid::around(const Vec3f& other) const {
  const Pixel p = project(other);
  ViewGrid moved;
  moved.middle = other;
  moved.map = map / p.q;
  moved.map[3] = p.su;
  moved.map[7] = p.sv;
  moved.lens = lens;
  return moved;
}

void count_near(const ViewGrid& grid, const LocalPoints& points, std::span<const double> widths,
                std::span<std::uint32_t> counts) {
  const FlatGrid flat(grid);
  std::array<float, kMaxWidths> limits2 = {};
  for (std::size_t k = 0; k < widths.size(); ++k) limits2[k] = static_cast<float>(widths[k] * widths[k]);
  std::fill(counts.begin(), counts.end(), 0);
  std::uint32_t* const sums = counts.data();
  const std::size_t limits = widths.size();
#pragma omp parallel for schedule(static) reduction(+ : sums[:limits]) if (points.size() > kBlock)
  for (std::size_t first = 0; first < points.size(); first += kBlock) {
    add_counts(flat, &points.x[first], &points.y[first], &points.z[first], std::min(kBlock, points.size() - first),
               limits2.data(), limits, sums);
  }
}

void distances2_within(const ViewGrid& grid, double radius, std::span<const Vec3f> points,
                       std::span<float> distances2) {
  measure_within(FlatGrid(grid), grid.middle, static_cast<float>(radius * radius), points.data(), points.size(),
                 distances2.data());
}

std::optional<double> ViewGridFit::improve(ViewGrid& grid, const LocalPoints& points, double radius,
                                           double width) const {
  const Sums<double> sums = sum_equations(FlatGrid(grid), points, static_cast<float>(1 / radius), width, room_);
  Eigen::Matrix<double, kSize, kSize> held;
  Eigen::Matrix<double, kSize, 1> target;
  std::size_t at = 0;
  for (int i = 0; i < kSize; ++i) {
    target[i] = sums.residuals[static_cast<std::size_t>(i)];
    for (int j = 0; j <= i; ++j) held(i, j) = held(j, i) = sums.products[at++];
  }
  const double trace = held.diagonal().head<11>().sum();
  const double weights = held(3, 3);  // nearly: a pixel moves by as much as a0, but for lens and perspective
  if (!(weights > 0)) return std::nullopt;
  held.diagonal().array() += kRidge * trace;
  const auto expect = [&](int i, double value, double deviation) {
    const double prior = kPixelNoise * kPixelNoise / (deviation * deviation);
    held(i, i) += prior;
    target[i] += prior * value;
  };
  for (int i = 8; i < 11; ++i) expect(i, grid.map[i] * radius, kLikelyPerspective * radius / extent_);
  const double pixels = std::max(grid.map.segment<3>(0).norm(), grid.map.segment<3>(4).norm());
  const double reach = extent_ * pixels / Lens::kUnit;
  const bool settled = !grid.lens.centre.isZero();
  double likely = kLikelyDistortion / (reach * reach);
  expect(11, grid.lens.radial[0] - radial_.value_or(0), radial_ ? kAlike * likely : likely);
  for (const int i : {12, 13}) {
    likely *= kLikelyDistortion / (reach * reach) * kOfHigher;
    expect(i, grid.lens.radial[static_cast<std::size_t>(i - 11)], settled ? likely : kTiny);
  }
  for (const int i : {14, 15}) expect(i, grid.lens.lean[i - 14], kLikelyDistortion / reach);
  const auto factors = held.ldlt();
  const Eigen::Matrix<double, kSize, 1> step = factors.solve(target);
  if (!step.allFinite()) return std::nullopt;
  for (int i = 0; i < 11; ++i) grid.map[i] -= i == 3 || i == 7 ? step[i] : step[i] / radius;
  for (int i = 0; i < 3; ++i) grid.lens.radial[static_cast<std::size_t>(i)] -= step[11 + i];
  grid.lens.lean -= step.tail<2>();
  const double variance = factors.solve(Eigen::Matrix<double, kSize, 1>::Unit(11))[11];
  if (std::abs(grid.lens.radial[0]) > kSureDeviations * kPixelNoise * std::sqrt(variance)) settle_centre(grid, reach);
  return std::sqrt(std::max(0.0, step.dot(target)) / weights);
}

}  // namespace plumbline
