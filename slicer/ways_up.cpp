#include "slicer/ways_up.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "slicer/cloud/kd_tree.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/layers/rrep_edit.hpp"
#include "slicer/source_checks.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/support_finder.hpp"

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

// Points that are no evidence of how far the object reaches: as many, and one in so many of them.
constexpr std::uint32_t kMostStrays = 12;
constexpr std::uint32_t kPointsPerStray = 8192;
constexpr double kHeavyTip = 1.5;  ///< diameter of a tip of heavy load, as a share of head_front_diameter

// What supports add to the total: so many times the share that their scars have of the surface, and so much for each tip.
constexpr double kScarCounts = 40;
constexpr double kCleanScarCounts = 400;
constexpr double kTipsCount = 1.0 / 200;

/// The winding number on a lattice round the figure. Where it is above 1/2 there is solid.
struct Model {
  Mat3d turn = Mat3d::Identity();  ///< of the figure as it came
  Vec3f low;
  float step = 1;
  std::array<std::uint32_t, 3> sides{};  ///< places along each axis
  std::span<float> winding;

  std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{z} * sides[1] + y) * sides[0] + x;
  }
  /// Between the eight places around; 0 outside the lattice.
  float at(const Vec3f& p) const {
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
  /// Not of unit length; zero where the model is flat.
  Vec3f outwards(const Vec3f& p) const {
    Vec3f slope;
    for (int a = 0; a < 3; ++a) {
      const Vec3f aside = Vec3f::Unit(a) * step;
      slope[a] = at(p - aside) - at(p + aside);
    }
    return slope;
  }
};

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

/// The model as a print would see it that is turned so: an underside that is open there is closed flat, other holes are closed round.
/// @param arena  keeps the model at its top
Expected<Model> build_model(const SurfaceSamples& samples, const Mat3d& turn, Arena& arena,
                            const StageProgress& progress) {
  const auto places = arena.take_top<float>(kMostPlaces, kStage);
  PLUMBLINE_TRY(places);
  const ArenaScope scope(arena);
  const auto cloud = cloud_of(samples, turn.cast<float>(), arena);
  PLUMBLINE_TRY(cloud);
  const Box3f box = cloud->bounds();
  Model model;
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

/// A way up of the model, as voxels of a print.
struct Voxels {
  Mat3d rotation;
  double unit_mm;
  Vec3d low_mm;  ///< of the grid
  PrintGrid grid;

  /// In the model.
  Vec3f from_print(const Vec3d& mm) const { return (rotation.transpose() * (mm + low_mm) / unit_mm).cast<float>(); }
};

Voxels voxels_of(const Model& model, const WayUp& way, const SupportSettings& supports) {
  Voxels v{rotation_matrix({way.degrees[0], way.degrees[1], 0}) * model.turn.transpose(), way.unit_mm, {}, {}};
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
  const double room = support_room(supports).beside_mm + side;
  v.low_mm = box.low - Vec3d(room, room, 0);
  const auto whole = [&](double mm) { return static_cast<std::uint32_t>(std::ceil(mm / side)) + 1; };
  v.grid.columns = whole(box.size()[0] + 2 * room);
  v.grid.rows = whole(box.size()[1] + 2 * room);
  v.grid.layers = whole(box.size()[2]);
  v.grid.pitch_x_mm = v.grid.pitch_y_mm = v.grid.layer_height_mm = static_cast<float>(side);
  return v;
}

/// @returns at the bottom of the arena
Expected<RRep> rrep_of(const Model& model, const Voxels& voxels, Arena& arena) {
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
  const auto pixel = arena.take_bottom<std::uint32_t>(count, kStage);
  PLUMBLINE_TRY(pixel);
  std::size_t at = 0;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    for (std::size_t i = 0; i < plane; ++i) {
      if (toggles(k, i)) (*pixel)[at++] = static_cast<std::uint32_t>(i);
    }
  }
  return RRep{grid, *first, *pixel, true};
}

/// Volume of all struts but those of the raft and the tips, which are in the object. Coarse pixels make thin struts thick, so radii are those asked for.
double strut_volume(std::span<const Strut> struts, const SupportSettings& settings, double layer_mm) {
  const double pillar = settings.pillar_diameter / 2;
  double volume = 0;
  for (const Strut& strut : struts) {
    if (strut.kind == StrutKind::kTip || strut.kind == StrutKind::kRaft) continue;
    const double widest = strut.kind == StrutKind::kBase ? settings.base_diameter / 2 : pillar;
    const double lower = std::min(strut.radius0 / 1000.0, widest);
    const double upper =
        std::min(strut.radius1 / 1000.0, strut.kind == StrutKind::kHead ? settings.head_front_diameter / 2 : pillar);
    volume +=
        (strut.end - strut.first) * layer_mm * std::numbers::pi / 3 * (lower * lower + lower * upper + upper * upper);
  }
  return volume;
}

