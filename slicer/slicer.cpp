#include "slicer/slicer.hpp"

#include "slicer/mesh_slicing.hpp"
#include "slicer/placement/core_bounds.hpp"
#include "slicer/preparation.hpp"
#include "slicer/rrep_building.hpp"
#include "slicer/source_checks.hpp"

namespace plumbline {
namespace {

/// Refuses an object that can't fit, whatever the next stages leave out of it, before they take their minutes. An object that is
/// too large by little is refused when it is placed.
Status check_core_fits(const PreparedScan& scan, const PlacementSettings& settings, Arena& arena) {
  if (settings.size && settings.size->side != Side::kLength && !settings.fit) {
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

Expected<CrossingStore> find_scan_crossings(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                            ProgressSink* progress, SliceReport& report) {
  PreparationReport found;
  PlacementSettings placing = settings.placement;
  const auto admit = [&](const PreparedScan& read) -> Status {
    const ScanHeader& header = found.scan.header;
    placing = heed_header(placing, header);
    PLUMBLINE_TRY(check_no_speck(read.bounds(), sources, placing, header.is_in_mm));
    if (settings.orient) return {};  // it may fit when it is turned
    return check_core_fits(read, placing, arena);
  };
  auto scan = prepare(sources, settings, arena, progress, found, kNoMeasurement, admit);
  static_cast<PreparationCounts&>(report) = found;
  PLUMBLINE_TRY(scan);
  PLUMBLINE_TRY(check_surface(*scan, sources, found, placing));
  const Box3d bounds = scan->bounds();
  report.units = units_of(bounds, placing);
  report.units_guessed = placing.units == Units::kAuto && !placing.size;
  const auto placement = place(bounds, millimetres_per(report.units), placing);
  PLUMBLINE_TRY(placement);
  move_to_print(*placement, *scan, found, report);
  return shoot_rays(scan->cloud, settings, arena, progress, report);
}

Expected<CrossingStore> find_mesh_crossings(MeshFiles& files, const MeshSurvey& survey, ScanSources sources,
                                            SliceSettings settings, Arena& arena, ProgressSink* progress,
                                            SliceReport& report) {
  const auto mesh = prepare_mesh(files, survey, sources, settings, arena, progress, report);
  PLUMBLINE_TRY(mesh);
  PLUMBLINE_TRY(check_no_speck(mesh->bounds, sources, settings.placement, report.scan.header.is_in_mm));
  report.units = units_of(mesh->bounds, settings.placement);
  report.units_guessed = settings.placement.units == Units::kAuto && !settings.placement.size;
  const auto placement = place(mesh->bounds, millimetres_per(report.units), settings.placement);
  PLUMBLINE_TRY(placement);
  report.placement = *placement;
  return shoot_mesh(files, *mesh, settings, arena, progress, report);
}

Expected<CrossingStore> find_crossings(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                       ProgressSink* progress, SliceReport& report) {
  const auto of_mesh = [&](MeshFiles& files, const MeshSurvey& survey, ScanSources given) {
    return find_mesh_crossings(files, survey, given, settings, arena, progress, report);
  };
  const auto of_scan = [&](ScanSources given) { return find_scan_crossings(given, settings, arena, progress, report); };
  return read_mesh_or_scan(sources, settings, arena, progress, report, of_mesh, of_scan);
}

}  // namespace

Expected<RRep> slice(ScanSources sources, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                     SliceReport& report) {
  const SliceSettings checked = set_threads(settings);
  const std::size_t bottom = arena.bottom_mark();
  auto store = find_crossings(sources, checked, arena, progress, report);
  auto rrep = store ? finish_rrep(*store, checked, arena, progress, report) : tl::unexpected<Error>(store.error());
  if (!rrep) {
    report.confidence = {};
    arena.release_bottom(bottom);
  }
  return rrep;
}

}  // namespace plumbline
