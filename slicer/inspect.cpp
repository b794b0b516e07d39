#include "slicer/inspect.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/cloud/tangent_plane.hpp"
#include "slicer/core/numbers/median.hpp"
#include "slicer/mesh_slicing.hpp"
#include "slicer/preparation.hpp"
#include "slicer/rrep_building.hpp"
#include "slicer/source_checks.hpp"

namespace plumbline {
namespace {

/// Points that are measured, spread evenly over the tree's order. Medians over all points differ by about a percent.
constexpr std::uint32_t kSample = 8192;

/// Sets spacing and roughness.
Status measure(const PreparedScan& scan, const KdTree3& tree, Arena& arena, InspectReport& report) {
  const ArenaScope scope(arena);
  const Cloud& cloud = scan.cloud;
  const std::uint32_t samples = std::min(kSample, cloud.size);
  auto spacing = arena.take_top<float>(samples, "clustering");
  PLUMBLINE_TRY(spacing);
  auto roughness = arena.take_top<float>(samples, "clustering");
  PLUMBLINE_TRY(roughness);
#pragma omp parallel for schedule(dynamic, 64)
  for (std::uint32_t s = 0; s < samples; ++s) {
    const std::uint32_t i = cloud.sampled(s, samples);
    const Vec3f& point = cloud.position[i];
    std::array<Neighbour, kPlaneNeighbours> found = {};
    const std::uint32_t count = tree.nearest(point, found, [i](std::uint32_t other) { return other != i; });
    (*spacing)[s] = count > 0 ? std::sqrt(found[0].distance2) : 0;
    if (count < 3) {
      (*roughness)[s] = 0;
      continue;
    }
    const PrincipalAxes plane = principal_axes(point, std::span(found).first(count), cloud.positions());
    (*roughness)[s] = static_cast<float>(std::abs(plane.axes.col(0).dot(plane.mean)));
  }
  report.spacing = {median(*spacing)};
  report.roughness = {median(*roughness)};
  return {};
}

/// A grid of coarse pixels, with the layers of `placement` where the object fits.
Expected<Placement> place_coarsely(const Box3d& bounds, double unit_mm, const PlacementSettings& settings,
                                   const Expected<Placement>& placement) {
  PlacementSettings coarse = settings;
  coarse.printer.reset();
  coarse.fit = false;
  coarse.scale = placement ? placement->scale / unit_mm : scale_of(bounds.size() * unit_mm, settings);
  coarse.size.reset();
  const double longest = bounds.size().maxCoeff() * unit_mm * coarse.scale;
  constexpr double kShortestMm = 1e-4;  // shorter objects have pixels that no number of pixels counts
  if (longest < kShortestMm) {
    return telling(Told(ToldCode::kTooSmall, {{Fact::kLongestMm, longest}}),
                   fail(ErrorCode::kNoSurface, "the object would be %.2g mm long.\tGive a size", longest));
  }
  coarse.pixel_pitch_mm = static_cast<float>(longest / kCoarsePixels);
  auto placed = place(bounds, unit_mm, coarse);
  if (placed && placement) {
    placed->grid.layers = placement->grid.layers;
    placed->shift[2] = placement->shift[2];
  }
  return placed;
}

Expected<CrossingStore> find_mesh_crossings(MeshFiles& files, const MeshSurvey& survey, ScanSources sources,
                                            SliceSettings settings, Arena& arena, ProgressSink* progress,
                                            InspectReport& report, bool& prepared) {
  const auto mesh = prepare_mesh(files, survey, sources, settings, arena, progress, report);
  PLUMBLINE_TRY(mesh);
  PLUMBLINE_TRY(check_extent(mesh->bounds, sources));
  report.bounds = report.bounds_with_noise = mesh->bounds;
  report.units = units_of(report.bounds, settings.placement);
  const double unit_mm = millimetres_per(report.units);
  report.placement = place(report.bounds, unit_mm, settings.placement);
  prepared = true;
  const auto coarse = place_coarsely(report.bounds, unit_mm, settings.placement, report.placement);
  PLUMBLINE_TRY(coarse);
  static_cast<PreparationCounts&>(report.coarse) = report;
  report.coarse.placement = *coarse;
  auto store = shoot_mesh(files, *mesh, settings, arena, progress, report.coarse);
  report.mesh = report.coarse.mesh;
  return store;
}

Expected<CrossingStore> find_scan_crossings(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                            ProgressSink* progress, InspectReport& report, bool& prepared) {
  const auto measure_all = [&](const PreparedScan& scan, const KdTree3& tree) {
    report.bounds = report.bounds_with_noise = scan.bounds();
    return measure(scan, tree, arena, report);
  };
  const auto admit = [&](const PreparedScan& read) { return check_extent(read.bounds(), sources); };
  auto scan = prepare(sources, settings, arena, progress, report, measure_all, admit);
  PLUMBLINE_TRY(scan);
  const PlacementSettings placing = heed_header(settings.placement, report.scan.header);
  if (scan->cloud.size > 0 || report.floor.points == 0) {
    PLUMBLINE_TRY(check_has_surface(*scan, sources, report, placing));
  }
  if (scan->cloud.size > 0) report.bounds = scan->bounds();
  report.units = units_of(report.bounds, placing);
  const double unit_mm = millimetres_per(report.units);
  report.placement = place(report.bounds, unit_mm, placing);
  prepared = true;
  PLUMBLINE_TRY(check_surface(*scan, sources, report, placing));
  const auto coarse = place_coarsely(report.bounds, unit_mm, placing, report.placement);
  PLUMBLINE_TRY(coarse);
  static_cast<PreparationCounts&>(report.coarse) = report;
  move_to_print(*coarse, *scan, report, report.coarse);
  return shoot_rays(scan->cloud, settings, arena, progress, report.coarse);
}

/// Leaves the crossings of the coarse R-Rep at the bottom of the arena.
/// @param prepared  whether `report` has all of the preparation; an error after that is no error of inspect()
Expected<CrossingStore> find_crossings(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                       ProgressSink* progress, InspectReport& report, bool& prepared) {
  const auto of_mesh = [&](MeshFiles& files, const MeshSurvey& survey, ScanSources given) {
    return find_mesh_crossings(files, survey, given, settings, arena, progress, report, prepared);
  };
  const auto of_scan = [&](ScanSources given) {
    return find_scan_crossings(given, settings, arena, progress, report, prepared);
  };
  return read_mesh_or_scan(sources, settings, arena, progress, report, of_mesh, of_scan);
}

}  // namespace

Status inspect(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
               InspectReport& report, CoarseLook look) {
  SliceSettings checked = set_threads(settings);
  checked.confidence = true;
  const std::size_t bottom = arena.bottom_mark();
  bool prepared = false;
  Status status;
  auto store = find_crossings(sources, checked, arena, progress, report, prepared);
  auto rrep =
      store ? finish_rrep(*store, checked, arena, progress, report.coarse) : tl::unexpected<Error>(store.error());
  if (rrep) {
    if (report.placement) report.placement->grid.layers = rrep->grid.layers;
    status = look(*rrep, report.coarse);
  } else if (prepared && rrep.error().code() != ErrorCode::kCancelled) {
    report.sliced = tl::unexpected<Error>(rrep.error());
  } else {
    status = tl::unexpected<Error>(rrep.error());
  }
  report.coarse.confidence = {};
  arena.release_bottom(bottom);
  return status;
}

}  // namespace plumbline
