#pragma once
/// From the bytes of a mesh to the crossings of its rays: the stages that slice() and inspect() share.

#include <optional>

#include "slicer/core/arena.hpp"
#include "slicer/mesh/mesh_files.hpp"
#include "slicer/mesh/mesh_survey.hpp"
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

/// Reads the placed mesh once more, three times if it is not closed, and finds the crossings of all rays.
/// @param settings  as returned by set_threads()
/// @param report    its placement and what survey_mesh() has found are known
/// @returns crossings at the bottom of the arena; the caller releases its top
/// @retval ErrorCode::kOutOfMemory  before anything is read again where the survey shows it
/// @retval ErrorCode::kCancelled and all of read_mesh()
[[nodiscard]] Expected<CrossingStore> shoot_mesh(MeshFiles& files, const MeshSurvey& survey, const SliceSettings& settings,
                                                 Arena& arena, ProgressSink* progress, SliceReport& report);

}  // namespace plumbline
