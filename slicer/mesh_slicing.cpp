#include "slicer/mesh_slicing.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/mesh/hit_resolver.hpp"
#include "slicer/mesh/mesh_dipoles.hpp"
#include "slicer/mesh/mesh_reading.hpp"
#include "slicer/mesh/open/lone_columns.hpp"
#include "slicer/plan/mesh_plan.hpp"
#include "slicer/reader/scan_reader.hpp"
#include "slicer/source_checks.hpp"
#include "slicer/ways_up.hpp"

namespace plumbline::inline slicer {
namespace {

/// Cells along the longest side of a mesh, if the winding number follows its rim.
constexpr float kRimCells = 256;
/// Share of the time of turning a mesh that reading it takes.
constexpr double kCloudRead = 0.3;
/// Share of the time of finding the hits that finding the moves of the corners takes.
constexpr double kShiftRead = 0.3;
/// Scan units: the cells of a longer mesh would have areas that no float holds.
constexpr double kLongestTurned = 1e12;

// Shares of the rays' time, if the mesh is not closed.
constexpr double kHolesClosed = 0.1;
constexpr double kFieldRead = 0.4;
constexpr double kFieldBuilt = 0.7;

/// Refuses a mesh that has no room, without its copy if need be.
Status admit(MeshFiles& files, const MeshNeed& without_copy, std::uint32_t threads, const StageContext& job) {
  MeshNeed need = without_copy;
  need.most_vertices = files.vertices_kept(need.most_vertices);
  need.copied_bytes = files.copied_bytes();
  if (admit_mesh(need, threads, job.arena, job.memory.planned_bytes)) return {};
  files.drop_copy(job.arena);
  return admit_mesh(without_copy, threads, job.arena, job.memory.planned_bytes);
}

/// Finds the hits of all rays, and decides which way each shell faces if need be.
Expected<MeshHits> find_hits(const PlacedMesh& mesh, const StageContext& job, const StageProgress& progress) {
  auto found = read_hits(mesh, job.arena, progress);
  PLUMBLINE_TRY(found);
  if (found->closed && !has_doubtful_sides(found->hits)) return found;
  const std::uint64_t vertices = mesh.files.vertices_kept(mesh.survey.most_vertices);
  std::size_t& planned = job.memory.planned(Stage::kRayGrid);
  planned = std::max(planned, job.arena.used() + sides_bytes(mesh.survey.triangles, vertices, job.arena.available()));
  PLUMBLINE_TRY(read_sides(mesh, *found, job.arena, progress));
  return found;
}

/// Whether most rays leave the mesh before they enter it: its faces face inwards.
bool is_inside_out(const HitList& hits) {
  std::int64_t winding = 0;
  hits.for_each_ray([&](std::span<const PackedHit> ray) { winding += hits.packing().winding(ray.front()); });
  return winding < 0;
}

/// The same with outlines that are moved. Which way that is depends on the sides of the faces: if some face inwards, all is found anew.
/// @param shift  empty
Expected<MeshHits> find_moved_hits(PlacedMesh& mesh, double by_mm, std::optional<OutlineShift>& shift,
                                   const StageContext& job, const StageProgress& progress) {
  auto made = OutlineShift::create(mesh.survey.triangles, job.arena);
  PLUMBLINE_TRY(made);
  shift = *made;
  const std::size_t mark = job.arena.top_mark();
  TriangleSides sides;
  for (bool again = false;; again = true) {
    const StageProgress half = progress.part(again ? 0.5 : 0, again ? 1 : 0.5);
    PLUMBLINE_TRY(read_shift(mesh, by_mm, sides, *shift, job.arena, half.part(0, kShiftRead)));
    job.arena.release_top(mark);
    mesh.shift = &*shift;
    auto found = find_hits(mesh, job, half.part(kShiftRead, 1));
    if (!found || again) return found;
    const bool inside_out = is_inside_out(found->hits);
    if (found->turned == 0 && !inside_out) return found;
    if (inside_out) by_mm = -by_mm;
    sides = found->sides;
  }
}

/// Follows the rim alone.
/// @param box  of the placed mesh, mm
Status follow_rim(const PlacedMesh& mesh, const Box3f& box, const HitList& hits, BaseChoice base,
                  const StageContext& job, MeshField& field) {
  field.cell = std::max(box.size().maxCoeff() / kRimCells, mesh.grid.layer_height_mm);
  job.memory.planned(Stage::kRays) += Arena::rounded(field.rim.corners.size_bytes());
  if (base == BaseChoice::kFlat) field.base = box.low[2];
  if (base == BaseChoice::kAuto) PLUMBLINE_TRY(mirror_open_underside(field, hits, mesh.grid, box.low[2], job.arena));
  return {};
}

/// Reads the mesh into a tree of dipoles.
/// @param box  of the placed mesh, mm
Status build_tree(const PlacedMesh& mesh, const Box3f& box, const TriangleSides& sides,
                  std::span<const LatticeTriangle> caps, BaseChoice base, const StageContext& job, MeshField& field) {
  Arena& arena = job.arena;
  const std::size_t reading = kReaderWorkspace + VertexList::bytes_needed(mesh.survey.most_vertices);
  const std::uint32_t slots = MeshDipoles::slots_in(arena.available() - std::min(arena.available(), reading));
  std::size_t& planned = job.memory.planned(Stage::kRays);
  planned =
      std::max(planned + MeshDipoles::field_bytes(slots), arena.used() + reading + MeshDipoles::reading_bytes(slots));
  const double scale = mesh.transform.scale;
  const auto dipoles =
      read_dipoles(mesh.files, mesh.survey.most_vertices,
                   {mesh.transform, box, mesh.survey.area * scale * scale, caps, mesh.lattice().step(), sides}, arena,
                   {job.progress, Stage::kRays, kHolesClosed, kFieldRead});
  PLUMBLINE_TRY(dipoles);
  const auto nodes =
      arena.take_top<WindingTree::Node>(WindingTree::nodes_needed(dipoles->cloud.size), "winding number");
  PLUMBLINE_TRY(nodes);
  field.winding = WindingTree::build(dipoles->cloud, *nodes);
  field.cell = dipoles->cell;
  if (base != BaseChoice::kNone) field.winding->set_base(box.low[2], field.cell, base == BaseChoice::kFlat);
  return {};
}

/// The winding number of an open mesh. Hits that are there twice are left out.
Expected<MeshField> find_field(const PlacedMesh& mesh, MeshHits& found, const ClosedHoles& holes,
                               const SliceSettings& settings, const StageContext& job) {
  HitList& hits = found.hits;
  // Where sides are known, what is there twice has been left out, and two hits of a ray in one layer are two sheets.
  const bool doubled = found.sides.empty() && hits.drop_doubled();
  MeshField field;
  if (holes.rim.empty()) {
    field.winding.emplace();
  } else {
    field.rim = {holes.rim, mesh.lattice().step()};
  }
  Box3f box;
  for (const Vec3d& corner : {mesh.survey.bounds.low, mesh.survey.bounds.high}) {
    box.extend(Vec3d(corner * mesh.transform.scale + mesh.transform.shift).cast<float>());
  }
  const auto outwards = static_cast<float>(std::max(0.0, OutlineShift::kMitre * settings.absolute_correction_mm));
  box.low -= Vec3f(outwards, outwards, 0);
  box.high += Vec3f(outwards, outwards, 0);
  const auto tile_of = [](float mm, float pitch, std::uint32_t tiles) {
    return std::min(static_cast<std::uint32_t>(std::max(0.0F, mm / pitch)) / kTileSide, tiles - 1);
  };
  field.first_column = tile_of(box.low[0], mesh.grid.pitch_x_mm, hits.tile_columns());
  field.end_column = tile_of(box.high[0], mesh.grid.pitch_x_mm, hits.tile_columns()) + 1;
  field.first_row = tile_of(box.low[1], mesh.grid.pitch_y_mm, hits.tile_rows());
  field.end_row = tile_of(box.high[1], mesh.grid.pitch_y_mm, hits.tile_rows()) + 1;
  job.memory.planned(Stage::kRays) += resolve_bytes(settings.threads, &field) -
                                      resolve_bytes(settings.threads, nullptr) + lone_columns_bytes(mesh.grid);
  PLUMBLINE_TRY(field.winding ? build_tree(mesh, box, found.sides, holes.caps, settings.base, job, field)
                              : follow_rim(mesh, box, hits, settings.base, job, field));
  const std::size_t words = BitImage::words_needed(hits.tile_columns(), hits.tile_rows());
  const auto doubtful = job.arena.take_top<std::uint64_t>(words, "mesh");
  PLUMBLINE_TRY(doubtful);
  field.doubtful = BitImage(*doubtful, hits.tile_columns(), hits.tile_rows());
  field.doubtful.clear();
  // Faces that are there twice weigh double in the field: it finds solid where there is none. Their hits are whole.
  if (!doubled) {
    PLUMBLINE_TRY(find_doubtful(field, hits, mesh.grid, settings.threads, job.arena,
                                {job.progress, Stage::kRays, kFieldRead, kFieldBuilt}));
  }
  return field;
}

Expected<MeshHint> hint_of_files(MeshFiles& files, Arena& arena) {
  const BottomScope scope(arena);
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, "mesh");
  PLUMBLINE_TRY(workspace);
  return files.hint(*workspace);
}

/// @param degrees        PlacementSettings::rotation_degrees
/// @param most_vertices  of a file; none: unknown
Expected<SurveyedMesh> survey_files(MeshFiles& files, const Vec3d& degrees, std::optional<std::uint64_t> most_vertices,
                                    const StageContext& job) {
  const StageScope stage(Stage::kRead, job);
  return read_survey(files, rotation_matrix(degrees), most_vertices, job.arena, {job.progress, Stage::kRead});
}

tl::unexpected<Error> fail_empty(ScanSources sources, const MeshCounts& counts) {
  const auto title = title_of(sources);
  if (counts.not_finite == 0) {
    return telling(
        Told(ToldCode::kNoTriangles),
        fail(ErrorCode::kNoPoints, "%s: has no triangle.\tExport the mesh again, with its faces", title.c_str()));
  }
  return telling(Told(ToldCode::kNoTriangles), fail(ErrorCode::kNoPoints,
                                                    "%s: has no usable triangle: each has a coordinate that is not "
                                                    "finite or huge (%llu in all).\tExport it again",
                                                    title.c_str(), static_cast<unsigned long long>(counts.not_finite)));
}

/// Reads a mesh that is admitted, and finds the crossings of one ray of each pixel.
/// @param grid  with the ray
Expected<ShotObject> shoot_rays_of(MeshFiles& files, const MeshSurvey& survey, const Placement& placement,
                                   const PrintGrid& grid, const SliceSettings& settings, const StageContext& job,
                                   MeshCounts& counts) {
  const double correction = settings.absolute_correction_mm;
  const bool moves = std::abs(correction) > 0;
  // The mesh is moved so that the ray is at the pixel's centre: everything that reads it agrees where it lies.
  Vec3d shift_mm = placement.shift;
  shift_mm[0] += static_cast<double>((0.5F - grid.ray_x) * grid.pitch_x_mm);
  shift_mm[1] += static_cast<double>((0.5F - grid.ray_y) * grid.pitch_y_mm);
  PlacedMesh mesh{files, survey, placement.grid, {placement.rotation, placement.scale, shift_mm}};
  std::optional<OutlineShift> shift;
  auto found = [&] {
    const StageScope stage(Stage::kRayGrid, job);
    const StageProgress progress{job.progress, Stage::kRayGrid};
    return moves ? find_moved_hits(mesh, correction, shift, job, progress) : find_hits(mesh, job, progress);
  }();
  PLUMBLINE_TRY(found);
  counts.closed = found->closed;
  counts.flat = found->flat;
  counts.turned = found->turned;
  counts.dropped = found->dropped;
  counts.hits = found->hits.size();
  const StageScope stage(Stage::kRays, job);
  const StageProgress progress{job.progress, Stage::kRays};
  ClosedHoles holes{.all = found->closed};
  if (!holes.all) {
    const auto closed = close_holes(mesh, *found, job.arena, progress.part(0, kHolesClosed));
    PLUMBLINE_TRY(closed);
    holes = *closed;
  }
  counts.closed_holes = holes.holes;
  files.drop_copy(job.arena);  // so that it takes no room from what else is read: that would change the cells
  job.arena.reset_peak();
  std::optional<MeshField> field;
  if (!holes.all) {
    const auto open = find_field(mesh, *found, holes, settings, job);
    PLUMBLINE_TRY(open);
    field = *open;
  }
  const double done = field ? kFieldBuilt : counts.closed ? 0 : kHolesClosed;
  auto store = resolve_hits(found->hits, mesh.grid, field ? &*field : nullptr, settings.threads, job.arena,
                            progress.part(done, 1), counts);
  PLUMBLINE_TRY(store);
  // Without room for the search, the columns stay.
  if (field) static_cast<void>(drop_lone_columns(*store, job.arena));
  return ShotObject{
      .store = *store, .placement = placement, .flat_underside = field && field->has_base(), .is_mesh = true};
}

}  // namespace

