#include "slicer/mesh_slicing.hpp"

#include <algorithm>

#include "slicer/core/stage_scope.hpp"
#include "slicer/mesh/hit_resolver.hpp"
#include "slicer/mesh/mesh_dipoles.hpp"
#include "slicer/mesh/mesh_reading.hpp"
#include "slicer/mesh/open/lone_columns.hpp"
#include "slicer/orientation/orientations.hpp"
#include "slicer/plan/mesh_plan.hpp"
#include "slicer/reader/scan_reader.hpp"
#include "slicer/source_checks.hpp"

namespace plumbline {
namespace {

/// Cells along the longest side of a mesh, if the winding number follows its rim.
constexpr float kRimCells = 256;
/// Share of the time of turning a mesh that reading it takes.
constexpr double kCloudRead = 0.3;
/// Scan units: the cells of a longer mesh would have areas that no float holds.
constexpr double kLongestTurned = 1e12;

/// One job after its survey.
class MeshStages {
 public:
  MeshStages(MeshFiles& files, const MeshSurvey& survey, const SliceSettings& settings, Arena& arena,
             ProgressSink* progress, SliceReport& report)
      : files_(files),
        survey_(survey),
        settings_(settings),
        arena_(arena),
        progress_(progress),
        report_(report),
        transform_{report.placement.rotation, report.placement.scale, report.placement.shift} {
    for (const Vec3d& corner : {survey.bounds.low, survey.bounds.high}) {
      box_.extend(Vec3d(corner * report.placement.scale + report.placement.shift).cast<float>());
    }
  }

  Expected<CrossingStore> run() {
    PLUMBLINE_TRY(admit());
    constexpr auto kReading = static_cast<std::size_t>(Stage::kRead);
    report_.planned_bytes[kReading] = report_.peak_bytes[kReading];  // it has been read, with room for more vertices
    PLUMBLINE_TRY(find_hits());
    bool whole = found_.closed;
    if (whole) files_.drop_copy(arena_);
    const StageScope stage(Stage::kRays, arena_, progress_, report_.peak_bytes);
    double done = 0;
    if (!whole) {
      const auto holes =
          close_holes(files_, survey_, grid(), transform_, found_, arena_, {progress_, Stage::kRays, 0, kHolesClosed});
      PLUMBLINE_TRY(holes);
      files_.drop_copy(arena_);  // so that it takes no room from what else is read: that would change the cells
      arena_.reset_peak();
      report_.mesh->closed_holes = holes->holes;
      rim_ = holes->rim;
      caps_ = holes->caps;
      whole = holes->all;
      done = kHolesClosed;
    }
    if (!whole) {
      // Else what is there twice has been left out, and two hits of a ray in one layer are two sheets.
      if (!has_sides_) doubled_ = hits_.drop_doubled();
      done = kFieldBuilt;
      find_tiles();
      PLUMBLINE_TRY(rim_.empty() ? build_field() : follow_rim());
      // Faces that are there twice weigh double in the field: it finds solid where there is none. Their hits are whole.
      if (!doubled_) {
        PLUMBLINE_TRY(find_doubtful(field_, hits_, grid(), settings_.threads, arena_,
                                    {progress_, Stage::kRays, kFieldRead, kFieldBuilt}));
      }
    }
    auto store = resolve_hits(hits_, grid(), whole ? nullptr : &field_, settings_.threads, arena_,
                              {progress_, Stage::kRays, done, 1}, *report_.mesh);
    // Without room for the search, the columns stay.
    if (store && !whole) static_cast<void>(drop_lone_columns(*store, arena_));
    return store;
  }

 private:
  // Shares of the rays' time, if the mesh is not closed.
  static constexpr double kHolesClosed = 0.1;
  static constexpr double kFieldRead = 0.4;
  static constexpr double kFieldBuilt = 0.7;

  const PrintGrid& grid() const { return report_.placement.grid; }

  /// Refuses a mesh that has no room, without its copy if need be.
  Status admit() {
    MeshNeed need = need_of(*report_.mesh, report_.placement);
    const MeshNeed without_copy = need;
    need.most_vertices = files_.vertices_kept(need.most_vertices);
    need.copied_bytes = files_.copied_bytes();
    if (admit_mesh(need, settings_.threads, arena_, report_.planned_bytes)) return {};
    files_.drop_copy(arena_);
    return admit_mesh(without_copy, settings_.threads, arena_, report_.planned_bytes);
  }

  Status find_hits() {
    const StageScope stage(Stage::kRayGrid, arena_, progress_, report_.peak_bytes);
    const auto found = read_hits(files_, survey_, grid(), transform_, arena_, {progress_, Stage::kRayGrid});
    PLUMBLINE_TRY(found);
    found_ = *found;
    report_.mesh->closed = found->closed;
    report_.mesh->flat = found->flat;
    if (!found->closed || has_doubtful_sides(found->hits)) PLUMBLINE_TRY(find_sides());
    report_.mesh->hits = hits_.size();
    return {};
  }