/// Finds the supports of a way up.
/// @returns mm by which they lift the object
Expected<double> count_supports(const Model& model, const SliceSettings& settings, Arena& arena, WayUp& way) {
  const ArenaScope top(arena);
  const BottomScope bottom(arena);
  const SupportSettings& wanted = *settings.supports;
  const Voxels voxels = voxels_of(model, way, wanted);
  auto rrep = rrep_of(model, voxels, arena);
  PLUMBLINE_TRY(rrep);
  const auto empty = trim_empty_layers(*rrep, arena);
  PLUMBLINE_TRY(empty);
  SupportCounts counts;
  const auto found = find_supports(*rrep, wanted, PrintGrid::kMaxLayers, arena, nullptr, counts);
  PLUMBLINE_TRY(found);
  const auto side = static_cast<double>(rrep->grid.pitch_x_mm);
  const double raised = static_cast<double>(counts.lifted) - counts.sunk;  // layers
  const auto disc = [&](double share) {
    const double diameter = share * wanted.head_front_diameter;
    return std::numbers::pi / 4 * diameter * diameter;
  };
  WayUp::Supports supports{
      .tips = counts.all(),
      .scar_mm2 = counts.light * disc(kLightTip) + counts.medium * disc(1) + counts.heavy * disc(kHeavyTip),
      .volume_mm3 = strut_volume(found->list, wanted, side)};
  double facing_clean = 0;
  std::uint32_t raft_layers = 0;
  for (const Strut& strut : found->list) {
    if (strut.kind == StrutKind::kRaft) raft_layers = std::max<std::uint32_t>(raft_layers, strut.end);
    if (strut.kind != StrutKind::kTip) continue;
    const Vec3d at(strut.column1 + 0.5, strut.row1 + 0.5, strut.first - raised + empty->below);
    const Vec3f out = model.turn.transpose().cast<float>() * model.outwards(voxels.from_print(side * at));
    const float length = std::sqrt(out.dot(out));
    if (length > 0) facing_clean += static_cast<double>(facing(settings.keep_clean, out / length));
  }
  if (supports.tips > 0) supports.clean_mm2 = supports.scar_mm2 * facing_clean / supports.tips;
  auto masks = MaskStream::create(*rrep, *found, arena, true);
  PLUMBLINE_TRY(masks);
  for (std::uint32_t k = 0; k < raft_layers; ++k) {
    static_cast<void>(masks->mask(k));
    supports.volume_mm3 += static_cast<double>(masks->support_pixels()) * side * side * side;
  }
  way.supports = supports;
  return raised * side;
}

/// How far the object reaches along a direction: as far as its patches, and on to its points within a cell of these, but for a few stray ones.
struct Reach {
  float low = 0, high = 0;
};
Reach reach_along(const Vec3f& axis, const Cloud& cloud, const SurfaceSamples& samples) {
  Reach patches{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
  for (const SurfaceSample& patch : samples.patches) {
    const float at = axis.dot(patch.position);
    patches = {std::min(patches.low, at), std::max(patches.high, at)};
  }
  const std::uint32_t strays = std::min(kMostStrays, cloud.size / kPointsPerStray);
  // The farthest points beyond the patches, the nearest of them first.
  std::array<float, kMostStrays + 1> below{}, above{};
  const auto take = [&](std::array<float, kMostStrays + 1>& farthest, float beyond) {
    if (!(beyond > farthest[0]) || beyond > samples.cell) return;
    farthest[0] = beyond;
    for (std::uint32_t i = 0; i < strays && farthest[i] > farthest[i + 1]; ++i) std::swap(farthest[i], farthest[i + 1]);
  };
  for (const Vec3f& p : cloud.positions()) {
    const float at = axis.dot(p);
    take(below, patches.low - at);
    take(above, at - patches.high);
  }
  return {patches.low - below[0], patches.high + above[0]};
}

/// The box of the scan turned by a rotation.
Box3d turned_box(const Mat3d& rotation, const Cloud& cloud, const SurfaceSamples& samples) {
  Box3d box;
  box.low = box.high = Vec3d::Zero();
  for (int a = 0; a < 3; ++a) {
    const Reach reach = reach_along(rotation.row(a).transpose().cast<float>(), cloud, samples);
    box.low[a] = static_cast<double>(reach.low);
    box.high[a] = static_cast<double>(reach.high);
  }
  return box;
}

}  // namespace