Expected<std::optional<SurveyedMesh>> survey_mesh(MeshFiles& files, ScanSources sources, const SliceSettings& settings,
                                                  const StageContext& job) {
  if (settings.as == ReadAs::kPoints) return std::nullopt;
  const auto hint = hint_of_files(files, job.arena);
  PLUMBLINE_TRY(hint);
  const bool sure = settings.as == ReadAs::kMesh || *hint >= MeshHint::kPackedMesh;
  if (!sure && *hint == MeshHint::kNone) return std::nullopt;
  PLUMBLINE_TRY(check_units(sources, settings.placement.units, files.some_in_mm(), files.some_in_any_unit()));
  PLUMBLINE_TRY(files.keep_all(job.arena));
  const auto most_vertices = *hint == MeshHint::kTriangles ? std::optional<std::uint64_t>(0) : std::nullopt;
  const auto found = survey_files(files, settings.placement.rotation_degrees, most_vertices, job);
  // What a mesh has no room for may fit as points, which are thinned. With any other error in its faces, a mesh must not become
  // points without a word.
  if (!found && (sure || found.error().code() != ErrorCode::kOutOfMemory)) return tl::unexpected<Error>(found.error());
  if (found && sure && found->survey.triangles == 0) return fail_empty(sources, found->counts);
  if (found && (sure || found->survey.is_object())) return std::optional(*found);
  files.drop_copy(job.arena);
  PLUMBLINE_TRY(files.rewind());
  return std::nullopt;
}

