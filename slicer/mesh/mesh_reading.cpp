#include "slicer/mesh/mesh_reading.hpp"

#include <algorithm>

#include "slicer/mesh/edge_sum.hpp"
#include "slicer/mesh/mesh_dipoles.hpp"
#include "slicer/mesh/negative_cut.hpp"
#include "slicer/mesh/open/open_edges.hpp"
#include "slicer/mesh/open/small_holes.hpp"
#include "slicer/reader/scan_reader.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "mesh";
/// Bytes: the shortest vertex of a file, three numbers of one byte each.
constexpr std::uint64_t kShortestVertex = 3;
/// Readings to join triangles, at most: each takes as many edges as there is room for.
constexpr std::uint64_t kMostParts = 16;
/// Bytes for edges below which nothing is tried.
constexpr std::size_t kLeastUseRoom = std::size_t{1} << 16U;
/// Three uses of edges, or half a shell and what goes with it.
constexpr std::size_t kSidesBytesPerTriangle = std::max(3 * sizeof(EdgeUse), sizeof(Shell) / 2 + 4);

/// A sink that reports its progress as a part of a stage.
class StagedSink : public TriangleSink {
 public:
  StagedSink(const MeshFiles& files, const StageProgress& progress) : files_(files), progress_(progress) {}
  bool progress(double fraction) override { return progress_.advance(files_.progress(fraction)); }
  void begin_body(BodyLabel body) override { body_ = body; }

 protected:
  BodyLabel body_;  ///< of the triangles that come

 private:
  const MeshFiles& files_;
  StageProgress progress_;
};

class SurveySink final : public StagedSink {
 public:
  SurveySink(const MeshFiles& files, const StageProgress& progress, const Mat3d& rotation)
      : StagedSink(files, progress), surveyor(rotation) {}
  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& triangle : triangles) surveyor.add(triangle, body_.is_negative());
    return {};
  }

  Surveyor surveyor;
};

/// Triangles that have been joined, and their shells.
struct JoinedShells {
  ShellJoiner joiner;
  std::span<Shell> shells;
};

LatticeTriangle on_lattice(const MeshLattice& lattice, const Triangle& t) {
  return {lattice(t[0]), lattice(t[1]), lattice(t[2])};
}

tl::unexpected<Error> fail_full(const HitList& hits) {
  return fail(ErrorCode::kOutOfMemory,
              "mesh: its rays have more crossings than the %zu that the arena has room for.\tUse a larger arena, "
              "a coarser grid or a smaller scale",
              hits.capacity());
}

class HitSink final : public StagedSink {
 public:
  /// @param joined  whose sides the triangles get; null: they stay as they are
  HitSink(const PlacedMesh& mesh, const StageProgress& progress, HitList& hits, JoinedShells* joined)
      : StagedSink(mesh.files, progress), grid_(mesh.grid), lattice_(mesh.lattice()), hits_(hits), joined_(joined) {}

  Status take(std::span<const Triangle> triangles) override {
    bool full = false;
    for (const Triangle& triangle : triangles) {
      LatticeTriangle t = on_lattice(lattice_, triangle);
      flat_ += t[0] == t[1] || t[1] == t[2] || t[2] == t[0] ? 1 : 0;
      if (joined_ == nullptr) {
        if (!body_.is_negative()) edges_.add(t);
        shoot(triangle, t, [&](const RayHit& hit) { full |= !hits_.add(hit, body_.number()); });
        continue;
      }
      const ShellJoiner::Side side = joined_->joiner.of(number_++);
      if (side.dropped) continue;
      Triangle turned = triangle;
      if (side.turned) std::swap(t[1], t[2]);
      if (side.turned) std::swap(turned[1], turned[2]);
      Shell& shell = joined_->shells[side.shell];
      shell.body = body_.number();
      if (!body_.is_negative()) shell.edges.add(t);
      const int vote = side.even ? 0 : side.turned ? -1 : 1;
      shoot(turned, t, [&](const RayHit& hit) {
        full |= !hits_.add(hit, side.shell);
        shell.votes += vote;
        ++shell.hits;
      });
    }
    if (full) return fail_full(hits_);
    return {};
  }
  const EdgeSum& edges() const { return edges_; }
  std::uint64_t flat() const { return flat_; }

