#include "slicer/ways_up.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "slicer/coarse_model.hpp"
#include "slicer/layers/rrep_edit.hpp"
#include "slicer/source_checks.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/support_finder.hpp"

namespace plumbline::inline slicer {
namespace {

// Outermost points that may be strays, and are not counted in the object's extent: one in so many points, and at most so many.
constexpr std::uint32_t kMostStrays = 12;
constexpr std::uint32_t kPointsPerStray = 8192;

// What supports add to the total: so many times the share that their scars have of the surface, and so much for each tip.
constexpr double kScarCounts = 40;
constexpr double kCleanScarCounts = 400;
constexpr double kTipsCount = 1.0 / 200;

/// Volume of all struts but the raft's, and the tips', which are in the object, mm3. Coarse pixels make struts thicker, so their radii are limited to those asked for.
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
Expected<double> count_supports(const CoarseModel& model, const SliceSettings& settings, Arena& arena, WayUp& way) {
  const ArenaScope top(arena);
  const BottomScope bottom(arena);
  SupportSettings wanted = *settings.supports;
  wanted.added = wanted.blocked = {};  // they are for one way up
  const CoarseVoxels voxels = voxels_of(model, way.degrees, way.unit_mm, support_room(wanted).beside_mm);
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

/// How far the object reaches along a direction: as far as its patches, and its points up to a cell beyond, without a few strays.
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
  std::optional<CoarseModel> model;
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
      const auto built = build_coarse_model(samples, rotation_matrix({way.degrees[0], way.degrees[1], 0}), arena,
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
