#include "firmware/print/truth/rrep_surface.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/dose/bleed.hpp"

namespace plumbline::firmware {
namespace {

/// Between a voxel and the one before it along an axis.
struct VoxelFace {
  int axis = 0;      ///< 0: x, 1: y, 2: z
  int outwards = 0;  ///< -1 or 1, along the axis
  std::int64_t column = 0, row = 0, layer = 0;
  float z_mm = 0;  ///< of a crossing
};

/// The crossings of an R-Rep by ray.
class Rays {
 public:
  Rays(const RRep& rrep, const CureModel& cure)
      : grid_(rrep.grid), first_(std::size_t{grid_.columns} * grid_.rows + 2) {
    const CrossingPacking packing(grid_);
    for (const std::uint32_t packed : rrep.packed) ++first_[packing.pixel(packed) + 2];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    layers_.resize(rrep.crossings());
    heights_.resize(rrep.crossings());
    for (std::uint32_t k = 0; k < grid_.layers; ++k) {
      for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
        const std::uint32_t at = first_[packing.pixel(rrep.packed[i]) + 1]++;
        layers_[at] = k;
        heights_[at] = packing.height_mm(rrep.packed[i], k, grid_);
      }
    }
    if (cure.is_known()) undo_correction(cure);
  }

  /// Calls visit(VoxelFace) for the faces of a ray's voxels in layers [low, end).
  template <class Visit>
  void for_each_face(std::int64_t column, std::int64_t row, std::int64_t low, std::int64_t end, Visit visit) const {
    const auto own = ray(column, row);
    for (std::size_t i = 0; i < own.size() && own[i] < end; ++i) {
      const float z_mm = heights_[static_cast<std::size_t>(&own[i] - layers_.data())];
      if (own[i] >= low) visit(VoxelFace{2, i % 2 == 0 ? -1 : 1, column, row, own[i], z_mm});
    }
    // What continues to the top of the last layer ends there.
    const float top_mm = static_cast<float>(grid_.layers) * grid_.layer_height_mm;
    if (own.size() % 2 != 0 && grid_.layers < end) visit(VoxelFace{2, 1, column, row, grid_.layers, top_mm});
    for (const int axis : {0, 1}) {
      const auto before = axis == 0 ? ray(column - 1, row) : ray(column, row - 1);
      if (own.empty() && before.empty()) continue;
      std::size_t i = 0, j = 0;  // crossings of both rays that are passed
      for (std::int64_t from = 0; from < std::min<std::int64_t>(end, grid_.layers);) {
        while (i < own.size() && own[i] <= from) ++i;
        while (j < before.size() && before[j] <= from) ++j;
        std::int64_t to = std::min<std::int64_t>(end, grid_.layers);
        if (i < own.size()) to = std::min<std::int64_t>(to, own[i]);
        if (j < before.size()) to = std::min<std::int64_t>(to, before[j]);
        for (std::int64_t k = std::max(from, low); (i + j) % 2 != 0 && k < to; ++k) {
          visit(VoxelFace{axis, i % 2 != 0 ? -1 : 1, column, row, k});
        }
        from = to;
      }
    }
  }

  bool is_empty(std::int64_t row) const {
    if (row < 0 || row >= grid_.rows) return true;
    const auto pixel = static_cast<std::size_t>(row * grid_.columns);
    return first_[pixel] == first_[pixel + grid_.columns];
  }

  /// mm
  Vec3d middle(const VoxelFace& face) const {
    const auto at = [&face](std::int64_t i, int axis) {
      return static_cast<double>(i) + (face.axis == axis ? 0 : 0.5);
    };
    return {at(face.column, 0) * double{grid_.pitch_x_mm}, at(face.row, 1) * double{grid_.pitch_y_mm},
            face.axis == 2 ? double{face.z_mm} : at(face.layer, 2) * double{grid_.layer_height_mm}};
  }

 private:
  void undo_correction(const CureModel& cure) {
    const CureDepths depths(cure, static_cast<double>(grid_.layer_height_mm));
    for (std::size_t pixel = 0; pixel + 1 < first_.size(); ++pixel) {
      for (std::uint32_t i = first_[pixel]; i < first_[pixel + 1]; i += 2) {
        const std::uint32_t exit = i + 1 < first_[pixel + 1] ? layers_[i + 1] : grid_.layers;
        const double height = uncorrected_mm(depths, grid_, static_cast<double>(heights_[i]), layers_[i], exit);
        heights_[i] = static_cast<float>(height);
        layers_[i] = height_of(heights_[i], grid_).layer();
      }
    }
  }
  std::span<const std::uint32_t> ray(std::int64_t column, std::int64_t row) const {
    if (column < 0 || row < 0 || column >= grid_.columns || row >= grid_.rows) return {};
    const auto pixel = static_cast<std::size_t>(row * grid_.columns + column);
    return std::span(layers_).subspan(first_[pixel], first_[pixel + 1] - first_[pixel]);
  }