 private:
  /// @param rounded  the same triangle; of a negative volume, which may reach beyond the grid, it is not used
  template <class Visit>
  void shoot(const Triangle& triangle, const LatticeTriangle& rounded, Visit visit) {
    if (!body_.is_negative()) return for_each_hit(rounded, grid_, visit);
    GridClipper(lattice_.last())
        .clip({lattice_.steps_of(triangle[0]), lattice_.steps_of(triangle[1]), lattice_.steps_of(triangle[2])},
              [&](const LatticeTriangle& part) { for_each_hit(part, grid_, visit); });
  }

  const PrintGrid& grid_;
  MeshLattice lattice_;
  HitList& hits_;
  JoinedShells* joined_;
  EdgeSum edges_;
  std::uint64_t flat_ = 0;
  std::size_t number_ = 0;  ///< of the next triangle
};

/// Collects the sides of triangles along some of the edges.
class UseSink final : public StagedSink {
 public:
  /// @param part, parts  which edges
  UseSink(const MeshFiles& files, const StageProgress& progress, const MeshLattice& lattice, std::span<EdgeUse> room,
          std::uint64_t part, std::uint64_t parts)
      : StagedSink(files, progress), lattice_(lattice), room_(room), part_(part), parts_(parts) {}

  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& triangle : triangles) {
      ShellJoiner::for_each_use(on_lattice(lattice_, triangle), number_++, body_.number(), [&](const EdgeUse& use) {
        if ((use.edge >> 32U) * parts_ >> 32U != part_) return;
        if (count_ < room_.size()) room_[count_] = use;
        ++count_;
      });
    }
    return {};
  }
  bool full() const { return count_ > room_.size(); }
  std::span<EdgeUse> uses() const { return room_.first(count_); }

 private:
  const MeshLattice& lattice_;
  std::span<EdgeUse> room_;
  std::uint64_t part_, parts_;
  std::size_t count_ = 0;
  std::uint32_t number_ = 0;
};

/// Finds the open edges of a mesh, then their users.
class EdgeSink final : public StagedSink {
 public:
  EdgeSink(const MeshFiles& files, const StageProgress& progress, const MeshLattice& lattice,
           const TriangleSides& sides, OpenEdges& edges, bool users)
      : StagedSink(files, progress), lattice_(lattice), sides_(sides), edges_(edges), users_(users) {}

  Status take(std::span<const Triangle> triangles) override {
    for (const Triangle& triangle : triangles) {
      LatticeTriangle t = on_lattice(lattice_, triangle);
      const std::uint64_t number = number_++;
      if (!sides_.apply(static_cast<std::size_t>(number), t) || body_.is_negative()) continue;
      if (users_) {
        edges_.add_user(t, number, lattice_.step());
        continue;
      }
      PLUMBLINE_TRY(edges_.add(t));
    }
    return {};
  }

 private:
  const MeshLattice& lattice_;
  const TriangleSides& sides_;
  OpenEdges& edges_;
  bool users_;
  std::uint64_t number_ = 0;
};

/// Adds up how corners move. Negative volumes stay where they are.
class ShiftSink final : public StagedSink {
 public:
  ShiftSink(const PlacedMesh& mesh, const StageProgress& progress, const TriangleSides& sides, OutlineShift& shift)
      : StagedSink(mesh.files, progress),
        transform_(mesh.transform),
        lattice_(mesh.grid, mesh.transform),
        sides_(sides),
        shift_(shift) {}

  Status take(std::span<const Triangle> triangles) override {
    for (Triangle t : triangles) {
      if (!sides_.apply(number_++, t) || body_.is_negative()) continue;
      if (shift_.add(on_lattice(lattice_, t), {transform_(t[0]), transform_(t[1]), transform_(t[2])})) continue;
      return fail(ErrorCode::kBadSetting,
                  "the outlines of the mesh can't be moved: a corner moves with all triangles that meet there, and "
                  "hardly any share one.\tMerge its vertices in a mesh editor, or leave out the absolute correction");
    }
    return {};
  }