const WayUp& cheapest(const PrintedWays& ways) {
  return *std::ranges::min_element(ways, {}, [](const WayUp& way) { return way.cost.total; });
}

Expected<PrintedWays> find_ways_up(const Cloud& cloud, const SurfaceSamples& samples, const SliceSettings& settings,
                                   Arena& arena, const StageProgress& progress) {
  const auto cancelled = [] {
    return fail(ErrorCode::kCancelled, "cancelled while looking for the best orientations");
  };
  const auto best = best_orientations(samples, settings.keep_clean, progress.part(0, 0.4));
  if (!best) return cancelled();
  PlacementSettings placing = settings.placement;
  const Box3d came = turned_box(Mat3d::Identity(), cloud, samples);
  placing.sized_extent = came.size();
  const double unit_mm = millimetres_per(units_of(came, placing));
  const double scale = scale_of(came.size() * unit_mm, placing);
  const double layer = static_cast<double>(placing.layer_height_mm);
  const ArenaScope scope(arena);
  const std::size_t mark = arena.top_mark();
  std::optional<Model> model;
  PrintedWays ways;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const auto part = [&](double done) {
      return 0.4 + 0.6 * (static_cast<double>(i) + done) / static_cast<double>(ways.size());
    };
    WayUp& way = ways[i];
    way.degrees = (*best)[i].degrees;
    way.cost = (*best)[i].cost;
    way.unit_mm = std::isfinite(scale) ? unit_mm * scale : unit_mm;  // a flat side has no size
    placing.rotation_degrees = {way.degrees[0], way.degrees[1], settings.placement.rotation_degrees[2]};
    const Box3d box = turned_box(rotation_matrix(placing.rotation_degrees), cloud, samples);
    if (placing.fit) {
      if (const auto placed = place(box, unit_mm, placing)) way.unit_mm = placed->scale;
    }
    way.height_mm = box.size()[2] * way.unit_mm;
    double lift_mm = 0;
    // A hole is closed by what is around it in one way up, and flat in another. Without a hole, all have the same model.
    if (settings.supports && (!model || samples.has_hole())) {
      model.reset();
      arena.release_top(mark);
      const auto built = build_model(samples, rotation_matrix({way.degrees[0], way.degrees[1], 0}), arena,
                                     progress.part(part(0), part(0.7)));
      if (!built && built.error().code() == ErrorCode::kCancelled) return cancelled();
      if (built) model = *built;  // without room for it no supports are counted
    }
    if (model) {
      if (const auto lifted = count_supports(*model, settings, arena, way)) lift_mm = *lifted;
    }
    way.layers = static_cast<std::uint32_t>(std::clamp(std::ceil((way.height_mm + lift_mm) / layer - 0.01), 1.0, 4e9));
    if (!progress.advance(part(1))) return cancelled();
  }
  // Ways are only comparable if all of them have been counted.
  const bool all = std::ranges::all_of(ways, [](const WayUp& way) { return way.supports.has_value(); });
  for (WayUp& way : ways) {
    if (!all) way.supports.reset();
    if (!way.supports) continue;
    const double surface = static_cast<double>(samples.area) * way.unit_mm * way.unit_mm;
    way.cost.total += (kScarCounts * way.supports->scar_mm2 + kCleanScarCounts * way.supports->clean_mm2) / surface +
                      kTipsCount * way.supports->tips;
  }
  std::stable_sort(ways.begin() + 1, ways.end(),
                   [](const WayUp& a, const WayUp& b) { return a.cost.total < b.cost.total; });
  return ways;
}

Expected<Orientation> best_way_up(const Cloud& cloud, const SliceSettings& settings, Arena& arena,
                                  const StageProgress& progress) {
  const ArenaScope scope(arena);
  const auto samples = sample_surface(cloud, arena);
  PLUMBLINE_TRY(samples);
  const auto ways = find_ways_up(cloud, *samples, settings, arena, progress);
  PLUMBLINE_TRY(ways);
  const WayUp& best = cheapest(*ways);
  return Orientation{best.degrees, best.cost};
}

}  // namespace plumbline::inline slicer
