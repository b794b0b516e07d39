#include "slicer/mesh/mesh_reading.hpp"

#include <algorithm>

#include "slicer/mesh/edge_sum.hpp"
#include "slicer/mesh/mesh_dipoles.hpp"
#include "slicer/mesh/open_edges.hpp"
#include "slicer/mesh/small_holes.hpp"
#include "slicer/reader/scan_reader.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "mesh";
/// Bytes: the shortest vertex of a file, three numbers of one byte each.
constexpr std::uint64_t kShortestVertex = 3;

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

LatticeTriangle on_lattice(const MeshLattice& lattice, const Triangle& t) {
  return {lattice(t[0]), lattice(t[1]), lattice(t[2])};
}

tl::unexpected<Error> fail_full(const HitList& hits) {
  return fail(ErrorCode::kOutOfMemory,
              "mesh: its rays have more crossings than the %zu that the arena has room for.\tUse a larger arena "
              "(--arena-mib), a coarser grid or a smaller --scale",
              hits.capacity());
}

class HitSink final : public StagedSink {
 public:
  HitSink(const MeshFiles& files, const StageProgress& progress, const PrintGrid& grid, const MeshTransform& transform,
          HitList& hits)
      : StagedSink(files, progress), grid_(grid), lattice_(grid, transform), hits_(hits) {}

  Status take(std::span<const Triangle> triangles) override {
    bool full = false;
    for (const Triangle& triangle : triangles) {
      const LatticeTriangle t = on_lattice(lattice_, triangle);
      flat_ += t[0] == t[1] || t[1] == t[2] || t[2] == t[0] ? 1 : 0;
      edges_.add(t);
      for_each_hit(t, grid_, [&](const RayHit& hit) { full |= !hits_.add(hit); });
    }
    if (full) return fail_full(hits_);
    return {};
  }
  const EdgeSum& edges() const { return edges_; }
  std::uint64_t flat() const { return flat_; }

 private:
  const PrintGrid& grid_;
  MeshLattice lattice_;
  HitList& hits_;
  EdgeSum edges_;
  std::uint64_t flat_ = 0;
};

/// Finds the open edges of a mesh, then their users.
class EdgeSink final : public StagedSink {
 public:
  EdgeSink(const MeshFiles& files, const StageProgress& progress, const MeshLattice& lattice, OpenEdges& edges,
           bool users)
      : StagedSink(files, progress), lattice_(lattice), edges_(edges), users_(users) {}

  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& triangle : triangles) {
      const LatticeTriangle t = on_lattice(lattice_, triangle);
      if (users_) {
        edges_.add_user(t, number_++, lattice_.step());
        continue;
      }
      PLUMBLINE_TRY(edges_.add(t));
    }
    return {};
  }

 private:
  const MeshLattice& lattice_;
  OpenEdges& edges_;
  bool users_;
  std::uint64_t number_ = 0;
};

class DipoleSink final : public StagedSink {
 public:
  DipoleSink(const MeshFiles& files, const StageProgress& progress, const MeshTransform& transform,
             MeshDipoles& dipoles)
      : StagedSink(files, progress), transform_(transform), dipoles_(dipoles) {}

  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) {
      if (dipoles_.add(transform_(t[0]), transform_(t[1]), transform_(t[2]))) continue;
      full_ = true;
      return fail(ErrorCode::kOutOfMemory, "mesh: more cells than there is room for");
    }
    return {};
  }
  bool full() const { return full_; }

 private:
  const MeshTransform& transform_;
  MeshDipoles& dipoles_;
  bool full_ = false;
};

/// @returns false if there are more cells than room
bool add_caps(const DipoleSurface& surface, MeshDipoles& dipoles) {
  const auto mm = [&](const LatticePoint& p) {
    return Vec3d(surface.step[0] * p.x, surface.step[1] * p.y, surface.step[2] * p.z);
  };
  return std::ranges::all_of(surface.caps,
                             [&](const LatticeTriangle& t) { return dipoles.add(mm(t[0]), mm(t[1]), mm(t[2])); });
}

