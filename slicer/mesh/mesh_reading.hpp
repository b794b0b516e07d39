#pragma once
/// The readings of a mesh's files: to survey it, to hit its triangles with rays, and to add them up as dipoles.

#include <cstdint>
#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/mesh/hit_list.hpp"
#include "slicer/mesh/mesh_counts.hpp"
#include "slicer/mesh/mesh_files.hpp"
#include "slicer/mesh/mesh_lattice.hpp"
#include "slicer/mesh/mesh_survey.hpp"
#include "slicer/mesh/open/rim_winding.hpp"
#include "slicer/mesh/outline_shift.hpp"
#include "slicer/mesh/shells.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::inline slicer {

// Each reading takes its workspace from the bottom of the arena and gives it back, and fails with ErrorCode::kOutOfMemory, kCancelled
// or the errors of read_mesh().

struct SurveyedMesh {
  MeshSurvey survey;
  MeshCounts counts;    ///< those that need no rays
  ScanSummaries scans;  ///< of each file; the points are its vertices
};
/// @param most_vertices  of a file; none: unknown
[[nodiscard]] Expected<SurveyedMesh> read_survey(MeshFiles& files, const Mat3d& rotation,
                                                 std::optional<std::uint64_t> most_vertices, Arena& arena,
                                                 const StageProgress& progress);

/// A mesh where it is printed.
struct PlacedMesh {
  MeshFiles& files;
  const MeshSurvey& survey;  ///< of the same files
  PrintGrid grid;
  MeshTransform transform;
  const OutlineShift* shift = nullptr;  ///< by which its corners are moved; null: they stay

  MeshLattice lattice() const { return {grid, transform, shift}; }
};

/// Reads the triangles once, to find how their corners move.
/// @param by_mm  see OutlineShift
/// @param sides  of the triangles; empty: as they are in the files
/// @param shift  replaced
/// @retval ErrorCode::kBadSetting  hardly any triangles share corners, so none can move with its neighbours
[[nodiscard]] Status read_shift(const PlacedMesh& mesh, double by_mm, const TriangleSides& sides, OutlineShift& shift,
                                Arena& arena, const StageProgress& progress);

struct MeshHits {
  HitList hits;            ///< sorted, at the top of the arena
  bool closed = false;     ///< EdgeSum
  std::uint64_t flat = 0;  ///< triangles with two corners in one place
  // Set by read_sides():
  TriangleSides sides = {};   ///< at the top of the arena, before the hits; empty: they stay as they are in the files
  std::uint64_t turned = 0;   ///< triangles
  std::uint64_t dropped = 0;  ///< triangles that are there more than once
};
/// @retval ErrorCode::kCannotRead  the files have changed since the survey
[[nodiscard]] Expected<MeshHits> read_hits(const PlacedMesh& mesh, Arena& arena, const StageProgress& progress);

/// Bytes of the arena that read_sides() takes at most, beside the hits.
std::size_t sides_bytes(std::uint64_t triangles, std::uint64_t most_vertices, std::size_t available);

/// Reads the triangles again, to join them to shells (as often as the room for their edges is too small), then once more with the sides
/// that the shells have: Shell, orient_shells(). Changes nothing where there is no room, or hardly any triangle shares an edge with another.
/// @param found  the hits of the same files, the last block taken from the top of the arena; replaced
[[nodiscard]] Status read_sides(const PlacedMesh& mesh, MeshHits& found, Arena& arena, const StageProgress& progress);

struct ClosedHoles {
  std::uint64_t holes = 0;  ///< that were closed
  bool all = false;         ///< the hits are now those of a closed mesh
  // If not, one of these, at the top of the arena. Neither if no hole was closed, and the rim is long or not known.
  std::span<const RimCorner> rim = {};         ///< MeshRim of what is left open
  std::span<const LatticeTriangle> caps = {};  ///< that close the holes; the rim is longer than kMostRim
};
/// Corners of a rim: with more, the winding number of all triangles in cells takes less time.
inline constexpr std::size_t kMostRim = 2048;

/// Reads the triangles twice, to close the small holes of a mesh (close_small_holes()), to add the hits of the caps, and to find the
/// rim of the large ones. It closes none in a mesh most of whose edges are open, or that has more of them than there is room for.
/// @param found  the hits of the same files, the last block taken from the top of the arena
[[nodiscard]] Expected<ClosedHoles> close_holes(const PlacedMesh& mesh, MeshHits& found, Arena& arena,
                                                const StageProgress& progress);

/// What read_dipoles() needs to know of the surface, all of it transformed.
struct DipoleSurface {
  MeshTransform transform;
  Box3f box;
  double area = 0;
  std::span<const LatticeTriangle> caps = {};  ///< count as well
  Vec3d step = Vec3d::Zero();                  ///< of their lattice, mm
  TriangleSides sides = {};
};
struct ReadDipoles {
  Cloud cloud;     ///< MeshDipoles::to_cloud(), at the top of the arena
  float cell = 0;  ///< side of a cell
};
/// @param most_vertices  of a file
[[nodiscard]] Expected<ReadDipoles> read_dipoles(MeshFiles& files, std::uint64_t most_vertices,
                                                 const DipoleSurface& surface, Arena& arena,
                                                 const StageProgress& progress);

}  // namespace plumbline::inline slicer
