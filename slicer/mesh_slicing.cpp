#include "slicer/mesh_slicing.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/core/stage_scope.hpp"
#include "slicer/mesh/edge_sum.hpp"
#include "slicer/mesh/hit_resolver.hpp"
#include "slicer/mesh/mesh_dipoles.hpp"
#include "slicer/plan/mesh_plan.hpp"
#include "slicer/reader/scan_reader.hpp"

namespace plumbline {
namespace {

/// Bytes: the shortest vertex of a file, three numbers of one byte each.
constexpr std::uint64_t kShortestVertex = 3;
/// Cells between the sections that are compared with the one at the base plane.
constexpr float kSectionCells = 2;

constexpr const char* kStage = "mesh";

/// A sink that reports its progress as a part of a stage.
class StagedSink : public TriangleSink {
 public:
  StagedSink(const MeshFiles& files, const StageProgress& progress) : files_(files), progress_(progress) {}
  bool progress(double fraction) override { return progress_.advance(files_.progress(fraction)); }

 private:
  const MeshFiles& files_;
  StageProgress progress_;
};

class SurveySink final : public StagedSink {
 public:
  SurveySink(const MeshFiles& files, const StageProgress& progress, const Mat3d& rotation)
      : StagedSink(files, progress), surveyor(rotation) {}
  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& triangle : triangles) surveyor.add(triangle);
    return {};
  }

  Surveyor surveyor;
};

class HitSink final : public StagedSink {
 public:
  HitSink(const MeshFiles& files, const StageProgress& progress, const PrintGrid& grid, const MeshLattice& lattice,
          HitList& hits)
      : StagedSink(files, progress), grid_(grid), lattice_(lattice), hits_(hits) {}

  Status take(std::span<const Triangle> triangles) override {
    bool full = false;
    for (const Triangle& triangle : triangles) {
      const LatticeTriangle t = {lattice_(triangle[0]), lattice_(triangle[1]), lattice_(triangle[2])};
      flat_ += t[0] == t[1] || t[1] == t[2] || t[2] == t[0] ? 1 : 0;
      edges_.add(t);
      for_each_hit(t, grid_, [&](const RayHit& hit) { full |= !hits_.add(hit); });
    }
    if (!full) return {};
    return fail(ErrorCode::kOutOfMemory,
                "mesh: its rays have more crossings than the %zu that the arena has room for.\tUse a larger arena "
                "(--arena-mib), a coarser grid or a smaller --scale",
                hits_.capacity());
  }
  bool is_closed() const { return edges_.is_closed(); }
  std::uint64_t flat() const { return flat_; }

 private:
  const PrintGrid& grid_;
  const MeshLattice& lattice_;
  HitList& hits_;
  EdgeSum edges_;
  std::uint64_t flat_ = 0;
};

class DipoleSink final : public StagedSink {
 public:
  DipoleSink(const MeshFiles& files, const StageProgress& progress, const MeshLattice& lattice, MeshDipoles& dipoles)
      : StagedSink(files, progress), lattice_(lattice), dipoles_(dipoles) {}

  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) {
      if (!dipoles_.add(lattice_.to_print(t[0]), lattice_.to_print(t[1]), lattice_.to_print(t[2]))) {
        full_ = true;
        return fail(ErrorCode::kOutOfMemory, "winding number: more cells than there is room for");
      }
    }
    return {};
  }
  bool full() const { return full_; }

 private:
  const MeshLattice& lattice_;
  MeshDipoles& dipoles_;
  bool full_ = false;
};

ScanSummary as_scan(const MeshSummary& mesh) {
  ScanSummary scan;
  scan.header.format = mesh.format;
  scan.header.encoding = mesh.encoding;
  scan.points = mesh.vertices;
  scan.bytes = mesh.bytes;
  return scan;
}