ScanSummary as_scan(const MeshSummary& mesh) {
  ScanSummary scan;
  scan.header.format = mesh.format;
  scan.header.encoding = mesh.encoding;
  scan.header.is_in_mm = mesh.is_in_mm;
  scan.points = mesh.vertices;
  scan.bytes = mesh.bytes;
  return scan;
}

Expected<SurveyedMesh> survey(MeshFiles& files, const Mat3d& rotation, std::optional<std::uint64_t> most_vertices,
                              Arena& arena, const StageProgress& progress, ModelCopy& copy) {
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  const std::uint64_t room = VertexList::most_in(arena.available());
  const auto largest = files.largest();
  const std::uint64_t most =
      files.vertices_kept(most_vertices.value_or(largest ? *largest / kShortestVertex + 1 : room));
  auto vertices = VertexList::create(std::min(room, most), arena);
  PLUMBLINE_TRY(vertices);
  if (files.wants_copy()) copy = ModelCopy(vertices->room());
  SurveySink sink(files, progress, rotation);
  SurveyedMesh found;
  const auto each = [&](const MeshSummary& mesh) {
    sink.surveyor.end_file(mesh);
    found.scans.add(as_scan(mesh));
    found.counts.faces += mesh.faces;
    found.counts.triangles += mesh.triangles;
    found.counts.not_finite += mesh.not_finite;
    found.counts.vertices += mesh.vertices;
  };
  PLUMBLINE_TRY(files.read(sink, *vertices, *workspace, each, copy));
  found.survey = sink.surveyor.survey();
  found.counts.most_vertices = found.survey.most_vertices;
  found.counts.seen_area = found.survey.seen_area;
  return found;
}

