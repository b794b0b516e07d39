#pragma once
/// A scan becomes a cloud at the top of the arena: admitted, read, thinned (DESIGN sections 2 and 3, stage 1).

#include <cstdint>
#include <optional>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/implicit/winding_number.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline {

struct CloudReadSettings {
  Mat3d rotation = Mat3d::Identity();  ///< from scan axes to print axes
  double first_cell = 0;               ///< of the thinning, scan units; 0: none before the room is used up
  std::optional<PrintGrid> grid;       ///< of the printer, for the plan
  std::uint32_t threads = 1;           ///< for the plan
  bool confidence = false;             ///< for the plan
  bool winding_nodes = false;          ///< whether their room is taken too: they outlive all but the cloud
};

/// What stays at the top of the arena, and what was learned on the way.
struct CloudReading {
  ScanSummaries scans;
  Cloud cloud;  ///< as large as its points
  std::span<WindingTree::Node> winding_nodes;
  Vec3d offset = Vec3d::Zero();  ///< rotated scan coordinates of the cloud's origin
  std::uint32_t room = 0;        ///< points the arena has room for
  std::uint64_t averaged = 0;    ///< scan points that went into another's place
  double cell = 0;               ///< of the thinning, scan units; 0: nothing was averaged
  MemoryPlan plan;               ///< of what the header promised, as far as there is room
};

/// The most points that a scan can have, as its head and the size of its file tell. The head's count alone is a word: it
/// is an upper bound where the reader stops at it, and what makes no room larger than the arena's, ever.
std::optional<std::uint64_t> most_points(const ScanHeader& header, std::optional<std::uint64_t> file_bytes);

/// Reads a scan, which may be in several files: one after the other, in one frame. The job is admitted twice: before the
/// first byte by the printer's grid alone, and when the heads of the files have been read, before the first point, by what
/// they say together. More points than there is room for are thinned.
/// @param sources   1 to kMostScans, each read once from start to end
/// @param progress  may be null
/// @retval ErrorCode::kOutOfMemory  not even kFewestPoints fit: need and budget
/// @retval all of read_scan()
[[nodiscard]] Expected<CloudReading> read_cloud(ScanSources sources, const CloudReadSettings& settings, Arena& arena,
                                                ProgressSink* progress);
[[nodiscard]] inline Expected<CloudReading> read_cloud(ByteSource& source, const CloudReadSettings& settings,
                                                       Arena& arena, ProgressSink* progress) {
  ByteSource* const one[] = {&source};
  return read_cloud(ScanSources(one), settings, arena, progress);
}

}  // namespace plumbline
