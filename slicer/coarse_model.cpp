#include "slicer/coarse_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "slicer/cloud/kd_tree.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/placement/placement.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "orientation";
/// Step of the model in cells of the samples. The winding number changes from 0 to 1 over about a cell.
constexpr float kStepCells = 0.7F;
constexpr float kMarginCells = 1.5F;          ///< of the model round the samples
constexpr std::size_t kMostPlaces = 400'000;  ///< of the model; a bust takes 100,000
constexpr double kVoxels = 128;               ///< along the longest side of the figure, in each way up
constexpr float kNearSurface = 0.2F;          ///< from 1/2: a winding number that needs to be exact

constexpr float kPlain = 0.1F;  ///< from 0 or 1: a winding number that leaves no doubt around it

/// A cloud of the patches as they are turned, each with its area, in the order of a tree.
Expected<Cloud> cloud_of(const SurfaceSamples& samples, const Eigen::Matrix3f& turn, Arena& arena) {
  auto cloud = Cloud::create(static_cast<std::uint32_t>(samples.patches.size()), arena);
  PLUMBLINE_TRY(cloud);
  for (const SurfaceSample& patch : samples.patches) {
    cloud->position[cloud->size] = turn * patch.position;
    cloud->normal[cloud->size] = {};
    cloud->normal[cloud->size].set(turn * patch.normal);
    cloud->radius[cloud->size] = std::sqrt(patch.area * std::numbers::inv_pi_v<float>);
    ++cloud->size;
  }
  const ArenaScope scope(arena);
  auto tree = KdTree3::build(cloud->positions(), arena, kStage);
  PLUMBLINE_TRY(tree);
  cloud->reorder(tree->order());
  return cloud;
}

}  // namespace

float CoarseModel::at(const Vec3f& p) const {
  const Vec3f from = (p - low) / step;
  std::array<std::uint32_t, 3> cell{};
  Vec3f part;
  for (int a = 0; a < 3; ++a) {
    const auto side = sides[static_cast<std::size_t>(a)];
    if (!(from[a] >= 0) || !(from[a] < static_cast<float>(side - 1))) return 0;
    cell[static_cast<std::size_t>(a)] = static_cast<std::uint32_t>(from[a]);
    part[a] = from[a] - std::floor(from[a]);
  }
  const auto along_x = [&](std::uint32_t y, std::uint32_t z) {
    const float* const w = &winding[index(cell[0], cell[1] + y, cell[2] + z)];
    return w[0] + part[0] * (w[1] - w[0]);
  };
  const auto along_y = [&](std::uint32_t z) {
    const float near = along_x(0, z);
    return near + part[1] * (along_x(1, z) - near);
  };
  const float below = along_y(0);
  return below + part[2] * (along_y(1) - below);
}

Vec3f CoarseModel::outwards(const Vec3f& p) const {
  Vec3f slope;
  for (int a = 0; a < 3; ++a) {
    const Vec3f aside = Vec3f::Unit(a) * step;
    slope[a] = at(p - aside) - at(p + aside);
  }
  return slope;
}

Expected<CoarseModel> build_coarse_model(const SurfaceSamples& samples, const Mat3d& turn, Arena& arena,
                                         const StageProgress& progress) {
  const auto places = arena.take_top<float>(kMostPlaces, kStage);
  PLUMBLINE_TRY(places);
  const ArenaScope scope(arena);
  const auto cloud = cloud_of(samples, turn.cast<float>(), arena);
  PLUMBLINE_TRY(cloud);
  const Box3f box = cloud->bounds();
  CoarseModel model;
  model.turn = turn;
  const Vec3f size = box.size() + Vec3f::Constant(2 * kMarginCells * samples.cell);
  model.low = box.low - Vec3f::Constant(kMarginCells * samples.cell);
  std::size_t count = 0;
  for (model.step = kStepCells * samples.cell;; model.step *= 1.1F) {
    count = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      model.sides[a] = static_cast<std::uint32_t>(size[static_cast<int>(a)] / model.step) / 2 * 2 + 3;  // odd
      count *= model.sides[a];
    }
    if (count <= kMostPlaces) break;
  }
  model.winding = places->first(count);
  const auto nodes = arena.take_top<WindingTree::Node>(WindingTree::nodes_needed(cloud->size), kStage);
  PLUMBLINE_TRY(nodes);
  WindingTree winding = WindingTree::build(*cloud, *nodes);
  winding.set_base(box.low[2], samples.cell);
  const auto evaluate = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    const Vec3f p = model.low + model.step * Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    float w = winding.rough(p);
    if (std::abs(w - WindingTree::kSurface) < kNearSurface) w = winding(p);
    if (!WindingTree::is_plain(w)) {
      const WindingLean lean = winding.lean_at(p);
      if (lean.weight > 0) w += WindingLean::kRounding * lean.outwards / lean.weight;
    }
    return w;
  };
  // Every second place along each axis first: between those that agree on inside or outside, nothing needs to be evaluated.
  const auto even_places = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    float least = 1, most = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const auto at = [&](std::uint32_t i, unsigned axis) {
        return i % 2 == 0 ? i : (corner >> axis) % 2 == 0 ? i - 1 : i + 1;
      };
      const float w = model.winding[model.index(at(x, 0), at(y, 1), at(z, 2))];
      least = std::min(least, w);
      most = std::max(most, w);
    }
    return std::pair(least, most);
  };
  for (const bool even : {true, false}) {
    for (std::uint32_t z = 0; z < model.sides[2]; z += even ? 2 : 1) {
      const double done = static_cast<double>(z) / model.sides[2];
      if (!progress.advance(even ? 0.3 * done : 0.3 + 0.7 * done)) return fail(ErrorCode::kCancelled, "cancelled");
#pragma omp parallel for schedule(dynamic, 4)
      for (std::uint32_t y = 0; y < model.sides[1]; ++y) {
        for (std::uint32_t x = 0; x < model.sides[0]; ++x) {
          const bool is_even = x % 2 == 0 && y % 2 == 0 && z % 2 == 0;
          if (is_even != even) continue;
          float& w = model.winding[model.index(x, y, z)];
          if (even) {
            w = evaluate(x, y, z);
            continue;
          }
          const auto [least, most] = even_places(x, y, z);
          w = most < kPlain ? 0 : least > 1 - kPlain ? 1 : evaluate(x, y, z);
        }
      }
    }
  }
  return model;
}