  /// Decides which way each shell faces.
  Status find_sides() {
    std::size_t& planned = report_.planned_bytes[static_cast<std::size_t>(Stage::kRayGrid)];
    planned =
        std::max(planned, arena_.used() + sides_bytes(survey_.triangles, files_.vertices_kept(survey_.most_vertices),
                                                      arena_.available()));
    const auto found = read_sides(files_, survey_, grid(), transform_, found_, arena_, {progress_, Stage::kRayGrid});
    PLUMBLINE_TRY(found);
    has_sides_ = *found;
    report_.mesh->closed = found_.closed;
    report_.mesh->turned = found_.turned;
    report_.mesh->dropped = found_.dropped;
    return {};
  }

  std::size_t& planned_for_rays() { return report_.planned_bytes[static_cast<std::size_t>(Stage::kRays)]; }
  /// Adds to the plan what rays need that are not closed.
  void plan_open_rays() {
    planned_for_rays() += resolve_bytes(settings_.threads, &field_) - resolve_bytes(settings_.threads, nullptr) +
                          lone_columns_bytes(grid());
  }

  /// Which tiles the mesh covers.
  void find_tiles() {
    const auto tile_of = [](float mm, float pitch, std::uint32_t tiles) {
      return std::min(static_cast<std::uint32_t>(std::max(0.0F, mm / pitch)) / kTileSide, tiles - 1);
    };
    field_.first_column = tile_of(box_.low[0], grid().pitch_x_mm, hits_.tile_columns());
    field_.end_column = tile_of(box_.high[0], grid().pitch_x_mm, hits_.tile_columns()) + 1;
    field_.first_row = tile_of(box_.low[1], grid().pitch_y_mm, hits_.tile_rows());
    field_.end_row = tile_of(box_.high[1], grid().pitch_y_mm, hits_.tile_rows()) + 1;
  }

  Status make_doubtful() {
    const auto words =
        arena_.take_top<std::uint64_t>(BitImage::words_needed(hits_.tile_columns(), hits_.tile_rows()), "mesh");
    PLUMBLINE_TRY(words);
    field_.doubtful = BitImage(*words, hits_.tile_columns(), hits_.tile_rows());
    field_.doubtful.clear();
    return {};
  }

  /// Makes a field of the rim alone.
  Status follow_rim() {
    field_.rim = {rim_, MeshLattice(grid(), transform_).step()};
    field_.cell = std::max(box_.size().maxCoeff() / kRimCells, grid().layer_height_mm);
    plan_open_rays();
    planned_for_rays() += Arena::rounded(rim_.size_bytes());
    PLUMBLINE_TRY(make_doubtful());
    if (settings_.base == BaseChoice::kFlat) {
      field_.base = box_.low[2];
    } else if (settings_.base == BaseChoice::kAuto) {
      PLUMBLINE_TRY(mirror_open_underside(field_, hits_, grid(), box_.low[2], arena_));
    }
    report_.flat_underside = field_.base.has_value();
    return {};
  }

  /// Reads the mesh into a tree of dipoles.
  Status build_field() {
    field_.winding = &winding_;
    plan_open_rays();
    const std::size_t reading = kReaderWorkspace + VertexList::bytes_needed(survey_.most_vertices);
    const std::uint32_t slots = MeshDipoles::slots_in(arena_.available() - std::min(arena_.available(), reading));
    planned_for_rays() = std::max(planned_for_rays() + MeshDipoles::field_bytes(slots),
                                  arena_.used() + reading + MeshDipoles::reading_bytes(slots));
    const double scale = report_.placement.scale;
    const auto dipoles = read_dipoles(
        files_, survey_.most_vertices,
        {transform_, box_, survey_.area * scale * scale, caps_, MeshLattice(grid(), transform_).step(), found_.sides},
        arena_, {progress_, Stage::kRays, kHolesClosed, kFieldRead});
    PLUMBLINE_TRY(dipoles);
    const auto nodes =
        arena_.take_top<WindingTree::Node>(WindingTree::nodes_needed(dipoles->cloud.size), "winding number");
    PLUMBLINE_TRY(nodes);
    winding_ = WindingTree::build(dipoles->cloud, *nodes);
    field_.cell = dipoles->cell;
    if (settings_.base != BaseChoice::kNone) {
      report_.flat_underside = winding_.set_base(box_.low[2], field_.cell, settings_.base == BaseChoice::kFlat);
    }
    return make_doubtful();
  }