 private:
  const MeshTransform& transform_;
  MeshLattice lattice_;
  const TriangleSides& sides_;
  OutlineShift& shift_;
  std::size_t number_ = 0;
};

class DipoleSink final : public StagedSink {
 public:
  DipoleSink(const MeshFiles& files, const StageProgress& progress, const DipoleSurface& surface, MeshDipoles& dipoles)
      : StagedSink(files, progress), transform_(surface.transform), sides_(surface.sides), dipoles_(dipoles) {}

  Status take(std::span<const Triangle> triangles) override {
    for (Triangle t : triangles) {
      if (!sides_.apply(number_++, t) || body_.is_negative()) continue;
      if (dipoles_.add(transform_(t[0]), transform_(t[1]), transform_(t[2]))) continue;
      full_ = true;
      return fail(ErrorCode::kOutOfMemory, "mesh: more cells than there is room for");
    }
    return {};
  }
  bool full() const { return full_; }

 private:
  const MeshTransform& transform_;
  const TriangleSides& sides_;
  MeshDipoles& dipoles_;
  bool full_ = false;
  std::size_t number_ = 0;
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
  const BottomScope scope(arena);
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
    found.counts.project.add(mesh.project);
  };
  PLUMBLINE_TRY(files.read(sink, *vertices, *workspace, each, copy));
  found.survey = sink.surveyor.survey();
  found.counts.most_vertices = found.survey.most_vertices;
  // A negative volume may be far larger than what it is cut out of.
  const Vec3d size = found.survey.bounds.size();
  const double most_cut = 2 * double{1} * found.counts.project.negative * size[0] * size[1];
  found.counts.seen_area = found.survey.seen_area + std::min(found.survey.cut_area, most_cut);
  return found;
}