Expected<MeshHits> hit(MeshFiles& files, const MeshSurvey& survey, const PrintGrid& grid,
                       const MeshTransform& transform, Arena& arena, const StageProgress& progress) {
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(files.vertices_kept(survey.most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  auto hits = HitList::create(grid, arena);
  PLUMBLINE_TRY(hits);
  HitSink sink(files, progress, grid, transform, *hits);
  std::uint64_t triangles = 0;
  PLUMBLINE_TRY(files.read(sink, *vertices, *workspace, [&](const MeshSummary& mesh) { triangles += mesh.triangles; }));
  if (triangles != survey.triangles) {
    return telling(
        Told(ToldCode::kMeshChanged),
        fail(ErrorCode::kCannotRead,
             "the mesh has changed while it was read, or its medium delivers other bytes each time.\tTry again, or "
             "use another stick"));
  }
  PLUMBLINE_TRY(hits->close(arena));
  arena.reset_peak();  // the open list took the rest of the arena
  return MeshHits{*hits, sink.edges().is_closed(), sink.edges().is_paired(), sink.flat()};
}

Expected<ClosedHoles> find_and_close_holes(MeshFiles& files, const MeshSurvey& survey, const PrintGrid& grid,
                                           const MeshTransform& transform, HitList& hits, Arena& arena,
                                           const StageProgress& progress) {
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(files.vertices_kept(survey.most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  auto edges = OpenEdges::create(arena);
  PLUMBLINE_TRY(edges);
  const MeshLattice lattice(grid, transform);
  for (const bool users : {false, true}) {
    if (users) PLUMBLINE_TRY(edges->begin_users());
    const StageProgress half = users ? progress.part(0.5, 1) : progress.part(0, 0.5);
    EdgeSink sink(files, half, lattice, *edges, users);
    PLUMBLINE_TRY(files.read(sink, *vertices, *workspace, [](const MeshSummary&) {}));
    if (edges->full()) return ClosedHoles{};
  }
  const bool whole = edges->runs() <= survey.triangles / 2;
  if ((!whole && edges->runs() > kMostRim) || small_hole_bytes(edges->runs()) > arena.available()) return ClosedHoles{};
  const auto found = close_small_holes(*edges, lattice.step(), whole ? kMostCorners : 0, arena);
  PLUMBLINE_TRY(found);
  PLUMBLINE_TRY(hits.reopen(arena));
  bool full = false;
  for (const LatticeTriangle& cap : found->caps) {
    for_each_hit(cap, grid, [&](const RayHit& hit) { full |= !hits.add(hit); });
  }
  if (full) return fail_full(hits);
  PLUMBLINE_TRY(hits.close(arena));
  arena.reset_peak();  // the open list took the rest of the arena
  ClosedHoles closed{found->holes, found->rim.empty(), {}, {}};
  if (found->rim.size() <= kMostRim) {
    const auto rim = arena.take_top<RimCorner>(found->rim.size(), kStage);
    PLUMBLINE_TRY(rim);
    std::ranges::copy(found->rim, rim->begin());
    closed.rim = *rim;
  } else {
    const auto caps = arena.take_top<LatticeTriangle>(found->caps.size(), kStage);
    PLUMBLINE_TRY(caps);
    std::ranges::copy(found->caps, caps->begin());
    closed.caps = *caps;
  }
  return closed;
}

Expected<ReadDipoles> add_up(MeshFiles& files, std::uint64_t most_vertices, const DipoleSurface& surface, Arena& arena,
                             const StageProgress& progress) {
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(files.vertices_kept(most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  auto dipoles = MeshDipoles::create(surface.box, surface.area, arena);
  PLUMBLINE_TRY(dipoles);
  for (;;) {
    DipoleSink sink(files, progress, surface.transform, *dipoles);
    const Status read = files.read(sink, *vertices, *workspace, [](const MeshSummary&) {});
    if (!read && !sink.full()) return tl::unexpected<Error>(read.error());
    if (read && add_caps(surface, *dipoles)) break;
    dipoles->double_cells();
  }
  const auto cloud = dipoles->to_cloud(arena);
  PLUMBLINE_TRY(cloud);
  return ReadDipoles{*cloud, dipoles->cell()};
}

}  // namespace

Expected<SurveyedMesh> read_survey(MeshFiles& files, const Mat3d& rotation, std::optional<std::uint64_t> most_vertices,
                                   Arena& arena, const StageProgress& progress) {
  const std::size_t bottom = arena.bottom_mark();
  ModelCopy copy({});
  auto found = survey(files, rotation, most_vertices, arena, progress, copy);
  arena.release_bottom(bottom);
  if (found && copy.is_finished()) PLUMBLINE_TRY(files.keep(copy, arena));
  return found;
}

Expected<MeshHits> read_hits(MeshFiles& files, const MeshSurvey& survey, const PrintGrid& grid,
                             const MeshTransform& transform, Arena& arena, const StageProgress& progress) {
  const std::size_t bottom = arena.bottom_mark();
  const auto found = hit(files, survey, grid, transform, arena, progress);
  arena.release_bottom(bottom);
  return found;
}

Expected<ClosedHoles> close_holes(MeshFiles& files, const MeshSurvey& survey, const PrintGrid& grid,
                                  const MeshTransform& transform, HitList& hits, Arena& arena,
                                  const StageProgress& progress) {
  const std::size_t bottom = arena.bottom_mark();
  const auto found = find_and_close_holes(files, survey, grid, transform, hits, arena, progress);
  arena.release_bottom(bottom);
  return found;
}

Expected<ReadDipoles> read_dipoles(MeshFiles& files, std::uint64_t most_vertices, const DipoleSurface& surface,
                                   Arena& arena, const StageProgress& progress) {
  const std::size_t bottom = arena.bottom_mark();
  const auto found = add_up(files, most_vertices, surface, arena, progress);
  arena.release_bottom(bottom);
  return found;
}

}  // namespace plumbline