void add(MeshCounts& counts, const MeshSummary& mesh) {
  counts.faces += mesh.faces;
  counts.triangles += mesh.triangles;
  counts.not_finite += mesh.not_finite;
  counts.vertices += mesh.vertices;
}

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
        lattice_(grid(), report.placement.rotation, report.placement.scale, report.placement.shift) {
    for (const Vec3d& corner : {survey.bounds.low, survey.bounds.high}) {
      box_.extend(Vec3d(corner * report.placement.scale + report.placement.shift).cast<float>());
    }
  }

  Expected<CrossingStore> run() {
    PLUMBLINE_TRY(
        admit_mesh(need_of(*report_.mesh, report_.placement), settings_.threads, arena_, report_.planned_bytes));
    constexpr auto kReading = static_cast<std::size_t>(Stage::kRead);
    report_.planned_bytes[kReading] = report_.peak_bytes[kReading];  // it has been read, with room for more vertices
    PLUMBLINE_TRY(find_hits());
    const StageScope stage(Stage::kRays, arena_, progress_, report_.peak_bytes);
    const bool whole = report_.mesh->closed;
    if (!whole) PLUMBLINE_TRY(build_field());
    auto store = resolve_hits(*hits_, grid(), whole ? nullptr : &field_, settings_.threads, arena_,
                              {progress_, Stage::kRays, whole ? 0 : kFieldBuilt, 1}, *report_.mesh);
    arena_.reset_peak();  // the open store took the rest of the arena; the stage's need is what is used now
    return store;
  }

 private:
  static constexpr double kRead = 0.4;        ///< of the rays' time, if the winding number is needed
  static constexpr double kFieldBuilt = 0.7;

  const PrintGrid& grid() const { return report_.placement.grid; }

  Status find_hits() {
    const StageScope stage(Stage::kRayGrid, arena_, progress_, report_.peak_bytes);
    const std::size_t bottom = arena_.bottom_mark();
    const auto workspace = arena_.take_bottom<std::byte>(kReaderWorkspace, kStage);
    PLUMBLINE_TRY(workspace);
    auto vertices = VertexList::create(survey_.most_vertices, arena_);
    PLUMBLINE_TRY(vertices);
    auto hits = HitList::create(grid(), arena_);
    PLUMBLINE_TRY(hits);
    hits_ = *hits;
    HitSink sink(files_, {progress_, Stage::kRayGrid}, grid(), lattice_, *hits_);
    std::uint64_t triangles = 0;
    const auto each = [&](const MeshSummary& mesh) { triangles += mesh.triangles; };
    PLUMBLINE_TRY(files_.read(sink, *vertices, *workspace, each));
    if (triangles != survey_.triangles) return fail_changed();
    PLUMBLINE_TRY(hits_->close(arena_));
    arena_.release_bottom(bottom);
    arena_.reset_peak();  // the open list took the rest of the arena
    report_.mesh->closed = sink.is_closed();
    report_.mesh->flat = sink.flat();
    report_.mesh->hits = hits_->size();
    return {};
  }

  static tl::unexpected<Error> fail_changed() {
    return fail(ErrorCode::kCannotRead,
                "the mesh has changed while it was read, or its medium delivers other bytes each time.\tTry again, or "
                "use another stick");
  }

  /// Reads the mesh into a tree of dipoles, and finds the tiles where it contradicts the hits.
  Status build_field() {
    Expected<Cloud> cloud = tl::unexpected<Error>(Error());
    {
      const std::size_t bottom = arena_.bottom_mark();
      const auto workspace = arena_.take_bottom<std::byte>(kReaderWorkspace, kStage);
      PLUMBLINE_TRY(workspace);
      auto vertices = VertexList::create(survey_.most_vertices, arena_);
      PLUMBLINE_TRY(vertices);
      const double scale = report_.placement.scale;
      auto dipoles = MeshDipoles::create(box_, survey_.area * scale * scale, arena_);
      PLUMBLINE_TRY(dipoles);
      for (;;) {
        DipoleSink sink(files_, {progress_, Stage::kRays, 0, kRead}, lattice_, *dipoles);
        const Status read = files_.read(sink, *vertices, *workspace, [](const MeshSummary&) {});
        if (read) break;
        if (!sink.full()) return read;
        dipoles->double_cells();
      }
      cloud = dipoles->to_cloud(arena_);
      PLUMBLINE_TRY(cloud);
      field_.cell = dipoles->cell();
      arena_.release_bottom(bottom);
    }
    const auto nodes = arena_.take_top<WindingTree::Node>(WindingTree::nodes_needed(cloud->size), kStage);
    PLUMBLINE_TRY(nodes);
    winding_ = WindingTree::build(*cloud, *nodes);
    if (settings_.base != BaseChoice::kNone) {
      report_.flat_underside =
          winding_.set_base(box_.low[2], kSectionCells * field_.cell, settings_.base == BaseChoice::kFlat);
    }
    field_.winding = &winding_;
    const auto words =
        arena_.take_top<std::uint64_t>(BitImage::words_needed(hits_->tile_columns(), hits_->tile_rows()), kStage);
    PLUMBLINE_TRY(words);
    field_.doubtful = BitImage(*words, hits_->tile_columns(), hits_->tile_rows());
    field_.doubtful.clear();
    const auto tile_of = [](float mm, float pitch, std::uint32_t most) {
      return std::min(static_cast<std::uint32_t>(std::max(0.0F, mm / pitch)) / kTileSide, most - 1);
    };
    field_.first_column = tile_of(box_.low[0], grid().pitch_x_mm, hits_->tile_columns());
    field_.end_column = tile_of(box_.high[0], grid().pitch_x_mm, hits_->tile_columns()) + 1;
    field_.first_row = tile_of(box_.low[1], grid().pitch_y_mm, hits_->tile_rows());
    field_.end_row = tile_of(box_.high[1], grid().pitch_y_mm, hits_->tile_rows()) + 1;
    if (!find_doubtful(field_, *hits_, grid(), {progress_, Stage::kRays, kRead, kFieldBuilt})) {
      return fail(ErrorCode::kCancelled, "cancelled while the mesh was sliced");
    }
    return {};
  }

  MeshFiles& files_;
  const MeshSurvey& survey_;
  const SliceSettings& settings_;
  Arena& arena_;
  ProgressSink* progress_;
  SliceReport& report_;
  MeshLattice lattice_;
  Box3f box_;  ///< of the placed mesh, mm
  std::optional<HitList> hits_;
  WindingTree winding_;
  MeshField field_;
};