/// @param joined  see HitSink
Expected<MeshHits> hit(const PlacedMesh& mesh, JoinedShells* joined, Arena& arena, const StageProgress& progress) {
  const BottomScope scope(arena);
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(mesh.files.vertices_kept(mesh.survey.most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  auto hits = HitList::create(mesh.grid, arena, joined != nullptr);
  PLUMBLINE_TRY(hits);
  HitSink sink(mesh, progress, *hits, joined);
  std::uint64_t triangles = 0;
  const auto each = [&](const MeshSummary& file) { triangles += file.triangles; };
  PLUMBLINE_TRY(mesh.files.read(sink, *vertices, *workspace, each));
  if (triangles != mesh.survey.triangles) {
    return telling(
        Told(ToldCode::kMeshChanged),
        fail(ErrorCode::kCannotRead,
             "the mesh has changed while it was read, or its medium delivers other bytes each time.\tTry again, or "
             "use another stick"));
  }
  PLUMBLINE_TRY(hits->close(arena));
  arena.reset_peak();  // the open list took the rest of the arena
  return MeshHits{.hits = *hits, .closed = sink.edges().is_closed(), .flat = sink.flat()};
}

/// Bytes that stay while a file is read again.
std::size_t bytes_to_read(std::uint64_t vertices) { return kReaderWorkspace + VertexList::bytes_needed(vertices); }

/// How many uses of edges fit into what reading leaves: all of them if possible.
std::size_t use_room(std::uint64_t triangles, std::size_t available) {
  return std::min(static_cast<std::size_t>(3 * triangles), available / sizeof(EdgeUse));
}

/// Joins all triangles.
/// @returns false: there is no room
Expected<bool> join(const PlacedMesh& mesh, ShellJoiner& joiner, Arena& arena, const StageProgress& progress) {
  const MeshLattice lattice = mesh.lattice();
  const BottomScope scope(arena);
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(mesh.files.vertices_kept(mesh.survey.most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  const std::size_t capacity =
      use_room(mesh.survey.triangles, arena.available() - std::min(arena.available(), Arena::kAlignment));
  const auto room = arena.take_bottom<EdgeUse>(capacity, kStage);
  PLUMBLINE_TRY(room);
  // The parts are about equal, for edges are numbered at random.
  const std::uint64_t uses = 3 * mesh.survey.triangles;
  const std::uint64_t parts = capacity >= uses ? 1 : uses * 17 / 16 / std::max<std::size_t>(capacity, 1) + 1;
  if (parts > kMostParts) return false;
  for (const bool others : {false, true}) {
    if (others && !joiner.has_others()) break;
    for (std::uint64_t part = 0; part < parts; ++part) {
      const double done = others ? 1 : static_cast<double>(part) / static_cast<double>(parts);
      UseSink sink(mesh.files, progress.part(done, done), lattice, *room, part, parts);
      if (parts > 1 || !others) PLUMBLINE_TRY(mesh.files.read(sink, *vertices, *workspace, [](const MeshSummary&) {}));
      if (sink.full()) return false;
      joiner.join(parts > 1 || !others ? sink.uses() : *room, others);
    }
  }
  return true;
}

}  // namespace

Expected<SurveyedMesh> read_survey(MeshFiles& files, const Mat3d& rotation, std::optional<std::uint64_t> most_vertices,
                                   Arena& arena, const StageProgress& progress) {
  ModelCopy copy({});
  auto found = survey(files, rotation, most_vertices, arena, progress, copy);
  if (found && copy.is_finished()) PLUMBLINE_TRY(files.keep(copy, arena));
  return found;
}

Expected<MeshHits> read_hits(const PlacedMesh& mesh, Arena& arena, const StageProgress& progress) {
  return hit(mesh, nullptr, arena, progress);
}

Status read_shift(const PlacedMesh& mesh, double by_mm, const TriangleSides& sides, OutlineShift& shift, Arena& arena,
                  const StageProgress& progress) {
  const BottomScope scope(arena);
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(mesh.files.vertices_kept(mesh.survey.most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  shift.clear();
  ShiftSink sink(mesh, progress, sides, shift);
  PLUMBLINE_TRY(mesh.files.read(sink, *vertices, *workspace, [](const MeshSummary&) {}));
  shift.solve(by_mm, mesh.lattice().step());
  return {};
}

std::size_t sides_bytes(std::uint64_t triangles, std::uint64_t most_vertices, std::size_t available) {
  const std::size_t joining = ShellJoiner::bytes_needed(triangles) + bytes_to_read(most_vertices);
  return std::min(available, joining + Arena::rounded(static_cast<std::size_t>(triangles) * kSidesBytesPerTriangle));
}

Status read_sides(const PlacedMesh& mesh, MeshHits& found, Arena& arena, const StageProgress& progress) {
  const BottomScope scope(arena);
  const std::uint64_t triangles = mesh.survey.triangles;
  const std::size_t reading = bytes_to_read(mesh.files.vertices_kept(mesh.survey.most_vertices));
  const std::size_t joining = ShellJoiner::bytes_needed(triangles);
  if (triangles > ShellJoiner::kMostTriangles || joining + reading + kLeastUseRoom > arena.available()) return {};
  auto joiner = ShellJoiner::create(triangles, arena);
  PLUMBLINE_TRY(joiner);
  const auto joined = join(mesh, *joiner, arena, progress.part(0, 0.5));
  PLUMBLINE_TRY(joined);
  if (!*joined) return {};
  const std::uint32_t count = joiner->number();
  const std::size_t after = Arena::rounded(count * sizeof(Shell)) + Arena::rounded(count * sizeof(std::uint32_t)) +
                            TriangleSides::bytes_needed(triangles) + reading + Arena::kAlignment;
  if (count > PackedHit::kMostBodies || 2 * std::uint64_t{count} > triangles || after > arena.available()) return {};
  JoinedShells shells{*joiner, {}};
  PLUMBLINE_TRY(arena.take_bottom(shells.shells, count, kStage));
  std::ranges::fill(shells.shells, Shell{});
  std::span<std::int32_t> balance;
  PLUMBLINE_TRY(arena.take_bottom(balance, count, kStage));
  shells.joiner.drop_cancelled(balance);
  found.hits.release(arena);
  auto sides = TriangleSides::create(triangles, arena);
  PLUMBLINE_TRY(sides);
  auto again = hit(mesh, &shells, arena, progress.part(0.5, 1));
  PLUMBLINE_TRY(again);
  std::span<std::uint32_t> order;
  PLUMBLINE_TRY(arena.take_bottom(order, count, kStage));
  orient_shells(again->hits, shells.shells, order);
  again->hits.change_all([&](const PackedHit& hit) {
    const Shell& shell = shells.shells[hit.body()];
    return again->hits.packing().of_body(hit, shell.body, shell.turns);
  });
  EdgeSum edges;
  for (const Shell& shell : shells.shells) edges.add(shell.edges, shell.turns);
  for (std::size_t i = 0; i < triangles; ++i) {
    const ShellJoiner::Side side = shells.joiner.of(i);
    const bool turned = side.turned != shells.shells[side.shell].turns;
    sides->set(i, turned, side.dropped);
    again->turned += turned && !side.dropped && !side.even ? 1 : 0;
    again->dropped += side.dropped ? 1 : 0;
  }
  again->closed = edges.is_closed();
  again->flat = found.flat;
  again->sides = *sides;
  found = *again;
  return {};
}

Expected<ClosedHoles> close_holes(const PlacedMesh& mesh, MeshHits& found, Arena& arena,
                                  const StageProgress& progress) {
  const BottomScope scope(arena);
  HitList& hits = found.hits;
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(mesh.files.vertices_kept(mesh.survey.most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  auto edges = OpenEdges::create(arena);
  PLUMBLINE_TRY(edges);
  const MeshLattice lattice = mesh.lattice();
  for (const bool users : {false, true}) {
    if (users) PLUMBLINE_TRY(edges->begin_users());
    const StageProgress half = users ? progress.part(0.5, 1) : progress.part(0, 0.5);
    EdgeSink sink(mesh.files, half, lattice, found.sides, *edges, users);
    PLUMBLINE_TRY(mesh.files.read(sink, *vertices, *workspace, [](const MeshSummary&) {}));
    if (edges->full()) return ClosedHoles{};
  }
  const bool whole = edges->runs() <= mesh.survey.triangles / 2;
  if ((!whole && edges->runs() > kMostRim) || small_hole_bytes(edges->runs()) > arena.available()) return ClosedHoles{};
  const auto small = close_small_holes(*edges, lattice.step(), whole ? kMostCorners : 0, arena);
  PLUMBLINE_TRY(small);
  PLUMBLINE_TRY(hits.reopen(arena));
  bool full = false;
  for (const LatticeTriangle& cap : small->caps) {
    for_each_hit(cap, mesh.grid, [&](const RayHit& hit) { full |= !hits.add(hit); });
  }
  if (full) return fail_full(hits);
  PLUMBLINE_TRY(hits.close(arena));
  arena.reset_peak();  // the open list took the rest of the arena
  ClosedHoles closed{small->holes, small->rim.empty(), {}, {}};
  if (small->rim.size() <= kMostRim) {
    const auto rim = arena.take_top<RimCorner>(small->rim.size(), kStage);
    PLUMBLINE_TRY(rim);
    std::ranges::copy(small->rim, rim->begin());
    closed.rim = *rim;
  } else {
    const auto caps = arena.take_top<LatticeTriangle>(small->caps.size(), kStage);
    PLUMBLINE_TRY(caps);
    std::ranges::copy(small->caps, caps->begin());
    closed.caps = *caps;
  }
  return closed;
}

Expected<ReadDipoles> read_dipoles(MeshFiles& files, std::uint64_t most_vertices, const DipoleSurface& surface,
                                   Arena& arena, const StageProgress& progress) {
  const BottomScope scope(arena);
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  auto vertices = VertexList::create(files.vertices_kept(most_vertices), arena);
  PLUMBLINE_TRY(vertices);
  auto dipoles = MeshDipoles::create(surface.box, surface.area, arena);
  PLUMBLINE_TRY(dipoles);
  for (;;) {
    DipoleSink sink(files, progress, surface, *dipoles);
    const Status read = files.read(sink, *vertices, *workspace, [](const MeshSummary&) {});
    if (!read && !sink.full()) return tl::unexpected<Error>(read.error());
    if (read && add_caps(surface, *dipoles)) break;
    dipoles->double_cells();
  }
  const auto cloud = dipoles->to_cloud(arena);
  PLUMBLINE_TRY(cloud);
  return ReadDipoles{*cloud, dipoles->cell()};
}

}  // namespace plumbline::inline slicer
