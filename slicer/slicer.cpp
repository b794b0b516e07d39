#include "slicer/slicer.hpp"

#include "slicer/preparation.hpp"
#include "slicer/rrep_building.hpp"

namespace plumbline {
namespace {

Expected<CrossingStore> find_crossings(ScanSources sources, const SliceSettings& settings, Arena& arena,
                                       ProgressSink* progress, SliceReport& report) {
  const ArenaScope scan_and_trees(arena);
  PreparationReport found;
  auto scan = prepare(sources, settings, arena, progress, found);
  static_cast<PreparationCounts&>(report) = found;
  PLUMBLINE_TRY(scan);
  PLUMBLINE_TRY(check_surface(*scan, sources, found));
  const Box3d bounds = scan->bounds();
  report.units = units_of(bounds, settings.placement);
  report.units_guessed = settings.placement.units == Units::kAuto;
  const auto placement = place(bounds, millimetres_per(report.units), settings.placement);
  PLUMBLINE_TRY(placement);
  move_to_print(*placement, *scan, found, report);
  return shoot_rays(scan->cloud, settings, arena, progress, report);
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
