#pragma once
/// From the bytes of a mesh to the crossings of its rays: the stages that slice() and inspect() share.

#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/mesh/mesh_files.hpp"
#include "slicer/mesh/mesh_survey.hpp"
#include "slicer/reader/view_poses.hpp"
#include "slicer/rrep/crossing_store.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline {

/// Reads the files once, if they may be a mesh.
/// @param report  scan, scans and mesh are set if they are one
/// @returns none: they are a scan, and at their beginning again
/// @retval ErrorCode::kOutOfMemory, kCancelled, kCannotRead and all of read_mesh()
[[nodiscard]] Expected<std::optional<MeshSurvey>> survey_mesh(MeshFiles& files, const SliceSettings& settings,
                                                              Arena& arena, ProgressSink* progress,
                                                              PreparationCounts& report);

/// Opens sources and calls on_mesh(files, survey, sources) if they are a mesh, else on_scan(sources). Files with a .conf are views of a
/// scanner, and are read as scans. The sources that it hands on are at their beginning again. What was taken from the top of the arena is
/// released.
/// @returns what was called returns, or an error of the type that on_scan returns
template <class OnMesh, class OnScan>
auto read_mesh_or_scan(ScanSources given, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                       PreparationCounts& report, OnMesh on_mesh, OnScan on_scan) -> decltype(on_scan(given)) {
  const ArenaScope all(arena);
  if (has_pose_file(given)) return on_scan(given);
  auto files = MeshFiles::open(given, arena);
  PLUMBLINE_TRY(files);
  const auto mesh = survey_mesh(*files, settings, arena, progress, report);
  PLUMBLINE_TRY(mesh);
  const auto pointers = files->pointers();
  const ScanSources sources = std::span(pointers).first(given.size());
  if (!*mesh) return on_scan(sources);
  return on_mesh(*files, **mesh, sources);
}

/// The surface of a mesh as points with normals, in the order of a 3D tree: coordinates of the file less survey.bounds.low.
/// @param survey  of the mesh as it lies in the file
/// @returns at the top of the arena
[[nodiscard]] Expected<Cloud> mesh_cloud(MeshFiles& files, const MeshSurvey& survey, Arena& arena,
                                         ProgressSink* progress, PreparationCounts& report);

/// Checks the units, and turns the mesh the best way up if `settings.orient` asks for it: reads it twice, to find the way and to measure
/// it anew.
/// @param settings  placement gets the unit of the format, and that way; its rotation_degrees are 0 before
/// @param report    turned is set
/// @returns the survey of the mesh as it stands then
[[nodiscard]] Expected<MeshSurvey> prepare_mesh(MeshFiles& files, const MeshSurvey& survey, ScanSources sources,
                                                SliceSettings& settings, Arena& arena, ProgressSink* progress,
                                                PreparationCounts& report);

/// Reads the placed mesh once more, three or four times if it has holes, and finds the crossings of all rays.
/// @param settings  as returned by set_threads()
/// @param report    its placement and what survey_mesh() has found are known
/// @returns crossings at the bottom of the arena; the caller releases its top
/// @retval ErrorCode::kOutOfMemory  before anything is read again where the survey shows it
/// @retval ErrorCode::kCancelled and all of read_mesh()
[[nodiscard]] Expected<CrossingStore> shoot_mesh(MeshFiles& files, const MeshSurvey& survey,
                                                 const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                                                 SliceReport& report);

}  // namespace plumbline
