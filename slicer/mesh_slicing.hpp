#pragma once
/// From the bytes of a mesh to the crossings of its rays: the stages that slice() and inspect() share.

#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/stage_scope.hpp"
#include "slicer/mesh/mesh_files.hpp"
#include "slicer/mesh/mesh_reading.hpp"
#include "slicer/reader/view_poses.hpp"
#include "slicer/rrep_building.hpp"
#include "slicer/slice_report.hpp"
#include "slicer/slice_settings.hpp"

namespace plumbline::inline slicer {

/// Reads the files once, if they may be a mesh.
/// @param sources  the same files
/// @returns none: they are a scan, and at their beginning again
/// @retval ErrorCode::kOutOfMemory, kCancelled, kCannotRead and all of read_mesh()
[[nodiscard]] Expected<std::optional<SurveyedMesh>> survey_mesh(MeshFiles& files, ScanSources sources,
                                                                const SliceSettings& settings, const StageContext& job);

/// Opens sources and calls on_mesh(files, surveyed, sources) if they are a mesh, else on_scan(sources). Files with a .conf are views of a
/// scanner, and are read as scans. The sources that it hands on are at their beginning again. What was taken from the top of the arena is
/// released.
/// @returns what was called returns, or an error of the type that on_scan returns
template <class OnMesh, class OnScan>
auto read_mesh_or_scan(ScanSources given, const SliceSettings& settings, const StageContext& job, OnMesh on_mesh,
                       OnScan on_scan) -> decltype(on_scan(given)) {
  const ArenaScope all(job.arena);
  if (has_pose_file(given)) return on_scan(given);
  auto files = MeshFiles::open(given, job.arena);
  PLUMBLINE_TRY(files);
  const auto pointers = files->pointers();
  const ScanSources sources = std::span(pointers).first(given.size());
  const auto mesh = survey_mesh(*files, sources, settings, job);
  PLUMBLINE_TRY(mesh);
  if (!*mesh) return on_scan(sources);
  return on_mesh(*files, **mesh, sources);
}

/// Copies what the survey of a mesh has found into the report.
void note(const SurveyedMesh& mesh, PreparationReport& report);

/// The surface of a mesh as points with normals, in the order of a 3D tree: coordinates of the file less survey.bounds.low.
/// @param survey  of the mesh as it lies in the file
/// @returns at the top of the arena
[[nodiscard]] Expected<Cloud> mesh_cloud(MeshFiles& files, const MeshSurvey& survey, const StageContext& job);

/// A mesh as it is placed.
struct PreparedMesh {
  MeshSurvey survey;
  PlacementSettings placing;  ///< with the unit of its format, and the best way up if SliceSettings::orient asks for it
};
/// Checks the units, and finds the best way up if that is asked for: reads the mesh twice, to find the way and to measure it anew.
/// @param settings  placement.rotation_degrees are 0 if the mesh is to be turned
/// @param report    filled as far as it went, also on error
[[nodiscard]] Expected<PreparedMesh> prepare_mesh(MeshFiles& files, const SurveyedMesh& mesh, ScanSources sources,
                                                  const SliceSettings& settings, const StageContext& job,
                                                  PreparationReport& report);

/// Reads the placed mesh once more, three or four times if it has holes, and finds the crossings of all rays.
/// @param settings  as returned by set_threads()
/// @param counts    what the survey has found; the rest is added as far as it went, also on error
/// @returns the caller releases the arena's top
/// @retval ErrorCode::kOutOfMemory  before anything is read again where the survey shows it
/// @retval ErrorCode::kCancelled and all of read_mesh()
[[nodiscard]] Expected<ShotObject> shoot_mesh(MeshFiles& files, const MeshSurvey& survey, const Placement& placement,
                                              const SliceSettings& settings, const StageContext& job,
                                              MeshCounts& counts);

}  // namespace plumbline::inline slicer