CoarseVoxels voxels_of(const CoarseModel& model, const std::array<double, 2>& degrees, double unit_mm,
                       double beside_mm) {
  CoarseVoxels v{rotation_matrix({degrees[0], degrees[1], 0}) * model.turn.transpose(), unit_mm, {}, {}};
  Box3d box;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3d p = model.low.cast<double>();
    for (std::size_t a = 0; a < 3; ++a) {
      if (((corner >> a) & 1U) != 0) p[static_cast<int>(a)] += static_cast<double>(model.step) * (model.sides[a] - 1);
    }
    box.extend(v.rotation * p * v.unit_mm);
  }
  const double longest = static_cast<double>(model.step) * *std::ranges::max_element(model.sides) * v.unit_mm;
  const double side = longest / kVoxels;
  const double room = beside_mm + side;
  v.low_mm = box.low - Vec3d(room, room, 0);
  const auto whole = [&](double mm) { return static_cast<std::uint32_t>(std::ceil(mm / side)) + 1; };
  v.grid.columns = whole(box.size()[0] + 2 * room);
  v.grid.rows = whole(box.size()[1] + 2 * room);
  v.grid.layers = whole(box.size()[2]);
  v.grid.pitch_x_mm = v.grid.pitch_y_mm = v.grid.layer_height_mm = static_cast<float>(side);
  return v;
}

Expected<RRep> rrep_of(const CoarseModel& model, const CoarseVoxels& voxels, Arena& arena) {
  const ArenaScope scope(arena);
  const PrintGrid& grid = voxels.grid;
  const std::size_t plane = std::size_t{grid.columns} * grid.rows;
  const auto inside = arena.take_top<std::uint8_t>(plane * grid.layers, kStage);
  PLUMBLINE_TRY(inside);
  const auto first = arena.take_bottom<std::uint32_t>(grid.layers + 1, kStage);
  PLUMBLINE_TRY(first);
  const auto side = static_cast<double>(grid.pitch_x_mm);
#pragma omp parallel for schedule(dynamic, 4)
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    for (std::uint32_t r = 0; r < grid.rows; ++r) {
      for (std::uint32_t c = 0; c < grid.columns; ++c) {
        const Vec3f p = voxels.from_print(side * Vec3d(c + 0.5, r + 0.5, k + 0.5));
        (*inside)[k * plane + std::size_t{r} * grid.columns + c] = model.at(p) > WindingTree::kSurface ? 1 : 0;
      }
    }
  }
  const auto toggles = [&](std::uint32_t k, std::size_t i) {
    return (*inside)[k * plane + i] != (k == 0 ? 0 : (*inside)[(k - 1) * plane + i]);
  };
  std::uint32_t count = 0;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    (*first)[k] = count;
    for (std::size_t i = 0; i < plane; ++i) count += toggles(k, i) ? 1 : 0;
  }
  (*first)[grid.layers] = count;
  const CrossingPacking packing(grid);
  const auto packed = arena.take_bottom<std::uint32_t>(count, kStage);
  PLUMBLINE_TRY(packed);
  std::size_t at = 0;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    for (std::size_t i = 0; i < plane; ++i) {
      if (toggles(k, i)) (*packed)[at++] = packing.packed(static_cast<std::uint32_t>(i));
    }
  }
  return RRep{grid, *first, *packed, true};
}

}  // namespace plumbline::inline slicer