void note(const SurveyedMesh& mesh, PreparationReport& report) {
  report.mesh = mesh.counts;
  report.scans = mesh.scans;
  report.scan = sum_of(mesh.scans);
}

Expected<Cloud> mesh_cloud(MeshFiles& files, const MeshSurvey& survey, const StageContext& job) {
  const StageScope stage(Stage::kNormals, job);
  const double longest = survey.bounds.size().maxCoeff();
  if (longest > kLongestTurned) {
    return fail(ErrorCode::kDoesNotFit, "the mesh is %.3g units long.\tExport it again, or turn it", longest);
  }
  Box3f box;
  box.extend(Vec3f::Zero());
  box.extend(survey.bounds.size().cast<float>());
  const DipoleSurface surface{{Mat3d::Identity(), 1, -survey.bounds.low}, box, survey.area};
  const auto dipoles =
      read_dipoles(files, survey.most_vertices, surface, job.arena, {job.progress, Stage::kNormals, 0, kCloudRead});
  PLUMBLINE_TRY(dipoles);
  return dipoles->cloud;
}

Expected<PreparedMesh> prepare_mesh(MeshFiles& files, const SurveyedMesh& mesh, ScanSources sources,
                                    const SliceSettings& settings, const StageContext& job, PreparationReport& report) {
  note(mesh, report);
  const auto ignored = check_units(sources, settings.placement.units, mesh.scans);
  PLUMBLINE_TRY(ignored);
  report.ignored_units = *ignored;
  PlacementSettings placing = heed_header(settings.placement, sum_of(mesh.scans).header);
  placing.sized_extent = mesh.survey.came.size();
  if (!settings.orient) return PreparedMesh{mesh.survey, placing};
  {
    const ArenaScope scope(job.arena);
    const auto cloud = mesh_cloud(files, mesh.survey, job);
    PLUMBLINE_TRY(cloud);
    SliceSettings turning = settings;
    turning.placement = placing;
    const auto best = best_way_up(*cloud, turning, job.arena, {job.progress, Stage::kNormals, kCloudRead, 1});
    PLUMBLINE_TRY(best);
    report.turned = *best;
    placing.rotation_degrees = {best->degrees[0], best->degrees[1], 0};
  }
  const auto turned = survey_files(files, placing.rotation_degrees, mesh.survey.most_vertices, job);
  PLUMBLINE_TRY(turned);
  note(*turned, report);
  return PreparedMesh{turned->survey, placing};
}

