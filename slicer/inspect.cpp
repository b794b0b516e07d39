#include "slicer/inspect.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/cloud/tangent_plane.hpp"
#include "slicer/core/numbers/median.hpp"
#include "slicer/mesh_slicing.hpp"
#include "slicer/preparation.hpp"
#include "slicer/rrep_building.hpp"
#include "slicer/source_checks.hpp"

namespace plumbline::inline slicer {
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
  coarse.scale = placement ? placement->scale / unit_mm
                           : scale_of(settings.sized_extent.value_or(bounds.size()) * unit_mm, settings);
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

}  // namespace

Status inspect(ScanSources given, const SliceSettings& asked, Arena& arena, ProgressSink* progress,
               InspectReport& report, CoarseLook look) {
  SliceSettings settings = set_threads(asked);
  settings.confidence = true;
  settings.absolute_correction_mm = 0;  // the coarse pixels do not show it
  const StageContext job{arena, progress, report};
  const StageContext coarsely{arena, progress, report.coarse};
  bool prepared = false;  // whether `report` has all of the preparation; an error after that is no error of inspect()
  const auto place_object = [&](const PlacementSettings& placing) {
    report.came = placing.sized_extent.value_or(report.bounds.size());
    report.units = units_of(report.bounds, placing);
    report.placement = place(report.bounds, millimetres_per(report.units), placing);
    prepared = true;
  };
  const auto begin_coarse = [&](const PlacementSettings& placing) {
    static_cast<PreparationReport&>(report.coarse) = report;
    return place_coarsely(report.bounds, millimetres_per(report.units), placing, report.placement);
  };
  const auto of_mesh = [&](MeshFiles& files, const SurveyedMesh& surveyed,
                           ScanSources sources) -> Expected<ShotObject> {
    const auto mesh = prepare_mesh(files, surveyed, sources, settings, job, report);
    PLUMBLINE_TRY(mesh);
    PLUMBLINE_TRY(check_extent(mesh->survey.bounds, sources));
    report.bounds = report.bounds_with_noise = mesh->survey.bounds;
    place_object(mesh->placing);
    const auto coarse = begin_coarse(mesh->placing);
    PLUMBLINE_TRY(coarse);
    auto shot = shoot_mesh(files, mesh->survey, *coarse, settings, coarsely, *report.mesh);
    report.coarse.mesh = report.mesh;
    return shot;
  };
  const auto of_scan = [&](ScanSources sources) -> Expected<ShotObject> {
    const auto measure_all = [&](const PreparedScan& scan, const KdTree3& tree) {
      report.bounds = report.bounds_with_noise = scan.bounds();
      return measure(scan, tree, arena, report);
    };
    const auto read = read_points(sources, settings, job, report);
    PLUMBLINE_TRY(read);
    PLUMBLINE_TRY(check_extent(read->bounds(), sources));
    const auto scan = prepare(*read, settings, job, report, measure_all);
    PLUMBLINE_TRY(scan);
    report.lengths = scan->lengths;
    PlacementSettings placing = heed_header(settings.placement, scan->counts.scan.header);
    placing.sized_extent = extent_as_it_came(*scan, settings, report.turned);
    if (scan->cloud.size > 0) report.bounds = scan->bounds();
    if (scan->cloud.size > 0 || scan->surface.floor.points == 0) {
      PLUMBLINE_TRY(check_has_surface(*scan, sources, placing));
    }
    place_object(placing);
    PLUMBLINE_TRY(check_surface(*scan, sources, placing));
    const auto coarse = begin_coarse(placing);
    PLUMBLINE_TRY(coarse);
    const PlacedScan placed = move_to_print(*coarse, *scan);
    report.coarse.lengths = placed.lengths;
    return shoot_rays(placed, settings, coarsely);
  };
  const std::size_t bottom = arena.bottom_mark();
  auto shot = read_mesh_or_scan(given, settings, job, of_mesh, of_scan);
  auto rrep = shot ? finish_rrep(*shot, settings, coarsely, report.coarse) : tl::unexpected<Error>(shot.error());
  Status status;
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

}  // namespace plumbline::inline slicer