/// Reads all files once.
Expected<MeshSurvey> survey(MeshFiles& files, const SliceSettings& settings, Arena& arena, ProgressSink* progress,
                            PreparationCounts& report) {
  const StageScope stage(Stage::kRead, arena, progress, report.peak_bytes);
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  const std::uint64_t most = VertexList::most_in(arena.available());
  auto vertices = VertexList::create(std::min(most, files.largest().value_or(most) / kShortestVertex + 1), arena);
  PLUMBLINE_TRY(vertices);
  SurveySink sink(files, {progress, Stage::kRead}, rotation_matrix(settings.placement.rotation_degrees));
  report.scans = {};
  report.mesh.emplace();
  const auto each = [&](const MeshSummary& mesh) {
    sink.surveyor.end_file(mesh);
    report.scans.add(as_scan(mesh));
    add(*report.mesh, mesh);
  };
  PLUMBLINE_TRY(files.read(sink, *vertices, *workspace, each));
  report.scan = sum_of(report.scans);
  report.mesh->most_vertices = sink.surveyor.survey().most_vertices;
  report.mesh->seen_area = sink.surveyor.survey().seen_area;
  return sink.surveyor.survey();
}

Expected<MeshHint> hint_of_files(MeshFiles& files, Arena& arena) {
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  return files.hint(*workspace);
}

tl::unexpected<Error> fail_empty(MeshFiles& files, const MeshCounts& counts) {
  const auto pointers = files.pointers();
  return fail(ErrorCode::kNoPoints,
              "%s: has no usable triangle: %llu were left out because of a coordinate that is not finite or huge.\tExport "
              "it again",
              title_of(std::span(pointers).first(files.count())).c_str(),
              static_cast<unsigned long long>(counts.not_finite));
}

}  // namespace

Expected<std::optional<MeshSurvey>> survey_mesh(MeshFiles& files, const SliceSettings& settings, Arena& arena,
                                                ProgressSink* progress, PreparationCounts& report) {
  if (settings.as == ReadAs::kPoints) return std::nullopt;
  const std::size_t bottom = arena.bottom_mark();
  const auto hint = hint_of_files(files, arena);
  arena.release_bottom(bottom);
  PLUMBLINE_TRY(hint);
  const bool sure = settings.as == ReadAs::kMesh || *hint == MeshHint::kMesh;
  if (!sure && *hint == MeshHint::kNone) return std::nullopt;
  PLUMBLINE_TRY(files.keep_all(arena));
  const auto found = survey(files, settings, arena, progress, report);
  arena.release_bottom(bottom);
  if (!found) {
    const ErrorCode code = found.error().code();
    if (sure || code == ErrorCode::kCannotRead || code == ErrorCode::kCancelled) {
      return tl::unexpected<Error>(found.error());
    }
  }
  if (found && sure && found->triangles == 0) return fail_empty(files, *report.mesh);
  if (found && (sure || found->is_object())) return std::optional<MeshSurvey>(*found);
  // What is wrong with its points or faces is for the reader of scans to find.
  report.mesh.reset();
  report.scans = {};
  report.scan = {};
  PLUMBLINE_TRY(files.rewind());
  return std::nullopt;
}

Expected<CrossingStore> shoot_mesh(MeshFiles& files, const MeshSurvey& survey, const SliceSettings& settings,
                                   Arena& arena, ProgressSink* progress, SliceReport& report) {
  return MeshStages(files, survey, settings, arena, progress, report).run();
}

}  // namespace plumbline