  PrintGrid grid_;
  std::vector<std::uint32_t> first_;   ///< by pixel, into layers_
  std::vector<std::uint32_t> layers_;  ///< ascending within a ray
  std::vector<float> heights_;         ///< mm
};

/// The plane through the faces near one; none at an edge.
/// @param chance  evenly from 0 to 1: none, too, for as many as make the area of slopes in faces larger than their own
std::optional<OrientedPoint> plane_at(const Rays& rays, const PrintGrid& grid, const VoxelFace& face, double chance) {
  constexpr std::int64_t kReach = 4;  // pixels
  const Vec3d pixel(double{grid.pitch_x_mm}, double{grid.pitch_y_mm}, double{grid.layer_height_mm});
  const Vec3d area(pixel[1] * pixel[2], pixel[2] * pixel[0], pixel[0] * pixel[1]);
  const Vec3d here = rays.middle(face);
  const auto for_each_near = [&](std::int64_t reach, auto visit) {
    const double radius = static_cast<double>(reach) * std::max(pixel[0], pixel[1]);
    const auto layers = std::max<std::int64_t>(1, std::llround(radius / pixel[2]));
    for (std::int64_t row = face.row - reach; row <= face.row + reach; ++row) {
      for (std::int64_t column = face.column - reach; column <= face.column + reach; ++column) {
        const std::int64_t across = column - face.column, along = row - face.row;
        if (across * across + along * along > reach * reach + 1) continue;
        rays.for_each_face(column, row, face.layer - layers, face.layer + layers + 1, [&](const VoxelFace& f) {
          const Vec3d off = rays.middle(f) - here;
          const double near = 1 - off.dot(off) / (radius * radius);
          if (near > 0) visit(f, off, near * near * area[f.axis]);
        });
      }
    }
  };
  // The other side of a thin wall faces the other way.
  Vec3d facing = Vec3d::Zero(), sum = Vec3d::Zero();
  for_each_near(2, [&](const VoxelFace& f, const Vec3d&, double weight) { facing[f.axis] += f.outwards * weight; });
  if (chance * facing.cwiseAbs().sum() >= std::sqrt(facing.dot(facing))) return std::nullopt;
  double weights = 0;
  Mat3d squares = Mat3d::Zero();
  for_each_near(kReach, [&](const VoxelFace& f, const Vec3d& off, double weight) {
    if (f.outwards * facing[f.axis] <= 0) return;
    weights += weight;
    sum += weight * off;
    squares += weight * off * off.transpose();
  });
  if (!(weights > 0)) return std::nullopt;
  const Vec3d mean = sum / weights;
  const Eigen::SelfAdjointEigenSolver<Mat3d> plane(squares / weights - mean * mean.transpose());
  const double tolerance = 0.45 * pixel.maxCoeff();
  if (plane.eigenvalues()[0] > tolerance * tolerance) return std::nullopt;
  Vec3d normal = plane.eigenvectors().col(0);
  if (normal.dot(facing) < 0) normal = -normal;
  return OrientedPoint{Vec3d(here + mean.dot(normal) * normal).cast<float>(), normal.cast<float>()};
}

}  // namespace

TrueSurface surface_samples(const RRep& rrep, const CureModel& cure) {
  constexpr double kPoints = 12'000;  // fewer than of a mesh, since each takes longer
  TrueSurface surface{.name = "r-rep", .points = {}};
  const PrintGrid& grid = rrep.grid;
  const Rays rays(rrep, cure);
  const double side = static_cast<double>(grid.layer_height_mm / std::max(grid.pitch_x_mm, grid.pitch_y_mm));
  const auto chance = [](std::uint64_t number) { return static_cast<double>(mix64(number)) / 0x1p64; };
  // Enough rays for the points; all of a small object.
  const double looked_at = std::min(1.0, 100'000 / static_cast<double>(rrep.crossings() + 1));
  const auto for_each = [&](auto visit) {
    for (std::int64_t row = 0; row <= grid.rows; ++row) {
      if (rays.is_empty(row) && rays.is_empty(row - 1)) continue;
      for (std::int64_t column = 0; column <= grid.columns; ++column) {
        if (chance(static_cast<std::uint64_t>(row * 65536 + column)) >= looked_at) continue;
        rays.for_each_face(column, row, 0, std::int64_t{grid.layers} + 1, visit);
      }
    }
  };
  double faces = 0;
  for_each([&](const VoxelFace& face) { faces += face.axis == 2 ? 1 : side; });
  // A surface has up to 1.7 times its area in faces, depending on its normal; 1.5 times on average.
  const double share = 1.5 * kPoints / std::max(1.0, faces);
  for_each([&](const VoxelFace& face) {
    const auto number =
        static_cast<std::uint64_t>(((face.layer * 65536 + face.row) * 65536 + face.column) * 4 + face.axis);
    if (chance(number) >= (face.axis == 2 ? share : side * share)) return;
    if (const auto point = plane_at(rays, grid, face, chance(~number))) surface.points.push_back(*point);
  });
  return surface;
}

}  // namespace plumbline::firmware