  MeshFiles& files_;
  const MeshSurvey& survey_;
  const SliceSettings& settings_;
  Arena& arena_;
  ProgressSink* progress_;
  SliceReport& report_;
  MeshTransform transform_;
  Box3f box_;  ///< of the placed mesh, mm
  MeshHits found_;
  HitList& hits_ = found_.hits;
  std::span<const RimCorner> rim_;         ///< MeshRim; empty: no field, or one of all triangles
  std::span<const LatticeTriangle> caps_;  ///< for that one: of small holes, whose hits are among the others
  bool has_sides_ = false;                 ///< read_sides() has decided them
  bool doubled_ = false;                   ///< some hits were there twice
  WindingTree winding_;
  MeshField field_;
};

Expected<MeshHint> hint_of_files(MeshFiles& files, Arena& arena) {
  const BottomScope scope(arena);
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, "mesh");
  PLUMBLINE_TRY(workspace);
  return files.hint(*workspace);
}

/// @param most_vertices  of a file; none: unknown
Expected<MeshSurvey> survey_files(MeshFiles& files, const SliceSettings& settings,
                                  std::optional<std::uint64_t> most_vertices, Arena& arena, ProgressSink* progress,
                                  PreparationCounts& report) {
  const StageScope stage(Stage::kRead, arena, progress, report.peak_bytes);
  const auto found = read_survey(files, rotation_matrix(settings.placement.rotation_degrees), most_vertices, arena,
                                 {progress, Stage::kRead});
  PLUMBLINE_TRY(found);
  report.mesh = found->counts;
  report.scans = found->scans;
  report.scan = sum_of(found->scans);
  return found->survey;
}

tl::unexpected<Error> fail_empty(MeshFiles& files, const MeshCounts& counts) {
  const auto pointers = files.pointers();
  const auto title = title_of(std::span(pointers).first(files.count()));
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

}  // namespace

Expected<std::optional<MeshSurvey>> survey_mesh(MeshFiles& files, const SliceSettings& settings, Arena& arena,
                                                ProgressSink* progress, PreparationCounts& report) {
  if (settings.as == ReadAs::kPoints) return std::nullopt;
  const auto hint = hint_of_files(files, arena);
  PLUMBLINE_TRY(hint);
  const bool sure = settings.as == ReadAs::kMesh || *hint >= MeshHint::kPackedMesh;
  if (!sure && *hint == MeshHint::kNone) return std::nullopt;
  const auto pointers = files.pointers();
  PLUMBLINE_TRY(check_units(std::span(pointers).first(files.count()), settings.placement.units, files.some_in_mm(),
                            files.some_in_any_unit()));
  PLUMBLINE_TRY(files.keep_all(arena));
  const auto most_vertices = *hint == MeshHint::kTriangles ? std::optional<std::uint64_t>(0) : std::nullopt;
  const auto found = survey_files(files, settings, most_vertices, arena, progress, report);
  // What a mesh has no room for may fit as points, which are thinned. With any other error in its faces, a mesh must not become
  // points without a word.
  if (!found && (sure || found.error().code() != ErrorCode::kOutOfMemory)) return tl::unexpected<Error>(found.error());
  if (found && sure && found->triangles == 0) return fail_empty(files, *report.mesh);
  if (found && (sure || found->is_object())) return std::optional<MeshSurvey>(*found);
  report.mesh.reset();
  report.scans = {};
  report.scan = {};
  files.drop_copy(arena);
  PLUMBLINE_TRY(files.rewind());
  return std::nullopt;
}

Expected<Cloud> mesh_cloud(MeshFiles& files, const MeshSurvey& survey, Arena& arena, ProgressSink* progress,
                           PreparationCounts& report) {
  const StageScope stage(Stage::kNormals, arena, progress, report.peak_bytes);
  const double longest = survey.bounds.size().maxCoeff();
  if (longest > kLongestTurned) {
    return fail(ErrorCode::kDoesNotFit, "the mesh is %.3g units long.\tExport it again, or turn it", longest);
  }
  Box3f box;
  box.extend(Vec3f::Zero());
  box.extend(survey.bounds.size().cast<float>());
  const DipoleSurface surface{{Mat3d::Identity(), 1, -survey.bounds.low}, box, survey.area};
  const auto dipoles =
      read_dipoles(files, survey.most_vertices, surface, arena, {progress, Stage::kNormals, 0, kCloudRead});
  PLUMBLINE_TRY(dipoles);
  return dipoles->cloud;
}

Expected<MeshSurvey> prepare_mesh(MeshFiles& files, const MeshSurvey& survey, ScanSources sources,
                                  SliceSettings& settings, Arena& arena, ProgressSink* progress,
                                  PreparationCounts& report) {
  PLUMBLINE_TRY(check_units(sources, settings.placement.units, report));
  settings.placement = heed_header(settings.placement, report.scan.header);
  if (!settings.orient) return survey;
  {
    const ArenaScope scope(arena);
    const auto cloud = mesh_cloud(files, survey, arena, progress, report);
    PLUMBLINE_TRY(cloud);
    const auto best = best_way_up(*cloud, arena, {progress, Stage::kNormals, kCloudRead, 1});
    PLUMBLINE_TRY(best);
    report.turned = *best;
  }
  settings.placement.rotation_degrees = {report.turned->degrees[0], report.turned->degrees[1], 0};
  return survey_files(files, settings, survey.most_vertices, arena, progress, report);
}

Expected<CrossingStore> shoot_mesh(MeshFiles& files, const MeshSurvey& survey, const SliceSettings& settings,
                                   Arena& arena, ProgressSink* progress, SliceReport& report) {
  return MeshStages(files, survey, settings, arena, progress, report).run();
}

}  // namespace plumbline
