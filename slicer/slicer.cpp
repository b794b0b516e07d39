#include "slicer/slicer.hpp"

#include "slicer/mesh_slicing.hpp"
#include "slicer/placement/core_bounds.hpp"
#include "slicer/preparation.hpp"
#include "slicer/rrep_building.hpp"
#include "slicer/source_checks.hpp"

namespace plumbline::inline slicer {
namespace {

/// Refuses an object that can't fit, whatever the next stages leave out of it, before they take their minutes. An object that is
/// too large by little is refused when it is placed.
Status check_core_fits(const ReadScan& scan, const PlacementSettings& settings, Arena& arena) {
  const bool sized_as_it_lies = settings.size && settings.rotation_degrees == Vec3d::Zero();
  if (sized_as_it_lies && settings.size->side != Side::kLength && !settings.fit) {
    Box3d side;  // the other sides depend on the object's extents
    side.extend(Vec3d::Zero());
    side.extend(Vec3d::Unit(static_cast<int>(settings.size->side)));
    PLUMBLINE_TRY(place(side, 1, settings));
    return {};
  }
  if (settings.fit || settings.size || settings.units == Units::kAuto) return {};
  const auto core = core_bounds(scan.cloud.positions(), arena);
  PLUMBLINE_TRY(core);
  const double unit_mm = millimetres_per(settings.units);
  if (place(scan.in_scan(*core), unit_mm, settings)) return {};
  const auto object = dense_bounds(scan.cloud.positions(), *core, arena);
  PLUMBLINE_TRY(object);
  PLUMBLINE_TRY(place(scan.in_scan(*object), unit_mm, settings));
  return {};
}

/// Places an object, and notes where.
/// @param placing  with the unit that its format fixes, if it fixes one
Expected<Placement> place_object(const Box3d& bounds, const PlacementSettings& placing, SliceReport& report) {
  report.units = units_of(bounds, placing);
  report.units_guessed = placing.units == Units::kAuto && !placing.size;
  const auto placement = place(bounds, millimetres_per(report.units), placing);
  if (placement) report.placement = *placement;
  return placement;
}

}  // namespace

Expected<RRep> slice(ScanSources given, const SliceSettings& asked, Arena& arena, ProgressSink* progress,
                     SliceReport& report) {
  const SliceSettings settings = set_threads(asked);
  const StageContext job{arena, progress, report};
  const auto of_mesh = [&](MeshFiles& files, const SurveyedMesh& surveyed,
                           ScanSources sources) -> Expected<ShotObject> {
    const auto mesh = prepare_mesh(files, surveyed, sources, settings, job, report);
    PLUMBLINE_TRY(mesh);
    PLUMBLINE_TRY(check_no_speck(mesh->survey.bounds, sources, mesh->placing, sum_of(surveyed.scans).header));
    const auto placement = place_object(mesh->survey.bounds, mesh->placing, report);
    PLUMBLINE_TRY(placement);
    return shoot_mesh(files, mesh->survey, *placement, settings, job, *report.mesh);
  };
  const auto of_scan = [&](ScanSources sources) -> Expected<ShotObject> {
    const auto read = read_points(sources, settings, job, report);
    PLUMBLINE_TRY(read);
    const ScanHeader& header = read->counts.scan.header;
    PlacementSettings placing = heed_header(settings.placement, header);
    PLUMBLINE_TRY(check_no_speck(read->bounds(), sources, placing, header));
    if (!settings.orient) PLUMBLINE_TRY(check_core_fits(*read, placing, arena));  // it may fit when it is turned
    const auto scan = prepare(*read, settings, job, report);
    PLUMBLINE_TRY(scan);
    PLUMBLINE_TRY(check_surface(*scan, sources, placing));
    placing.sized_extent = extent_as_it_came(*scan, settings, report.turned);
    const auto placement = place_object(scan->bounds(), placing, report);
    PLUMBLINE_TRY(placement);
    const PlacedScan placed = move_to_print(*placement, *scan, settings.absolute_correction_mm);
    report.placement = placed.placement;
    report.lengths = placed.lengths;
    return shoot_rays(placed, settings, job);
  };
  const std::size_t bottom = arena.bottom_mark();
  auto shot = read_mesh_or_scan(given, settings, job, of_mesh, of_scan);
  auto rrep = shot ? finish_rrep(*shot, settings, job, report) : tl::unexpected<Error>(shot.error());
  if (!rrep) arena.release_bottom(bottom);
  return rrep;
}

}  // namespace plumbline::inline slicer