Expected<ShotObject> shoot_mesh(MeshFiles& files, const MeshSurvey& survey, const Placement& placement,
                                const SliceSettings& settings, const StageContext& job, MeshCounts& counts) {
  MeshNeed need = need_of(counts, placement);
  need.grey = settings.grey;
  if (std::abs(settings.absolute_correction_mm) > 0) need.shift_bytes = OutlineShift::bytes_needed(survey.triangles);
  PLUMBLINE_TRY(admit(files, need, settings.threads, job));
  job.memory.planned(Stage::kRead) = job.memory.peak(Stage::kRead);  // it has been read, with room for more vertices
  if (rays_for(settings.grey) == 1) {
    return shoot_rays_of(files, survey, placement, placement.grid, settings, job, counts);
  }
  std::array<CrossingStore, kRaysAround> others;
  const auto planned = job.memory.planned_bytes;
  for (std::uint32_t i = 0; i < others.size(); ++i) {
    const ArenaScope pass(job.arena);
    MeshCounts again = counts;
    auto shot = shoot_rays_of(files, survey, placement, with_ray(placement.grid, i + 1), settings, job, again);
    PLUMBLINE_TRY(shot);
    others[i] = shot->store;
    job.memory.planned_bytes = planned;
  }
  auto shot = shoot_rays_of(files, survey, placement, placement.grid, settings, job, counts);
  PLUMBLINE_TRY(shot);
  shot->others = others;
  shot->has_others = true;
  return shot;
}

}  // namespace plumbline::inline slicer
