#pragma once
/// How many bytes of the arena each stage needs, known before it starts.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/progress.hpp"

namespace plumbline::inline slicer {

struct ViewAlignment;

/// Bytes of the arena in use while each stage runs, with everything that it keeps from earlier stages.
struct MemoryPlan {
  std::uint32_t points = 0;                         ///< of the cloud that the plan is for
  std::array<std::size_t, kStageCount> bytes = {};  ///< by Stage
  std::size_t of(Stage stage) const { return bytes[static_cast<std::size_t>(stage)]; }
  std::size_t peak() const;
  Stage widest() const;  ///< the stage with the peak
};

/// What the rays find.
struct RayYield {
  double rays = 0;       ///< that hit the object
  double crossings = 0;  ///< of all rays
};

/// Bytes of the crossing store: one a ray for its count, two a crossing, four a tile.
std::size_t store_bytes(const PrintGrid& grid, const RayYield& yield);
/// Bytes of the R-Rep: four a crossing, four a layer.
std::size_t rrep_bytes(const PrintGrid& grid, const RayYield& yield);

/// Bytes that stay below the R-Rep of a scan: points for its proof, and the map of evidence.
/// @param points  of the cloud after reading
std::size_t kept_bytes(std::uint32_t points, std::uint32_t layers, bool confidence);

/// Bytes of the stage that makes the R-Rep of a scan, without kept_bytes().
/// @param store  bytes of the crossing store
/// @param rays   of each pixel, with as many crossings each
std::size_t rrep_stage_bytes(const PrintGrid& grid, std::size_t store, const RayYield& yield, std::uint32_t rays = 1);
/// Bytes of the views' stage beside cloud and tree.
std::size_t views_stage_bytes(std::uint32_t views);
/// Bytes that making and checking the masks takes beside map, R-Rep and supports.
std::size_t layers_stage_bytes(const PrintGrid& grid, std::size_t struts, Grey grey);

/// A job that has room for fewer points is refused: their surface would not be worth a print. The value matters only for
/// arenas of a few MiB.
inline constexpr std::uint32_t kFewestPoints = 1000;
/// Larger scans are thinned to this many points, however large the arena. With their tree they take 1.1 GB of it: far
/// more than a board's memory, but so little that no sum of bytes overflows 32 bits.
inline constexpr std::uint32_t kMostPoints = 16'000'000;

/// Points that each thread has room for while it shoots one tile of rays: all of a small cloud, at most 32768.
std::uint32_t tile_capacity(std::uint32_t points);

/// To this share of a scan's points they are joined before rays are shot, where the arena has no room for more (join_points()).
inline constexpr double kLeastJoined = 0.75;

/// Bytes of points, of the nodes of their winding number tree, and of their 2D tree, while rays are shot.
std::size_t ray_points_bytes(std::uint32_t points);
/// @returns points for which that many bytes suffice, but for up to seven more
std::uint32_t ray_points_in(std::size_t bytes);

/// What else a plan depends on.
struct PlanEvidence {
  std::uint64_t reader_bytes = 0;  ///< ScanHeader::reader_bytes, the largest of the scan's files
  std::uint64_t kept_bytes = 0;    ///< ScanAnnouncement::kept_bytes
  std::uint32_t views = kRuns;     ///< ScanAnnouncement::most_views
  bool confidence = false;         ///< SliceSettings::confidence
  Grey grey = Grey::kOff;          ///< SliceSettings::grey
  /// Points that are left when rays are shot: noise has gone and neighbours have been joined. Unknown: as many as the cloud or, if that
  /// is less, `arena_bytes` have room for, but at least kLeastJoined of the cloud's.
  std::optional<std::uint32_t> ray_points = std::nullopt;
  std::size_t arena_bytes = std::numeric_limits<std::size_t>::max();  ///< that the job may use
  /// What the rays will find, if known. Otherwise the object is assumed to cover half of the grid: before the scan is read
  /// its size is unknown, and the board's memory must suffice for all that its panel can show. A smaller object leaves
  /// room unused. A larger one may be refused by admit_rays() once it has been placed.
  std::optional<RayYield> yield = std::nullopt;
};

/// @param grid  of the printer; none: the stages that depend on the grid are planned by admit_rays(), when it is known
MemoryPlan plan_memory(std::uint32_t points, const std::optional<PrintGrid>& grid, std::uint32_t threads,
                       const PlanEvidence& evidence = {});

/// The plan for as many points as fit into `arena_bytes`.
/// @param declared  upper bound of the points of the scan, if known
/// @returns a plan for kFewestPoints to kMostPoints points
/// @retval ErrorCode::kOutOfMemory  not even kFewestPoints fit; the message has need and budget
[[nodiscard]] Expected<MemoryPlan> largest_plan(std::size_t arena_bytes, std::optional<std::uint64_t> declared,
                                                const std::optional<PrintGrid>& grid, std::uint32_t threads,
                                                PlanEvidence evidence = {});

}  // namespace plumbline::inline slicer
